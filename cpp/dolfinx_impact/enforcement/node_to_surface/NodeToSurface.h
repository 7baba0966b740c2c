// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/Rigid.h"
#include "../../search/node_tracker/NodeTracker.h"
#include "../ContactStatus.h"
#include "../friction.h"
#include "NodalContact.h"
#include "NodeCandidates.h"
#include <array>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// What every contact of nodes with a surface is told.
struct NodeToSurfaceOptions
{
  double friction = 0.0;        ///< coefficient [1]
  double search_distance = 0.0; ///< 0: the largest facet's diameter [L]
  bool axisymmetric = false;    ///< nodal areas times 2 pi R
};

/// The slave nodes this rank owns, in the last step. Vectors per node: [i*gdim + c].
struct NodalResults
{
  std::vector<ContactStatus> status;
  std::vector<double> gap;      ///< of open nodes: when they were evaluated last; infinite without master [L]
  std::vector<double> normal;   ///< out of the master
  std::vector<double> pressure; ///< normal force per area of the node [F/L^2]
  std::vector<double> traction; ///< force on the slave per area [F/L^2]
  std::vector<double> slip;     ///< since the node closed [L]
};

/// What a checkpoint needs of any contact, by owned slave node, for the run to go on bit for bit.
struct NodalHistory
{
  std::vector<double> tangential;  ///< forces [i*gdim + c] [F]
  std::vector<double> slip;        ///< [i*gdim + c] [L]
  std::vector<double> xi;          ///< reference coordinates on the master's facet, [2*i + alpha]
  std::vector<std::int8_t> closed; ///< 1: in contact; -1: marked, see docs/explicit/penalty.md; else 0
  std::vector<std::int64_t> facet; ///< id of the master's facet it is tracked on, or -1
};

/// Slave nodes against the master's surface or a rigid obstacle, step after step: which nodes meet it, where, and
/// whether they have come through the surface (docs/explicit/penalty.md). What forces they get is that of the classes
/// derived from it.
class NodeToSurface : public NodalContact
{
public:
  void search(std::span<const double> u, std::span<const double> du) override;
  std::span<const std::int64_t> remote_nodes() const override { return _candidates.remote_nodes(); }
  std::span<const int> remote_owners() const override { return _candidates.remote_owners(); }
  std::span<const std::int32_t> needs(operators::Halo& all) override;
  void number(operators::Halo& halo, std::span<const std::int32_t> numbers, const double* mass) override;
  double used(const NodalState& state) const override { return _candidates.used(state); }
  void forget_search() override { _candidates.forget(); }
  void update_gaps(const double* u) override;
  ContactEnergy energy() const override { return _energy; }
  Passage passage() const override { return _passage; }
  const double* force() const override { return _force.data(); }
  void set_obstacle(const std::array<double, 3>& displacement, const std::array<double, 3>& increment) override;

  const NodeCandidates& candidates() const { return _candidates; }
  const NodalResults& results() const { return _results; }
  const search::NodeTracker& tracker() const { return _tracker; }
  /// How many nodes were left open because they were first seen too deep inside the master.
  std::int64_t implausible() const { return _implausible; }
  NodalHistory history() const;
  /// @throws std::invalid_argument for arrays of wrong sizes
  void set_history(const NodalHistory& history);
  /// Energies without those of another direction, for checkpoints.
  const ContactEnergy& own_energy() const { return _energy; }
  void set_energy(const ContactEnergy& energy) { _energy = energy; }
  /// For tests of tests: facing is judged by the normals of the last search.
  virtual void keep_normals(bool keep) { _tracker.keep_normals(keep); }

protected:
  /// A slave node and what it touches.
  struct Touch
  {
    std::size_t i;
    std::int32_t node;
    int num = 0;                           ///< master nodes
    const std::int32_t* masters = nullptr; ///< numbers
    const std::int32_t* corners = nullptr; ///< positions in NodeTracker's list of them
    double phi[surface::FacetElement::max_nodes];
    search::Projection at;
  };
  static constexpr std::int8_t marked = -1; ///< of `_closed`: open until its gap is positive

  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] slave this rank's facets (make_surface)
  /// @param[in] master this rank's facets; null: rigid
  /// @param[in] rigid the obstacle; null: deformable
  /// @throws std::invalid_argument on all ranks for options out of range, facets of another space
  NodeToSurface(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master,
                const gap::Rigid* rigid, const NodeToSurfaceOptions& options);

  /// Penetration of the deepest closed node, whose facet must stay a candidate [L].
  virtual double deepest() const { return 0.0; }
  /// Node i opens without having left through the surface; its tangential force is still known.
  virtual void lose(std::size_t) {}

  /// Find what node i meets.
  /// @param[in] reach gaps beyond this are open [L]
  /// @param[in] keeps does a node that was closed count whatever its gap?
  /// @returns does the node meet the master? Else it is open
  bool meets(std::size_t i, const double* u, const double* du, double reach, bool keeps, Touch& touch);
  void open(std::size_t i, const search::Projection& at, const double* u);
  /// What node i meets of a rigid master, in the configuration u - back*du.
  search::Projection rigid_point(std::size_t i, const double* u, const double* du = nullptr, double back = 0.0) const;
  /// Do contact forces need a moment given back?
  bool turns() const { return !_rigid && !_options.axisymmetric; }
  std::size_t num_nodes() const { return _closed.size(); }

  NodeToSurfaceOptions _options;
  int _gdim;
  bool _rigid;
  gap::Rigid _obstacle;
  std::array<double, 3> _obstacle_increment{};
  NodeCandidates _candidates;
  search::NodeTracker _tracker;
  operators::Halo* _halo = nullptr;
  std::vector<double> _inverse_mass, _per_area; ///< of slave nodes: reciprocals of masses and areas
  NodalResults _results;
  std::vector<double> _tangential;
  std::vector<std::int8_t> _closed;
  ContactEnergy _energy;
  std::array<double, 3> _force{};
  Passage _passage;

private:
  bool is_marked(const Touch& touch, const double* u, const double* du);
  /// Closest point in the configuration u - back*du.
  search::Projection point_before(std::size_t i, const double* u, const double* du, double back) const;
  /// Motion of the step relative to the master's point.
  void relative_motion(std::size_t i, const search::Projection& at, const double* du, double* motion) const;
  /// Follows a node along its way in the step. @returns whether it went through too fast to be held back
  bool passes(Touch& touch, const double* u, const double* du);

  // By the numbers of the Halo that `needs` was given: nodes, candidates, areas of master nodes.
  std::vector<std::int32_t> _needed;
  surface::Facets _facets, _around; ///< candidates; slave facets at the nodes
  std::vector<double> _areas;
  std::int64_t _implausible = 0;
};
} // namespace dolfinx_impact::enforcement
