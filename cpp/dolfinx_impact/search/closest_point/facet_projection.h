// SPDX-License-Identifier: MIT
#pragma once
#include "../../surface/FacetElement.h"
#include <cmath>
#include <cstdint>

namespace dolfinx_impact::search
{
/// Two surfaces face each other where the scalar product of their unit normals is below minus this. Sides of blocks are
/// often at right angles to a surface, and round-off, which differs from processor to processor, must not decide there.
constexpr double right_angle = 1e-9;

/// Where on its facet a closest point lies.
enum class ProjectionStatus : std::int8_t
{
  converged = 0, ///< inside the facet
  edge = 1,      ///< on an edge (in the plane: never)
  vertex = 2,    ///< at a vertex
  outside = 3    ///< no facet within reach: the point is open
};

/// Closest point of one facet.
struct FacetProjection
{
  ProjectionStatus status = ProjectionStatus::outside;
  std::int8_t entity = -1; ///< number of the edge or vertex
  double xi[2] = {0.0, 0.0};
  double x[3] = {0.0, 0.0, 0.0}; ///< position [L]
  double distance = 0.0;         ///< [L]
};

/// Is a closer than the best facet so far? Where distances are equal to 1e-12 of them and of the facet's size, points
/// inside come first, then the lowest id.
inline bool closer(const FacetProjection& a, std::int64_t id, const FacetProjection& best, std::int64_t best_id,
                   double best_size)
{
  if (std::abs(a.distance - best.distance) > 1e-12 * (best.distance + best_size))
    return a.distance < best.distance;
  const bool a_inside = a.status == ProjectionStatus::converged, b_inside = best.status == ProjectionStatus::converged;
  return a_inside != b_inside ? a_inside : id < best_id;
}

/// From how many places Newton's method starts on a facet.
enum class Starts
{
  nearest, ///< of nodes and centre: enough where the squared distance is a convex function on the facet
  lowest,  ///< all nodes that are nearer to the point than those around them
  all
};

/// Closest point of a facet: all stationary points of the distance inside (Newton's method with backtracking, from one
/// start or from several), on the edges (roots of a cubic) and the vertices are compared.
/// @param[in] gdim 2 or 3
/// @param[in] nodes positions of the facet's nodes, nodes[i*gdim + c] [L]
/// @param[in] point gdim coordinates [L]
/// @param[in] margin points that are outside by less than this in reference coordinates count as inside
/// @param[in] start reference coordinates near the closest point, or null: tried first if there is only one minimum
FacetProjection project_on_facet(const surface::FacetElement& element, int gdim, const double* nodes,
                                 const double* point, Starts starts, double margin = 1e-9,
                                 const double* start = nullptr);

/// How strongly a facet is curved.
struct Bend
{
  double radius = 0.0; ///< about the centre, of its nodes [L]
  double length = 0.0; ///< lower bound of the radius of curvature; what bends inside the surface counts, too [L]
  /// The starts needed for a point at a distance from the facet's centre: with |x_s - x_m| well below `length` the
  /// second derivatives of the squared distance, metric - (x_s - x_m) . x,ab, are positive definite.
  Starts starts(double centre_distance) const
  {
    const double farthest = centre_distance + radius;
    return farthest < 0.7 * length ? Starts::nearest : farthest < 1.4 * length ? Starts::lowest : Starts::all;
  }
};

Bend bend(const surface::FacetElement& element, int gdim, const double* nodes);

using surface::edge_corners;
} // namespace dolfinx_impact::search
