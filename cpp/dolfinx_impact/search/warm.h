// SPDX-License-Identifier: MIT
#pragma once
#include "../surface/FacetElement.h"

namespace dolfinx_impact::search
{
/// Points over facets of degree 1, several at a time: from where they were in the last step. Layout: entry [...][lane].
struct WarmBlock
{
  static constexpr int size = 64;
  int num = 0;           ///< lanes in use
  double X[4][3][size];  ///< positions of the facets' nodes [L]
  double point[3][size]; ///< [L]
  double slave_normal[3][size];
  double turned[size];      ///< by how much these may be wrong at most
  double orientation[size]; ///< of the facets
  double xi[2][size];       ///< in: where to start; out: closest points
  double gap[size];         ///< [L]
  double distance[size];    ///< [L]
  double normal[3][size];   ///< out of the master
  double over[size];        ///< 1: the closest point is inside the facet, which faces the point for sure; 0: look again
};

/// Fills gap, distance, normal and over. The numbers are those of linear::project and linear::normal, to the last bit.
void warm_closest_points(surface::FacetShape shape, WarmBlock& block);
} // namespace dolfinx_impact::search
