// SPDX-License-Identifier: MIT
#pragma once
#include "contact_surface.h"
#include <algorithm>
#include <stdexcept>

/// Where a slave and a master facet overlap, seen along the slave facet's normal at its centre.
namespace impact_reference
{
template <typename T>
using Flat = std::array<T, 2>; ///< coordinates in the plane; the second is zero in 2D
template <typename T>
using Polygon = std::vector<Flat<T>>;

/// The plane through a facet's centre; in 2D a line along e[0].
template <typename T>
struct Plane
{
  Vec<T> centre, normal;
  std::array<Vec<T>, 2> e;

  Flat<T> flat(const Vec<T>& x) const { return {dot(x - centre, e[0]), dot(x - centre, e[1])}; }
};

template <typename T>
Plane<T> plane_of(const Surface& s, const Facet& facet, const std::vector<Vec<T>>& u)
{
  const Local c = facet_centre(s.type);
  const Spot<T> spot = impact_reference::spot(s, facet, u, {T(c[0]), T(c[1])});
  const Vec<T> normal = spot.normal(), e = unit(spot.a[0]);
  return {spot.x, normal, {e, cross(normal, e)}};
}

/// Corners of a facet on a plane.
template <typename T>
Polygon<T> corners(const Surface& s, const Facet& facet, const std::vector<Vec<T>>& u, const Plane<T>& plane)
{
  Polygon<T> result;
  for (int v = 0; v < s.num_vertices(); ++v)
  {
    const Local xi = facet_vertex(s.type, v);
    result.push_back(plane.flat(spot(s, facet, u, std::array<T, 2>{T(xi[0]), T(xi[1])}).x));
  }
  return result;
}

/// Twice the area of a triangle, positive counter-clockwise.
template <typename T>
T turn(const Flat<T>& a, const Flat<T>& b, const Flat<T>& c)
{
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Area of a polygon, or length of an interval.
template <typename T>
T measure(const Polygon<T>& p)
{
  T sum(0);
  if (p.size() == 2)
    return p[1][0] - p[0][0];
  for (std::size_t i = 2; i < p.size(); ++i)
    sum += 0.5 * turn(p[0], p[i - 1], p[i]);
  return sum;
}

/// Part of a polygon inside a convex one; either may turn either way. Half-planes one after the other (Sutherland &
/// Hodgman 1974). Intervals are polygons of two corners.
template <typename T>
Polygon<T> overlap(Polygon<T> p, Polygon<T> clip)
{
  if (value(measure(p)) < 0)
    std::reverse(p.begin(), p.end());
  if (value(measure(clip)) < 0)
    std::reverse(clip.begin(), clip.end());
  if (p.size() == 2)
  {
    if (value(clip[0][0]) > value(p[0][0]))
      p[0] = clip[0];
    if (value(clip[1][0]) < value(p[1][0]))
      p[1] = clip[1];
    return value(p[1][0]) > value(p[0][0]) ? p : Polygon<T>{};
  }
  for (std::size_t i = 0; i < clip.size() and not p.empty(); ++i)
  {
    const Flat<T>&a = clip[i], &b = clip[(i + 1) % clip.size()];
    Polygon<T> kept;
    for (std::size_t k = 0; k < p.size(); ++k)
    {
      const Flat<T>&from = p[k], &to = p[(k + 1) % p.size()];
      const T f = turn(a, b, from), t = turn(a, b, to);
      if (value(f) >= 0)
        kept.push_back(from);
      if ((value(f) >= 0) != (value(t) >= 0))
      {
        const T s = f / (f - t);
        kept.push_back({from[0] + s * (to[0] - from[0]), from[1] + s * (to[1] - from[1])});
      }
    }
    p = kept;
  }
  return p.size() > 2 ? p : Polygon<T>{};
}

/// Centre of area.
template <typename T>
Flat<T> centroid(const Polygon<T>& p)
{
  T area(0), x(0), y(0);
  for (std::size_t i = 2; i < p.size(); ++i)
  {
    const T a = turn(p[0], p[i - 1], p[i]);
    area += a;
    x += a * (p[0][0] + p[i - 1][0] + p[i][0]);
    y += a * (p[0][1] + p[i - 1][1] + p[i][1]);
  }
  return {x / (3.0 * area), y / (3.0 * area)};
}

/// Calls f(y, weight) at the points of a rule (interval, or triangle) on a segment: an interval, or the triangles from
/// the centroid to the sides.
template <typename T, typename F>
void integrate(const Polygon<T>& segment, const Rule& rule, F&& f)
{
  if (segment.size() == 2)
  {
    const T half = 0.5 * (segment[1][0] - segment[0][0]), middle = 0.5 * (segment[1][0] + segment[0][0]);
    for (int q = 0; q < rule.weights.size(); ++q)
      f(Flat<T>{middle + rule.points(q, 0) * half, T(0)}, rule.weights(q) * half);
    return;
  }
  const Flat<T> c = centroid(segment);
  for (std::size_t i = 0; i < segment.size(); ++i)
  {
    const Flat<T>&a = segment[i], &b = segment[(i + 1) % segment.size()];
    const T area = turn(c, a, b);
    for (int q = 0; q < rule.weights.size(); ++q)
    {
      const double r = rule.points(q, 0), s = rule.points(q, 1);
      f(Flat<T>{c[0] + r * (a[0] - c[0]) + s * (b[0] - c[0]), c[1] + r * (a[1] - c[1]) + s * (b[1] - c[1])},
        rule.weights(q) * area);
    }
  }
}

/// Reference coordinates of the point of a facet that lies over the point y of the plane.
/// @throws std::domain_error if there is none: the facet stands upright on the plane or is folded
Local carry_back(const Surface& s, const Facet& facet, const std::vector<Vec<double>>& u, const Plane<double>& plane,
                 const Flat<double>& y);

/// Inverse of the derivatives of the flat coordinates by the reference coordinates.
std::array<std::array<double, 2>, 2> inverse_slope(const Spot<double>& spot, const Plane<double>& plane);

/// The same with derivatives.
template <typename T>
std::array<T, 2> carry_back(const Surface& s, const Facet& facet, const std::vector<Vec<T>>& u, const Plane<T>& plane,
                            const Flat<T>& y, const std::vector<Vec<double>>& u_value, const Plane<double>& plane_value)
{
  const Local xi = carry_back(s, facet, u_value, plane_value, {value(y[0]), value(y[1])});
  std::array<T, 2> result{T(xi[0]), T(xi[1])};
  const auto inverse = inverse_slope(spot<double>(s, facet, u_value, xi), plane_value);
  const Flat<T> now = plane.flat(spot(s, facet, u, result).x);
  for (int a = 0; a < s.tdim(); ++a)
    for (int b = 0; b < s.tdim(); ++b)
      result[a] -= inverse[a][b] * (now[b] - y[b]);
  return result;
}
} // namespace impact_reference
