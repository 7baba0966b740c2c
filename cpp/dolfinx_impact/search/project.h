#pragma once
#include "../surface/normals.h"
#include "BoxTree.h"
#include <limits>

namespace impact::search
{
/// Where on its facet a closest point lies.
enum class ProjectionStatus : std::int8_t
{
  converged = 0, ///< inside the facet
  edge = 1,      ///< on an edge (in the plane: never)
  vertex = 2,    ///< at a vertex
  outside = 3    ///< no facet within reach: the point is open
};

/// Closest point of a surface to a point.
struct Projection
{
  ProjectionStatus status = ProjectionStatus::outside;
  std::int32_t facet = -1; ///< of the master's Facets
  double xi[2] = {0.0, 0.0};
  double gap = std::numeric_limits<double>::infinity(); ///< docs/contact.md: positive outside the master [L]
  double normal[3] = {0.0, 0.0, 0.0};                   ///< unit, out of the master
};
} // namespace impact::search
