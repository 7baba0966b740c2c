// SPDX-License-Identifier: MIT
#pragma once
#include "TrackedSurface.h"
#include <limits>

namespace dolfinx_impact::search
{
/// Which facets count for a slave node, by their distances. The facets of a node in contact count however deep it is.
struct SearchRange
{
  std::int32_t node = -1;     ///< number of the slave node in the arrays of displacements
  bool tracked = false;       ///< the node is in contact
  double reach = 0.0;         ///< search distance: facets within it count [L]
  double widest = 0.0;        ///< facets beyond it never count [L]
  const double* du = nullptr; ///< increments of the step; null: only facets within `reach` count [L]

  /// Distance up to which facets have to be looked for [L].
  double radius() const { return tracked ? std::numeric_limits<double>::infinity() : widest; }
  /// Does a facet with this closest point count? It does within `reach`, or within twice the motion of the step of the
  /// node against the closest point.
  bool contains(const TrackedSurface& surface, std::int32_t facet, const FacetProjection& at) const
  {
    if (at.distance <= reach || tracked)
      return true;
    return du && at.distance <= widest && within_motion(surface, facet, at);
  }

private:
  bool within_motion(const TrackedSurface& surface, std::int32_t facet, const FacetProjection& at) const
  {
    const surface::Facets& facets = surface.facets();
    double phi[surface::FacetElement::max_nodes], squared = 0.0;
    facets.displacement.values(at.xi, phi);
    for (int c = 0; c < facets.gdim; ++c)
    {
      double d = du[std::size_t(node) * facets.gdim + c];
      for (int j = 0; j < facets.displacement.num_nodes(); ++j)
        d -= phi[j] * du[std::size_t(facets.nodes_of(facet)[j]) * facets.gdim + c];
      squared += d * d;
    }
    return at.distance * at.distance <= 4 * squared;
  }
};
} // namespace dolfinx_impact::search
