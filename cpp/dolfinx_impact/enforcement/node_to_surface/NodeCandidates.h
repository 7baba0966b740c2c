// SPDX-License-Identifier: MIT
#pragma once
#include "../../operators/Halo.h"
#include "../../search/facet_exchange.h"
#include "../../surface/Surface.h"
#include "NodalContact.h"
#include <memory>

namespace dolfinx_impact::enforcement
{
/// The slave nodes that a rank owns, whether or not it has a facet at them, and the master facets of all ranks that
/// come near: searched anew only when the bodies have moved so much against each other that others could come near.
class NodeCandidates
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] slave, master this rank's facets (make_surface); master null: rigid
  /// @param[in] distance search distance; 0: the largest facet's diameter [L]
  NodeCandidates(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master,
                 double distance, bool axisymmetric);

  int gdim() const { return _slave.gdim; }
  bool rigid() const { return _rigid; }
  double distance() const { return _distance; }
  /// Numbers of the slave nodes this rank owns, ascending; reference positions and areas.
  std::span<const std::int32_t> nodes() const { return _nodes; }
  const std::vector<double>& X() const { return _X; }
  const std::vector<double>& areas() const { return _areas; }
  /// Largest facet of slave and master, corner to corner; the smallest of the master (rigid: the largest of the slave)
  /// [L].
  double size() const { return _size; }
  double smallest() const { return _smallest; }

  /// See NodalContact::search.
  /// @param[in] deepest penetration of a node in contact, which needs its facet as far away as that [L]
  void search(std::span<const double> u, std::span<const double> du, double deepest);
  std::span<const std::int64_t> remote_nodes() const { return _remote_nodes; }
  std::span<const int> remote_owners() const { return _remote_owners; }
  /// The candidates, numbered as the Halo's nodes. Where facets share a node, their positions of it are made the same,
  /// to the last bit. Collective.
  surface::Facets numbered(operators::Halo& halo) const;
  /// All slave facets at nodes(), of whatever rank, numbered as the Halo's nodes.
  surface::Facets around(const operators::Halo& halo) const;
  /// The numbers of nodes() and watched() in the arrays of NodalState, from those in the space.
  void number(std::span<const std::int32_t> numbers);
  std::span<const std::int32_t> numbers() const { return _numbers; }
  std::span<const std::int32_t> watched_numbers() const { return _watched_numbers; }
  /// Areas of the master's nodes over the Halo's. Collective.
  std::vector<double> master_areas(operators::Halo& halo) const;
  /// Slave and master nodes that this rank owns.
  std::span<const std::int32_t> watched() const { return _watched; }
  /// A step of this length has been made.
  void advance(double dt);
  /// See NodalContact::used.
  double used(const NodalState& state) const;
  /// See NodalContact::forget.
  void forget();
  std::int64_t searches() const { return _searches; }

private:
  void find_nodes(const surface::FunctionSpace& V, bool axisymmetric);
  void mean_motion(std::span<const double> du);

  bool _rigid;
  MPI_Comm _comm;
  double _distance, _size = 0.0, _smallest = 0.0;
  mutable operators::Halo _halo; ///< of the space
  surface::Facets _slave;
  search::FacetPackets _mine; ///< this rank's master facets
  std::vector<std::int32_t> _nodes, _watched, _numbers, _watched_numbers;
  std::vector<double> _watched_X, _X, _areas, _master_areas;
  search::FacetPackets _found, _around; ///< candidates; slave facets at nodes()
  std::vector<std::int64_t> _remote_nodes;
  std::vector<int> _remote_owners;
  std::vector<double> _u; ///< displacements over the space's nodes
  // Motion since the last search, against what its translation would have been at the mean velocity before.
  std::vector<double> _from; ///< displacements of the watched nodes at the last search
  double _room = 0.0, _time = 0.0, _mean[3] = {}, _velocity[3] = {};
  double _step = 0.0;                 ///< largest motion of a watched node in a step, less the mean
  bool _fresh = true, _known = false; ///< _known: where the nodes were at an earlier search
  std::int64_t _searches = 0;
};
} // namespace dolfinx_impact::enforcement
