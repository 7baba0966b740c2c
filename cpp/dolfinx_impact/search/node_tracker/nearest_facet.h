// SPDX-License-Identifier: MIT
#pragma once
#include "NearFacets.h"
#include "SearchRange.h"

namespace dolfinx_impact::search
{
/// A search for the nearest facet that faces a node, in the tree of all facets.
struct NodeQuery
{
  double x[3];                 ///< position of the node [L]
  const double* normal;        ///< of the slave at the node; only facets that face it are considered
  Configuration configuration; ///< of the surface
  SearchRange range;           ///< which facets count
  std::int32_t tracked_facet;  ///< facet the node is in contact with, or -1
  const double* tracked_xi;    ///< reference coordinates on that facet
  double slack;                ///< largest motion of a facet since the tree was fitted, `shift` left out [L]
  const double* shift;         ///< translation since the tree was fitted [L]
};

/// Path of a node for which a list of candidates is made, in diameters of its nearest facet.
inline constexpr double list_path = 0.5;

/// Closest point of the surface.
/// @param[in,out] near empty; on return all facets that can become the nearest one while node and surface move against
/// each other by `list_path`, as far as there is room for them in a list of `most`
/// @param[out] distance of the nearest facet; undefined if there is none [L]
Projection nearest_facet(const TrackedSurface& surface, const NodeQuery& query, int most, NearFacets& near,
                         double& distance);
} // namespace dolfinx_impact::search
