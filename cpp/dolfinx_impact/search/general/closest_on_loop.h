// SPDX-License-Identifier: MIT
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

/// Closest points of straight facets that are given by their loops of corners (FacetLoops). Quadrilaterals are four
/// triangles about the mean of their corners.
namespace dolfinx_impact::search::loop
{
template <int D>
double dot(const double* a, const double* b)
{
  double sum = 0.0;
  for (int c = 0; c < D; ++c)
    sum += a[c] * b[c];
  return sum;
}

inline void cross(const double* a, const double* b, double* out)
{
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

/// The point of a facet that is closest to another point.
template <int D>
struct Closest
{
  double weights[4] = {};                                   ///< of the corners; their sum is one
  double away[D];                                           ///< from the closest point to the other point [L]
  double normal[D];                                         ///< of the facet there, unit, outward
  double squared = std::numeric_limits<double>::infinity(); ///< distance [L^2]
  int side = -1;                                            ///< of the facet that the point lies on; -1: none
  int corner = -1;                                          ///< that the point is; -1: none
  bool flat = false;                                        ///< `away` is along the normal

  bool inside() const { return side < 0 && corner < 0; }
};

/// Unit normal of a triangle, counter-clockwise; zero of one without area.
inline void triangle_normal(const double* a, const double* b, const double* c, double* n)
{
  double ab[3], ac[3];
  for (int i = 0; i < 3; ++i)
  {
    ab[i] = b[i] - a[i];
    ac[i] = c[i] - a[i];
  }
  cross(ab, ac, n);
  const double size = std::sqrt(dot<3>(n, n)), per = size > 0.0 ? 1.0 / size : 0.0;
  for (int i = 0; i < 3; ++i)
    n[i] *= per;
}

/// Place of the closest point of a triangle: its inside, one of its edges ab, bc, ca, one of its corners.
enum class Place
{
  inside,
  ab,
  bc,
  ca,
  a,
  b,
  c
};

/// @param[out] w weights of the corners
inline Place closest_on_triangle(const double* a, const double* b, const double* c, const double* x, double* w)
{
  double ab[3], ac[3], ax[3], bx[3], cx[3];
  for (int i = 0; i < 3; ++i)
  {
    ab[i] = b[i] - a[i];
    ac[i] = c[i] - a[i];
    ax[i] = x[i] - a[i];
    bx[i] = x[i] - b[i];
    cx[i] = x[i] - c[i];
  }
  const auto set = [w](double first, double second, double third, Place place)
  {
    w[0] = first;
    w[1] = second;
    w[2] = third;
    return place;
  };
  // Regions by the signs of barycentric coordinates (Ericson, Real-Time Collision Detection, 2005, 5.1.5).
  const double d1 = dot<3>(ab, ax), d2 = dot<3>(ac, ax);
  if (d1 <= 0.0 && d2 <= 0.0)
    return set(1.0, 0.0, 0.0, Place::a);
  const double d3 = dot<3>(ab, bx), d4 = dot<3>(ac, bx);
  if (d3 >= 0.0 && d4 <= d3)
    return set(0.0, 1.0, 0.0, Place::b);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0)
  {
    const double t = d1 / (d1 - d3);
    return set(1.0 - t, t, 0.0, Place::ab);
  }
  const double d5 = dot<3>(ab, cx), d6 = dot<3>(ac, cx);
  if (d6 >= 0.0 && d5 <= d6)
    return set(0.0, 0.0, 1.0, Place::c);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0)
  {
    const double t = d2 / (d2 - d6);
    return set(1.0 - t, 0.0, t, Place::ca);
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
  {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return set(0.0, 1.0 - t, t, Place::bc);
  }
  const double per = 1.0 / (va + vb + vc);
  return set(1.0 - (vb + vc) * per, vb * per, vc * per, Place::inside);
}

/// @param[in] corners of the facet, num of them
/// @param[in] x the other point
inline Closest<2> closest(const double (&corners)[4][2], int, const double* x)
{
  Closest<2> out;
  const double t[2] = {corners[1][0] - corners[0][0], corners[1][1] - corners[0][1]};
  const double to[2] = {x[0] - corners[0][0], x[1] - corners[0][1]};
  const double squared = dot<2>(t, t), along = squared > 0.0 ? dot<2>(t, to) / squared : 0.0;
  const double s = std::clamp(along, 0.0, 1.0), per = squared > 0.0 ? 1.0 / std::sqrt(squared) : 0.0;
  out.corner = !(along > 0.0) ? 0 : !(along < 1.0) ? 1 : -1;
  out.flat = out.corner < 0;
  out.weights[0] = 1.0 - s;
  out.weights[1] = s;
  for (int c = 0; c < 2; ++c)
    out.away[c] = to[c] - s * t[c];
  out.normal[0] = t[1] * per;
  out.normal[1] = -t[0] * per;
  out.squared = dot<2>(out.away, out.away);
  return out;
}

inline Closest<3> closest(const double (&corners)[4][3], int num, const double* x)
{
  Closest<3> out;
  double centre[3] = {};
  if (num == 4)
    for (int c = 0; c < 3; ++c)
      centre[c] = 0.25 * (corners[0][c] + corners[1][c] + corners[2][c] + corners[3][c]);
  const double* const third = num == 4 ? centre : corners[2];
  int j = -1; // of the nearest triangle
  double w[3] = {};
  Place place = Place::inside;
  for (int k = 0; k < (num == 4 ? 4 : 1); ++k)
  {
    const double *a = corners[k], *b = corners[(k + 1) % num];
    double weights[3], away[3];
    const Place here = closest_on_triangle(a, b, third, x, weights);
    for (int c = 0; c < 3; ++c)
      away[c] = x[c] - weights[0] * a[c] - weights[1] * b[c] - weights[2] * third[c];
    const double squared = dot<3>(away, away);
    if (!(squared < out.squared))
      continue;
    out.squared = squared;
    std::copy_n(away, 3, out.away);
    std::copy_n(weights, 3, w);
    place = here;
    j = k;
  }
  if (j < 0)
    return out; // positions that are no numbers
  out.flat = place == Place::inside;
  triangle_normal(corners[j], corners[(j + 1) % num], third, out.normal);
  std::fill_n(out.weights, 4, num == 4 ? 0.25 * w[2] : 0.0);
  out.weights[j] += w[0];
  out.weights[(j + 1) % num] += w[1];
  if (num == 3)
    out.weights[2] += w[2];
  // Edges of a quadrilateral's triangles that meet at its mean point lie inside of it.
  out.side = place == Place::ab ? j : num == 4 ? -1 : place == Place::bc ? 1 : place == Place::ca ? 2 : -1;
  out.corner = place == Place::a ? j : place == Place::b ? (j + 1) % num : num == 3 && place == Place::c ? 2 : -1;
  return out;
}

/// Unit outward normal of a facet at its side k; in the plane that of the facet.
inline void side_normal(const double (&corners)[4][2], int, int, double* n)
{
  const double t[2] = {corners[1][0] - corners[0][0], corners[1][1] - corners[0][1]};
  const double size = std::sqrt(dot<2>(t, t)), per = size > 0.0 ? 1.0 / size : 0.0;
  n[0] = t[1] * per;
  n[1] = -t[0] * per;
}

inline void side_normal(const double (&corners)[4][3], int num, int k, double* n)
{
  if (num == 3)
    return triangle_normal(corners[0], corners[1], corners[2], n);
  double centre[3];
  for (int c = 0; c < 3; ++c)
    centre[c] = 0.25 * (corners[0][c] + corners[1][c] + corners[2][c] + corners[3][c]);
  triangle_normal(corners[k], corners[(k + 1) % 4], centre, n);
}
} // namespace dolfinx_impact::search::loop
