// SPDX-License-Identifier: MIT
#pragma once
#include "../../operators/NodalMatrix.h"
#include "../../search/closest_point/PairSearch.h"
#include "../../search/general/GeneralSearch.h"
#include "../general/CrossedEdges.h"
#include "LawPoints.h"
#include "penalty.h"
#include <memory>
#include <optional>
#include <petscvec.h>

namespace dolfinx_impact::enforcement
{
/// Search, gaps and tractions of one pair at the slave's quadrature points, and the forces and the tangent that follow
/// from them. Increments are QuadraturePenalty's; PenaltyHistory is what they change.
class PenaltyForces
{
public:
  /// What a pair consists of, and where its points are.
  struct Setup
  {
    std::shared_ptr<const surface::FunctionSpace> V;   ///< displacement space
    surface::Facets slave;                             ///< this rank's facets (make_surface)
    std::span<const double> points, weights;           ///< rule on the slave's reference facet
    bool axisymmetric = false;                         ///< x is the radius
    std::shared_ptr<const InterfaceLaw> law = nullptr; ///< in the place of the penalties; null: none
  };

  /// A deformable master. Collective.
  /// @param[in] search_distance see search::PairSearch [L]
  PenaltyForces(const Setup& setup, const surface::Facets& master, double search_distance = 0.0);
  /// The slave meets itself: general contact. Collective.
  /// @param[in] general of the slave's facets
  PenaltyForces(const Setup& setup, std::unique_ptr<search::GeneralSearch> general);
  /// A rigid one; it may be moved between updates (Rigid::displacement).
  PenaltyForces(Setup setup, std::shared_ptr<const gap::Rigid> master);

  PenaltyParameters parameters;
  /// General contact: part of the penalties that each body bears; a point has the smaller one of both bodies [1].
  std::vector<double> share_of_body;

  /// Closest points and gaps. Collective.
  /// @param[in] u, start displacements, now and when the step began, owned and ghosts [L]
  /// @param[in] stay points a little beside the facet that they were on stay on it
  void update_gap(std::span<const double> u, std::span<const double> start, bool stay = false);
  /// Pressures, tractions, slips and status, after update_gap. Collective.
  /// @param[in] increment displacements since the step began, owned and ghosts [L]
  /// @param[in] rigid_increment that of a rigid master
  void evaluate(std::span<const double> increment, const RigidIncrement& rigid_increment = {});
  /// Evaluate again, with another PenaltyParameters::touch.
  void evaluate();
  /// The tractions of a law of the interface are those of the last converged state.
  void resume_law();

  /// Subtract the contact forces from a residual, whose entries are those of V's owned nodes. Collective.
  void add_residual(Vec b) const;
  /// Contact forces on both bodies, owned entries [F]. Collective.
  std::vector<double> contact_forces() const;
  /// Forces of `stretched`: they draw closed points that are apart together, owned entries [F]. Collective.
  std::vector<double> closing_forces() const;
  /// Minus the derivative of the contact forces, V's entries; borrowed, valid until the next call. Collective.
  /// @param[in] convex its positive semi-definite part, see enforcement::tangent
  Mat tangent(bool convex = false);
  /// Forget candidates and the places of the tangent, so that runs with and without a restart go on alike.
  void forget();
  /// The state is that of the last converged step from now on.
  void accept_step() { advance(_state, history); }

  /// Points of a law of the interface; null: there is none.
  LawPoints* law() { return _law ? &*_law : nullptr; }
  const LawPoints* law() const { return _law ? &*_law : nullptr; }
  gap::Points& points() { return _points; }
  const gap::Points& points() const { return _points; }
  const PenaltyState& state() const { return _state; }
  PenaltyHistory history;
  /// Facets after update_gap, and the map that numbers their nodes.
  const surface::Facets& slave() const { return _search ? _search->slave() : _slave; }
  const surface::Facets* master() const { return _search ? &_search->master() : nullptr; }
  std::shared_ptr<const dolfinx::common::IndexMap> map() const;
  /// Search of a deformable master, else null.
  search::PairSearch* search() { return _search.get(); }
  const search::PairSearch* search() const { return _search.get(); }
  /// Search of general contact, else null.
  const search::GeneralSearch* general() const { return _general.get(); }
  /// Springs of crossed edges of general contact in space, else null.
  CrossedEdges* edges() { return _edges ? &*_edges : nullptr; }
  const CrossedEdges* edges() const { return _edges ? &*_edges : nullptr; }
  /// Part of the penalties that a point has [1].
  double share_of(std::size_t q) const { return _share.empty() ? 1.0 : _share[q]; }
  /// Energy of springs whose gradient is minus the contact force, without friction and multipliers; this rank's part
  /// [F L].
  double energy() const { return enforcement::energy(pair(), _state); }

private:
  PenaltyForces(Setup setup, std::unique_ptr<search::PairSearch> search, std::shared_ptr<const gap::Rigid> rigid);
  PenaltyPair pair() const;
  std::vector<double> nodal_forces(const PenaltyState& state, bool closing) const;
  void evaluate_law();
  void update_shares();

  std::shared_ptr<const surface::FunctionSpace> _space;
  surface::Facets _slave; ///< moved with u where the master is rigid
  std::shared_ptr<const gap::Rigid> _rigid;
  std::unique_ptr<search::PairSearch> _search;
  std::unique_ptr<search::GeneralSearch> _general;
  std::optional<CrossedEdges> _edges;
  std::vector<double> _share; ///< by point; empty: all of the penalties [1]
  gap::Points _points;
  std::optional<LawPoints> _law;
  PenaltyState _state;
  std::vector<double> _increment; ///< by nodes of the map
  RigidIncrement _rigid_increment{};
  operators::NodalMatrix _matrix;
};
} // namespace dolfinx_impact::enforcement
