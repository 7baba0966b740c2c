// SPDX-License-Identifier: MIT
#pragma once
#include "../../operators/NodalMatrix.h"
#include "../../search/general/FacetLoops.h"
#include "../../search/general/GeneralSearch.h"
#include "../../state/State.h"
#include "../penalty/penalty.h"
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Two edges that have crossed: bodies meet there with no point of either surface behind the other one. Points are
/// those where the edges cross, seen along their common perpendicular.
struct CrossedPair
{
  // Fixed while the pair is a candidate.
  std::int32_t first, second; ///< edges; `first` has the smaller id
  std::int32_t owner;         ///< this rank's facet that has the history
  bool goes_on[2][2];         ///< at the ends of both edges: does another sharp edge go on from there?
  std::int32_t bodies[2];
  double area, height; ///< that the spring stands for, and of the lower cell behind both edges [L^2], [L]
  // Now.
  ContactStatus status = ContactStatus::open;
  std::int32_t nodes[4];
  double weights[4];  ///< of the ends: positive ones of the first edge, negative ones of the second
  double ends[4][3];  ///< positions of the nodes [L]
  double moved[4][3]; ///< displacements of the nodes since the increment began [L]
  double gap;         ///< negative [L]
  double gap_before;  ///< when the increment began [L]
  double normal[3];   ///< unit, out of the second edge's body
  double force;       ///< along the normal, positive in compression [F]
  double tangential[3], slip[3], increment[3]; ///< [F], [L], motion of first against second since the start [L]
  double stiffness, tangential_stiffness;      ///< [F/L]
  double bears, d_bears[2]; ///< part of the spring's stiffness at this place, and its derivatives by the weights [1]
  double part, slope;       ///< of the motion that counts for friction, and its derivative with respect to the force
  // Of the last converged state.
  double depth, last[3], last_slip[3]; ///< penetration, zero of one that was open [L]; tangential force [F], slip [L]
};

/// Springs of crossed edges in general contact, in increments; docs/general_contact.md. Facets of degree 1 in space.
class CrossedEdges
{
public:
  /// @param[in] facets this rank's facets of the surface
  explicit CrossedEdges(const surface::Facets& facets);

  /// Find the edges that have crossed. Collective.
  /// @param[in] pair search of the surface for itself, updated
  /// @param[in] u, start displacements now and when the increment began, owned and ghosts of the space [L]
  void update(const search::PairSearch& pair, const search::GeneralSearch& general, std::span<const double> u,
              std::span<const double> start);
  /// Forces of the pairs, after `update`. Not collective.
  /// @param[in] share_of_body see PenaltyForces
  void evaluate(const PenaltyParameters& parameters, std::span<const double> share_of_body);
  /// Pairs in contact.
  const std::vector<CrossedPair>& closed() const { return _closed; }
  /// Pairs of this rank whose status has changed since the last call.
  int num_changed();

  /// @param[in,out] force by nodes of the map, [node*3 + c] [F]
  void add_force(std::span<double> force) const;
  /// Forces that close gaps of pairs which are closed but apart (PenaltyParameters::touch) [F].
  void add_closing_force(std::span<double> force) const;
  /// @param[in] offset numbers below are keys of other couplings
  void add_couplings(std::int64_t offset, operators::NodalMatrix::Couplings& couplings) const;
  /// Minus the derivative of the forces. @param[in] convex see enforcement::tangent
  void add_tangent(bool convex, operators::NodalMatrix& matrix) const;
  /// Of the springs of this rank [F L].
  double energy() const;
  /// Deepest penetration of this rank, zero without any, and the same over the height of the cells [L], [1].
  double deepest() const;
  double deepest_part() const;

  /// The present state is the last converged one. Collective.
  /// @returns work of friction in the increment, of this rank [F L]
  /// @throws std::runtime_error on all ranks, if a facet has more pairs than a state can hold
  double accept();
  /// Add the history to a state, views of this object's memory by facet.
  void add_to(state::State& state);
  static std::span<const std::string> state_names();

private:
  void list(const search::PairSearch& pair, const search::GeneralSearch& general);
  bool cross(CrossedPair& pair, std::span<const double> moved) const;
  void find_ends(std::span<const std::int32_t> sharp);
  void read_history(CrossedPair& pair) const;

  surface::Facets _facets;
  std::shared_ptr<const search::Exchange> _exchange;
  search::FacetLoops _loops;
  std::vector<double> _X, _x, _start; ///< by nodes of the map [L]
  double _friction = 0.0;
  std::vector<std::array<bool, 2>> _goes_on; ///< of all edges, as CrossedPair::goes_on
  std::vector<CrossedPair> _candidates, _crossed, _closed;
  std::vector<std::pair<std::array<std::int64_t, 2>, ContactStatus>> _seen;
  // History by facet: ids of the edges of its pairs, -1: none; and depth, tangential force and slip of each.
  std::vector<std::int64_t> _keys;
  std::vector<double> _values;
};
} // namespace dolfinx_impact::enforcement
