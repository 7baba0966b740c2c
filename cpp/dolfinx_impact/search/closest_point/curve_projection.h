// SPDX-License-Identifier: MIT
#pragma once

namespace dolfinx_impact::search
{
/// Closest point on a curve x(t) of degree 1 or 2 between two nodes, at which the distance is stationary.
/// @param[in] gdim 2 or 3
/// @param[in] a, b, middle positions at t = 0, 1, 1/2; middle is null on straight curves [L]
/// @param[in] point gdim coordinates [L]
/// @param[in] margin the curve extends over -margin <= t <= 1 + margin
/// @param[out] t parameter of the nearest minimum of the distance
/// @returns false if there is none: then the nearest point is an end
bool project_on_curve(int gdim, const double* a, const double* b, const double* middle, const double* point,
                      double margin, double& t);
} // namespace dolfinx_impact::search
