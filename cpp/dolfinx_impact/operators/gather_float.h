// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>

/// Moves values between nodes in double and the lanes of cells in float, for vectors of three components.
namespace dolfinx_impact::operators
{
/// w[(3*node + component)*lanes + lane] = scale (u[stride*dofs[node*lanes + lane] + component] - the same of node 0):
/// the difference is taken in double and then rounded, so that round-off is relative to what a cell deforms, wherever
/// it is.
/// @param[in] scale power of two: it changes no digit, and keeps products of lengths within the range of float
void gather_differences(int lanes, const double* u, int stride, const std::int32_t* dofs, int num_nodes, double scale,
                        float* w);

/// Adds scale A to b for lanes below `used`, in double; A is zero afterwards. The first node takes what is opposite to
/// the sum of the others: forces of a cell are in equilibrium to the round-off of double, and so the momentum is kept.
void scatter_balanced(int lanes, float* A, const std::int32_t* dofs, int num_nodes, int used, double scale, double* b,
                      int stride);
} // namespace dolfinx_impact::operators
