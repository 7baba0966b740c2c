// SPDX-License-Identifier: MIT
#pragma once
#include "closest_on_loop.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::search::loop
{
/// A facet that goes on beyond its end, to the foot of a point on its plane.
template <int D>
struct BeyondEnd
{
  double weights[4] = {}; ///< of the corners at the foot: their sum is one, some are negative
  double normal[D];       ///< unit, outward
  double gap;             ///< along the normal, positive in front [L]
  double excess[D];       ///< from the closest point of the facet to the foot [L]
};

/// @param[in] corners of the facet, num of them
/// @param[in] x the point
/// @param[in] at its closest point, on a side or a corner
template <int D>
BeyondEnd<D> beyond_end(const double (&corners)[4][D], int num, const double* x, const Closest<D>& at)
{
  BeyondEnd<D> out;
  if constexpr (D == 2)
  {
    double t[2], to[2];
    for (int c = 0; c < 2; ++c)
    {
      t[c] = corners[1][c] - corners[0][c];
      to[c] = x[c] - corners[0][c];
      out.normal[c] = at.normal[c];
    }
    const double squared = dot<2>(t, t);
    out.weights[1] = squared > 0.0 ? dot<2>(t, to) / squared : 0.0;
    out.weights[0] = 1.0 - out.weights[1];
    out.gap = dot<2>(to, out.normal);
  }
  else
  {
    // Of a quadrilateral the triangle at that side goes on; at a corner that with both corners beside it.
    const bool at_mean = num == 4 && at.side >= 0;
    const int j = num == 3 ? 0 : at_mean ? at.side : at.corner, next = (j + 1) % num, before = (j + num - 1) % num;
    const double *a = corners[j], *b = corners[next];
    double ab[3], ac[3], ax[3], n[3], help[3];
    for (int c = 0; c < 3; ++c)
    {
      const double mean = at_mean ? 0.25 * (corners[0][c] + corners[1][c] + corners[2][c] + corners[3][c]) : 0.0;
      ab[c] = b[c] - a[c];
      ac[c] = (at_mean ? mean : corners[before][c]) - a[c];
      ax[c] = x[c] - a[c];
    }
    cross(ab, ac, n);
    const double squared = dot<3>(n, n), per = squared > 0.0 ? 1.0 / squared : 0.0;
    cross(ax, ac, help);
    const double second = dot<3>(help, n) * per;
    cross(ab, ax, help);
    const double last = dot<3>(help, n) * per;
    std::fill_n(out.weights, 4, at_mean ? 0.25 * last : 0.0);
    out.weights[j] += 1.0 - second - last;
    out.weights[next] += second;
    if (!at_mean)
      out.weights[before] += last;
    for (int c = 0; c < 3; ++c)
      out.normal[c] = n[c] * std::sqrt(per);
    out.gap = dot<3>(ax, out.normal);
  }
  for (int c = 0; c < D; ++c)
    out.excess[c] = at.away[c] - out.gap * out.normal[c];
  return out;
}

/// Plane of a facet through a point's foot.
struct FootPlane
{
  const double* normal; ///< unit, outward
  double gap;           ///< of the point, positive in front [L]
};

/// A point that is behind another facet's plane lies beyond the end of this one: how far may it be, as the bodies
/// overlap? As far as its foot is behind that plane, and by `slack` more.
/// @param[in] slack [L]
/// @param[in] most_parallel cosine of the angle between normals from which planes count as one
template <int D>
bool ends_at(const BeyondEnd<D>& f, const FootPlane& g, double slack, double most_parallel)
{
  constexpr double least_sine = 0.3; // planes that face each other, a slot of less than 17 degrees, have no corner
  const double cosine = dot<D>(f.normal, g.normal), sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  if (cosine >= most_parallel || sine < least_sine)
    return false;
  double into = 0.0, squared = 0.0;
  for (int c = 0; c < D; ++c)
  {
    into -= f.excess[c] * (g.normal[c] - cosine * f.normal[c]) / sine;
    squared += f.excess[c] * f.excess[c];
  }
  const double excess = std::sqrt(squared), overlap = std::max(0.0, cosine * f.gap - g.gap) / sine;
  return into >= 0.5 * excess && excess <= overlap + slack;
}
} // namespace dolfinx_impact::search::loop
