// SPDX-License-Identifier: MIT
#pragma once
#include "../../surface/FacetElement.h"

namespace dolfinx_impact::search
{
/// Closest points of many points on one facet of degree 1 each, computed together. Layout: entry [...][lane].
struct BatchProjection
{
  static constexpr int size = 64;
  int num = 0;           ///< lanes in use
  double X[4][3][size];  ///< positions of the facets' nodes [L]
  double point[3][size]; ///< [L]
  double slave_normal[3][size];
  double rotation[size];    ///< upper bound on the error of these normals
  double orientation[size]; ///< of the facets
  double xi[2][size];       ///< in: where to start; out: closest points
  double gap[size];         ///< [L]
  double distance[size];    ///< [L]
  double normal[3][size];   ///< out of the master
  double over[size];        ///< 1: the closest point is inside the facet, and the facet faces the point; 0: not decided
};

/// Sets xi, gap, distance, normal and over. The values equal those of linear::project and linear::normal to the last
/// bit.
void project_batch(surface::FacetShape shape, BatchProjection& block);
} // namespace dolfinx_impact::search
