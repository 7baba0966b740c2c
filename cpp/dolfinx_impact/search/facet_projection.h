#pragma once
#include "../surface/FacetElement.h"
#include <cstdint>

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

/// Closest point of one facet.
struct FacetProjection
{
  ProjectionStatus status = ProjectionStatus::outside;
  std::int8_t entity = -1; ///< number of the edge or vertex
  double xi[2] = {0.0, 0.0};
  double x[3] = {0.0, 0.0, 0.0}; ///< position [L]
  double distance = 0.0;         ///< [L]
};

/// Closest point of a facet: all stationary points of the distance inside (Newton's method with backtracking, from one
/// start or from many), on the edges (roots of a cubic) and the vertices are compared.
/// @param[in] gdim 2 or 3
/// @param[in] nodes positions of the facet's nodes, nodes[i*gdim + c] [L]
/// @param[in] point gdim coordinates [L]
/// @param[in] one_start one start is enough: the squared distance is a convex function on the facet
/// @param[in] margin points that are outside by less than this in reference coordinates count as inside
FacetProjection project_on_facet(const surface::FacetElement& element, int gdim, const double* nodes,
                                 const double* point, bool one_start, double margin = 1e-9);

/// The distance of a point to the nearest node below which the squared distance is convex on the facet.
/// @returns infinity on affine facets, less than zero where the facet is strongly curved
double convex_distance(const surface::FacetElement& element, int gdim, const double* nodes);

/// Corners at the ends of an edge of a facet of dimension 2; in a facet of dimension 1 edge 0 is the facet.
const int* edge_corners(surface::FacetShape shape, int edge);
} // namespace impact::search
