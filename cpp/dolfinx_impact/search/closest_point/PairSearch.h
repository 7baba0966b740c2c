// SPDX-License-Identifier: MIT
#pragma once
#include "../Exchange.h"
#include "SurfaceSearch.h"
#include <memory>
#include <vector>

namespace dolfinx_impact::search
{
/// Two deformable surfaces as they move. Candidates are exchanged with a margin and kept as long as it holds; the tree
/// of the master's boxes is refitted.
class PairSearch
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] slave, master this rank's facets (make_surface)
  /// @param[in] reach within which slave and master are paired when nothing moves; 0: twice the largest facet [L]
  PairSearch(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave, surface::Facets master,
             double reach = 0.0);

  /// Move both surfaces and search anew where that is needed. Surfaces may have passed through each other by as much as
  /// they moved since `start`: no contact is missed. Collective.
  /// @param[in] u, start displacements, owned and ghosts [L]
  void update(std::span<const double> u, std::span<const double> start);

  /// Exchange candidates in the next update, whatever has moved: what follows does not depend on earlier updates, as
  /// after a restart.
  void forget() { _built_reach = 0.0; }

  /// Facets after `update`; their nodes are numbered by `map`.
  const surface::Facets& slave() const { return _exchange->slave(); }
  const surface::Facets& master() const { return _exchange->master(); }
  std::shared_ptr<const dolfinx::common::IndexMap> map() const { return _exchange->map(); }
  std::shared_ptr<const Exchange> exchange() const { return _exchange; }
  /// Search distance of the last update [L].
  double reach() const { return _reach; }
  /// Bound on the motion of two nodes of the surfaces against each other since the start, in the last update [L].
  double motion() const { return _motion; }
  /// Did the last update keep the candidates and their numbers?
  bool kept() const { return _kept; }
  /// Closest points of the master as it is now.
  const SurfaceSearch& closest();
  /// How often candidates were exchanged so far.
  int num_exchanges() const { return _num_exchanges; }

private:
  double largest_distance(std::span<const double> u, std::span<const double> from) const;

  std::shared_ptr<const surface::FunctionSpace> _space;
  surface::Facets _slave, _master; ///< as given
  double _rest_reach, _reach = 0.0, _built_reach = 0.0, _motion = 0.0;
  bool _kept = false, _stale = true;
  int _num_exchanges = 0;
  std::vector<double> _built; ///< displacements at the last exchange
  std::shared_ptr<Exchange> _exchange;
  std::unique_ptr<SurfaceSearch> _closest;
};
} // namespace dolfinx_impact::search
