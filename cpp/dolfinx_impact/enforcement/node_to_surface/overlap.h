// SPDX-License-Identifier: MIT
#pragma once
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::enforcement
{
/// Mean of max(-g, 0) over gaps from g - |r|/2 to g + |r|/2.
inline double mean_overlap(double g, double r)
{
  const double half = 0.5 * std::abs(r);
  return g >= half ? 0.0 : g <= -half ? -g : (half - g) * (half - g) / (4.0 * half);
}

/// Part of the way from gap g - r to g that lies below zero.
inline double part_below(double g, double r)
{
  if (g < 0.0)
    return r < 0.0 ? std::min(1.0, g / r) : 1.0;
  return r > g ? 1.0 - g / r : 0.0;
}
} // namespace dolfinx_impact::enforcement
