// SPDX-License-Identifier: MIT
#pragma once
#include "../surface/Surface.h"
#include <dolfinx/common/IndexMap.h>
#include <dolfinx/la/Vector.h>
#include <memory>
#include <span>

namespace dolfinx_impact::search
{
/// The facets of a pair as this rank needs them: its own slave facets, and all master facets, its own or of other
/// ranks, whose boxes come within `reach` of the box of its slave facets. Master facets are sent only between ranks
/// whose boxes overlap, in neighbourhood collectives; no rank holds the whole surface. Both structs number their nodes
/// by one nodal map: the owned blocks of the displacement space first, then ghosts.
class Exchange
{
public:
  /// Collective over the mesh's ranks. A rank may have no slave facets, no master facets, or neither.
  /// @param[in] V displacement space
  /// @param[in] slave, master this rank's facets (make_surface), moved to the configuration to search in
  /// @param[in] reach master facets are kept whose boxes come within it of the box around all slave facets of the rank:
  /// the largest distance at which facets are to be paired, and what both surfaces may move before the next Exchange
  /// [L]
  /// @throws std::invalid_argument for facets of another dimension or a negative reach
  Exchange(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets& master, double reach);

  /// This rank's slave facets, in the order in which they were given.
  const surface::Facets& slave() const { return _slave; }
  /// Candidates, sorted by their id.
  const surface::Facets& master() const { return _master; }
  /// Nodal map: owned blocks of V with V's global numbers, then the ghosts that slave and candidate facets need.
  std::shared_ptr<const dolfinx::common::IndexMap> map() const { return _values->index_map(); }
  /// Number of entries of a vector over the map: gdim * (owned + ghosts).
  std::size_t size() const { return _values->array().size(); }
  /// Values at the map's nodes from those of the space. Collective.
  /// @param[in] u owned (and ghost) entries of a vector of V
  /// @param[out] values size()
  void forward(std::span<const double> u, std::span<double> values) const;
  /// Add values at the map's nodes, ghosts included, to their owners' entries of a vector of V. Collective.
  /// @param[in] values size()
  /// @param[in,out] b owned (and ghost) entries of a vector of V; ghosts are left as they are
  void reverse(std::span<const double> values, std::span<double> b) const;
  /// Move both surfaces to X + u. Collective.
  void move(std::span<const double> u);

private:
  surface::Facets _slave, _master;
  std::unique_ptr<dolfinx::la::Vector<double>> _values; ///< over the map; also the buffer of what is sent
};
} // namespace dolfinx_impact::search
