// SPDX-License-Identifier: MIT
#pragma once
#include "closest_on_loop.h"
#include <cmath>

namespace dolfinx_impact::search::loop
{
/// An edge at present: its ends and the unit outward normals of the two facets beside it, the first of which has the
/// edge from the first end to the second.
struct EdgeAtPresent
{
  double ends[2][3];
  double normals[2][3];
};

/// Where two edges cross, seen along their common perpendicular.
struct Crossing
{
  double at[2];       ///< of the first and the second edge: part of the way from its first end
  double normal[3];   ///< unit, outward from the second edge's body
  double gap = 0.0;   ///< along the normal, positive if open [L]
  bool valid = false; ///< both points lie inside of the edges, and the normal points out of both bodies as it should

  bool inside() const { return at[0] > 0.0 && at[0] < 1.0 && at[1] > 0.0 && at[1] < 1.0; }
};

/// Squared distance of two segments.
inline double squared_distance(const EdgeAtPresent& first, const EdgeAtPresent& second)
{
  // Closest points of segments, after Ericson, Real-Time Collision Detection, 2005, 5.1.9.
  double d1[3], d2[3], r[3];
  for (int c = 0; c < 3; ++c)
  {
    d1[c] = first.ends[1][c] - first.ends[0][c];
    d2[c] = second.ends[1][c] - second.ends[0][c];
    r[c] = first.ends[0][c] - second.ends[0][c];
  }
  const double a = dot<3>(d1, d1), e = dot<3>(d2, d2), f = dot<3>(d2, r), c1 = dot<3>(d1, r), b = dot<3>(d1, d2);
  const double denominator = a * e - b * b;
  double s = denominator > 0.0 ? std::clamp((b * f - c1 * e) / denominator, 0.0, 1.0) : 0.0;
  double t = e > 0.0 ? (b * s + f) / e : 0.0;
  if (t < 0.0 || t > 1.0)
  {
    t = std::clamp(t, 0.0, 1.0);
    s = a > 0.0 ? std::clamp((b * t - c1) / a, 0.0, 1.0) : 0.0;
  }
  double sum = 0.0;
  for (int c = 0; c < 3; ++c)
  {
    const double d = r[c] + s * d1[c] - t * d2[c];
    sum += d * d;
  }
  return sum;
}

/// Cosine of the angle between the normals of a sharp edge, 20 degrees.
inline constexpr double sharp = 0.94;

/// Crossing of two edges. It counts where both edges are sharp and convex, are not nearly parallel, and their common
/// perpendicular lies within the cones of the outward normals of both: then it is the direction in which the bodies
/// part, and its length has a sign without any history.
/// @param[in] lines whether the points may lie beyond the ends
inline Crossing cross_lines(const EdgeAtPresent& first, const EdgeAtPresent& second, bool lines = true)
{
  constexpr double least_sine_squared = 0.01; ///< of the angle between the edges, about 6 degrees
  constexpr double slack = 0.02;              ///< of the cones: round-off and small strains of faces that lie flat
  Crossing out;
  double t[2][3], r[3];
  for (int c = 0; c < 3; ++c)
  {
    t[0][c] = first.ends[1][c] - first.ends[0][c];
    t[1][c] = second.ends[1][c] - second.ends[0][c];
    r[c] = second.ends[0][c] - first.ends[0][c];
  }
  double n[3];
  cross(t[0], t[1], n);
  const double squared = dot<3>(n, n), a = dot<3>(t[0], t[0]), e = dot<3>(t[1], t[1]);
  if (!(squared > least_sine_squared * a * e))
    return out;
  double help[3];
  cross(r, t[1], help);
  out.at[0] = dot<3>(help, n) / squared;
  cross(r, t[0], help);
  out.at[1] = dot<3>(help, n) / squared;
  if (!lines && !out.inside())
    return out;
  const double size = std::sqrt(squared);
  double outward = 0.0;
  for (int c = 0; c < 3; ++c)
    outward += n[c] * (second.normals[0][c] + second.normals[1][c]);
  for (int c = 0; c < 3; ++c)
    out.normal[c] = (outward < 0.0 ? -n[c] : n[c]) / size;
  const EdgeAtPresent* const edges[2] = {&first, &second};
  for (int k = 0; k < 2; ++k)
  {
    const auto& normals = edges[k]->normals;
    const double sign = k == 0 ? -1.0 : 1.0, length = std::sqrt(k == 0 ? a : e);
    if (!(dot<3>(normals[0], normals[1]) < sharp))
      return out;
    // Directions along the facets, away from the edge.
    double into[2][3], back[3];
    cross(normals[0], t[k], into[0]);
    for (int c = 0; c < 3; ++c)
      back[c] = -t[k][c];
    cross(normals[1], back, into[1]);
    if (dot<3>(into[0], normals[1]) > 0.0)
      return out; // a valley
    for (int side = 0; side < 2; ++side)
      if (sign * dot<3>(out.normal, into[side]) > slack * length)
        return out;
  }
  out.gap = 0.0;
  for (int c = 0; c < 3; ++c)
    out.gap += out.normal[c] * (out.at[0] * t[0][c] - r[c] - out.at[1] * t[1][c]);
  out.valid = true;
  return out;
}

/// As cross_lines, with points between the ends.
inline Crossing cross_edges(const EdgeAtPresent& first, const EdgeAtPresent& second)
{
  return cross_lines(first, second, false);
}
} // namespace dolfinx_impact::search::loop
