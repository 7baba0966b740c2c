// SPDX-License-Identifier: MIT
#pragma once

namespace dolfinx_impact::enforcement
{
/// Turn a vector along the surface into the tangent plane of another normal: it is projected and keeps its length.
/// @param[in] n unit normal, gdim entries
/// @param[in] last the vector
/// @param[out] out may not be `last`
void turn(int gdim, const double* n, const double* last, double* out);

/// Derivative of what `turn` returns by the normal, times changes of the normal.
/// @param[in] turned what `turn` has returned
/// @param[in] num number of variables
/// @param[in] d_normal gdim x num, row-major
/// @param[out] d_turned gdim x num, row-major
void turn_derivative(int gdim, const double* n, const double* last, const double* turned, int num,
                     const double* d_normal, double* d_turned);
} // namespace dolfinx_impact::enforcement
