// SPDX-License-Identifier: MIT
#pragma once
#include "facet_projection.h"
#include <limits>

namespace dolfinx_impact::search
{
/// Closest point of a surface to a point.
struct Projection
{
  ProjectionStatus status = ProjectionStatus::outside;
  std::int8_t entity = -1; ///< number of the edge or vertex of the facet
  enum class Rim : std::int8_t
  {
    no,     ///< the closest point is not on the outer rim, or the node right over it (SurfaceSearch: or near, below)
    near,   ///< beside it by less than a twentieth of the facet, or on it: gap and normal are those of the facet
    beside, ///< beside the rim, not below the facet's plane
    below   ///< beside the rim, below the facet's plane
  } rim = Rim::no;
  std::int32_t facet = -1; ///< of the master's Facets
  double xi[2] = {0.0, 0.0};
  double gap = std::numeric_limits<double>::infinity(); ///< docs/contact.md: positive outside the master [L]
  double normal[3] = {0.0, 0.0, 0.0};                   ///< unit, out of the master
  /// Is the normal that of the facet? Otherwise it is the direction from an edge or vertex.
  bool on_facet() const { return status == ProjectionStatus::converged || rim == Rim::near; }
  /// Lower bound on the relative motion of point and surface before penetration (set by NodeTracker only) [L].
  double clearance = std::numeric_limits<double>::infinity();
};
} // namespace dolfinx_impact::search
