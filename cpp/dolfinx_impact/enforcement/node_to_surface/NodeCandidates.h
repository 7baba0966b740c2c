// SPDX-License-Identifier: MIT
#pragma once
#include "../../operators/Halo.h"
#include "../../search/facet_exchange.h"
#include "../../surface/Surface.h"
#include "NodalContact.h"
#include <limits>
#include <memory>

namespace dolfinx_impact::enforcement
{
/// The slave nodes that a rank owns (with or without a facet on this rank) and the master facets of all ranks near
/// them. A new search is due only when the bodies have moved so far relative to each other that other facets may be
/// near.
class NodeCandidates
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] slave, master this rank's facets (make_surface); master null: rigid
  /// @param[in] distance search distance; 0 means the largest facet diameter [L]
  NodeCandidates(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master,
                 double distance, bool axisymmetric);

  int gdim() const { return _slave.gdim; }
  MPI_Comm comm() const { return _comm; }
  /// This rank's slave facets, flat; nodes number the blocks of the space.
  const surface::Facets& slave() const { return _slave; }
  /// This rank's master facets; none: rigid.
  const surface::Facets& master() const { return _mine.facets; }
  bool rigid() const { return _rigid; }
  double distance() const { return _distance; }
  /// Slave and master may each move by half of this before the next search [L].
  double room() const { return _room; }
  /// Slave nodes that this rank owns, ascending; X(): reference positions [L], areas(): nodal areas [L^2].
  std::span<const std::int32_t> nodes() const { return _nodes; }
  const std::vector<double>& X() const { return _undeformed; }
  const std::vector<double>& areas() const { return _areas; }
  /// Largest facet diameter of slave and master; smallest() is that of the master (rigid: largest of the slave) [L].
  double size() const { return _size; }
  double smallest() const { return _smallest; }
  /// Number of nodes of the space that this rank owns.
  std::size_t num_owned() const { return _halo.num_owned(); }

  /// See NodalContact::search.
  /// @param[in] deepest deepest penetration of a closed node; it extends the search distance [L]
  void search(std::span<const double> u, std::span<const double> du, double deepest);
  std::span<const std::int64_t> remote_nodes() const { return _remote_nodes; }
  std::span<const int> remote_owners() const { return _remote_owners; }
  /// Candidate facets in the Halo's numbering. Facets that share a node get bitwise equal positions of it. Collective.
  surface::Facets numbered(operators::Halo& halo) const;
  /// All slave facets at nodes(), of all ranks, in the Halo's numbering.
  surface::Facets around(const operators::Halo& halo) const;
  /// Set numbers() and watched_numbers(): positions of nodes() and watched() in the arrays of NodalState.
  void assign_numbers(std::span<const std::int32_t> numbers);
  std::span<const std::int32_t> numbers() const { return _numbers; }
  std::span<const std::int32_t> watched_numbers() const { return _watched_numbers; }
  /// Nodal areas of the master over the Halo's nodes [L^2]. Collective.
  std::vector<double> master_areas(operators::Halo& halo) const;
  /// The same of owned nodes of the space.
  std::span<const double> master_areas() const { return _master_areas; }
  /// Slave and master nodes that this rank owns.
  std::span<const std::int32_t> watched() const { return _watched; }
  /// Advance the time since the last search by a step of this size [T].
  void advance(double dt);
  /// See NodalContact::used.
  double increment_used(const NodalState& state) const;
  /// See NodalContact::forget_search.
  void forget();
  std::int64_t searches() const { return _searches; }

private:
  void find_nodes(const surface::FunctionSpace& V, bool axisymmetric);
  void mean_motion(std::span<const double> du);
  bool surely_near(const NodalState& state, double& used) const;

  bool _rigid;
  MPI_Comm _comm;
  double _distance, _size = 0.0, _smallest = 0.0;
  mutable operators::Halo _halo; ///< of the space
  surface::Facets _slave;
  search::FacetPackets _mine;   ///< this rank's master facets
  std::vector<double> _offsets; ///< of smooth ones: surface::offset_components
  std::vector<std::int32_t> _nodes, _watched, _numbers, _watched_numbers;
  std::vector<double> _watched_X, _undeformed, _areas, _master_areas;
  search::FacetPackets _found, _slave_facets; ///< candidates; slave facets at nodes()
  std::vector<std::int64_t> _remote_nodes;
  std::vector<int> _remote_owners;
  std::vector<double> _u; ///< displacements over the space's nodes
  // Motion since the last search, relative to a translation at the mean velocity before that search.
  std::vector<double> _from; ///< displacements of the watched nodes at the last search
  double _room = 0.0, _time = 0.0, _mean[3] = {}, _velocity[3] = {};
  double _step = 0.0; ///< largest increment of a watched node minus the mean increment
  /// Upper bound of this motion, summed up step by step from that of the nodes at some step, and the time it holds at.
  mutable double _motion_bound = std::numeric_limits<double>::infinity(), _bound_time = 0.0;
  bool _fresh = true, _known = false; ///< _known: an earlier search exists
  std::int64_t _searches = 0;
};
} // namespace dolfinx_impact::enforcement
