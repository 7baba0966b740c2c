// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/points.h"

namespace dolfinx_impact::enforcement
{
/// How gap, normal and place on the master of one point vary with the displacements. Everything depends on them through
/// D = u_s - u_m(xi) and its derivatives D,r along the k parameters that are free (2 on a facet, 1 on an edge or in the
/// plane, 0 at a vertex or on a rigid master): q = (D, D,1, ..., D,k) has num = (1 + k)*gdim entries, and the maps
/// below are row-major matrices that act on it. D,r acts on the master's displacements: D,r = + u_m,r.
struct Variation
{
  static constexpr int max_num = 9;

  int gdim = 3, k = 0, num = 3;
  int num_slave = 0, num_master = 0;
  double shape[1 + 2][18];      ///< slave's nodes, then the master's: of D (signs included), and of D,r
  double d_gap[max_num];        ///< 1 x num
  double d_xi[2 * max_num];     ///< k x num, in the free parameters
  double d_normal[3 * max_num]; ///< gdim x num
};

/// @param[in] master null for rigid masters
/// @param[in] q point with finite gap
Variation vary(const gap::Points& points, const surface::Facets& slave, const surface::Facets* master, std::size_t q);

/// Shape functions of D alone: slave's nodes, then minus the master's. @returns their number
int relative_shape(const gap::Points& points, const surface::Facets& slave, const surface::Facets* master,
                   std::size_t q, double* shape);
} // namespace dolfinx_impact::enforcement
