// SPDX-License-Identifier: MIT
#pragma once
#include "../../surface/Surface.h"
#include "NamedPair.h"
#include <cstdint>
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// What contact without pairs asks of the nodes that this rank owns, wherever their facets are.
struct SurfaceNodes
{
  SurfaceNodes() = default;
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] facets this rank's facets of the surface (make_surface)
  /// @param[in] named pairs of surfaces that are left to others
  /// @throws std::invalid_argument on all ranks for too many pairs
  SurfaceNodes(const surface::FunctionSpace& V, const surface::Facets& facets, std::span<const NamedPair> named);

  std::vector<double> height;       ///< of the lowest cell behind a facet of the node; zero off the surface [L]
  std::vector<std::int64_t> groups; ///< bits of the named surfaces that the node belongs to, two for each pair
  std::vector<std::int32_t> body;   ///< the same on all ranks
  int num_bodies = 0;               ///< of the mesh
  std::size_t num_named = 0;

  /// Are two places, by bits of surfaces that they belong to, slave and master of a named pair? Not collective.
  bool left_out(std::int64_t one, std::int64_t other) const;
};
} // namespace dolfinx_impact::search
