// SPDX-License-Identifier: MIT
#include "FacetShape.h"
#include "../common/vectors.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::gap
{
namespace
{
/// Part of a facet by which a point beside the rim still counts as over it.
constexpr double flush = 0.05;

double dot(const double* a, const double* b)
{
  return dolfinx_impact::dot(a, b, 3);
}

void subtract(const double* a, const double* b, double* out)
{
  for (int c = 0; c < 3; ++c)
    out[c] = a[c] - b[c];
}

void add(double* sum, double factor, const double* a)
{
  for (int c = 0; c < 3; ++c)
    sum[c] += factor * a[c];
}
} // namespace

FacetShape::FacetShape(int gdim, std::span<const double> points, std::span<const std::int32_t> facets) : _gdim(gdim)
{
  if ((gdim != 2 && gdim != 3) || points.size() % gdim || facets.size() % gdim || facets.empty())
    throw std::invalid_argument("a surface of facets takes points of two or three coordinates and facets of as many");
  const std::int64_t num_points = points.size() / gdim, num = facets.size() / gdim;
  std::vector<Vector> at_points(num_points, Vector{});
  std::map<std::array<std::int32_t, 2>, std::vector<std::pair<std::int64_t, bool>>> edges; // facet, forwards?
  std::vector<std::array<int, 2>> ends(gdim == 2 ? num_points : 0);                        // begin here, end here
  std::vector<double> boxes(2 * gdim * num);
  _facets.resize(num);
  for (std::int64_t f = 0; f < num; ++f)
  {
    Facet& facet = _facets[f];
    facet = {};
    double* box = boxes.data() + 2 * gdim * f;
    std::fill_n(box, gdim, std::numeric_limits<double>::infinity());
    std::fill_n(box + gdim, gdim, -std::numeric_limits<double>::infinity());
    const std::int32_t* nodes = facets.data() + gdim * f;
    for (int k = 0; k < gdim; ++k)
    {
      if (nodes[k] < 0 || nodes[k] >= num_points)
        throw std::invalid_argument("facet " + std::to_string(f) + " has the point " + std::to_string(nodes[k]) +
                                    ", there are " + std::to_string(num_points));
      for (int c = 0; c < gdim; ++c)
      {
        facet.x[k][c] = points[gdim * nodes[k] + c];
        box[c] = std::min(box[c], facet.x[k][c]);
        box[gdim + c] = std::max(box[gdim + c], facet.x[k][c]);
      }
    }
    double d[3], e[3];
    for (int k = 0; k < gdim; ++k)
    {
      subtract(facet.x[(k + 1) % gdim], facet.x[k], d);
      facet.longest = std::max(facet.longest, std::sqrt(dot(d, d)));
    }
    subtract(facet.x[1], facet.x[0], d);
    if (gdim == 2)
    {
      facet.normal = {{d[1], -d[0], 0.0}};
      ++ends[nodes[0]][0];
      ++ends[nodes[1]][1];
    }
    else
    {
      subtract(facet.x[2], facet.x[0], e);
      cross(d, e, facet.normal.v);
      for (int k = 0; k < 3; ++k)
      {
        const std::int32_t a = nodes[(k + 1) % 3], b = nodes[(k + 2) % 3];
        edges[{std::min(a, b), std::max(a, b)}].emplace_back(3 * f + k, a < b);
      }
    }
    const double size = std::sqrt(dot(facet.normal.v, facet.normal.v));
    if (!(size > 1e-14 * std::pow(facet.longest, gdim - 1)) || !std::isfinite(size))
      throw std::invalid_argument("facet " + std::to_string(f) + " has no size, or a point that is not a number");
    for (double& v : facet.normal.v)
      v /= size;
    for (int k = 0; k < gdim; ++k)
    {
      double weight = 1.0;
      if (gdim == 3)
      {
        subtract(facet.x[(k + 1) % 3], facet.x[k], d);
        subtract(facet.x[(k + 2) % 3], facet.x[k], e);
        weight = std::acos(std::clamp(dot(d, e) / std::sqrt(dot(d, d) * dot(e, e)), -1.0, 1.0));
      }
      add(at_points[nodes[k]].v, weight, facet.normal.v);
    }
  }
  std::vector<bool> rim(num_points, false);
  for (std::size_t p = 0; p < ends.size(); ++p)
  {
    const auto [begin, end] = ends[p];
    if (begin > 1 || end > 1)
      throw std::invalid_argument("point " + std::to_string(p) + " begins " + std::to_string(begin) +
                                  " segments and ends " + std::to_string(end) +
                                  ": segments must follow each other, with the obstacle on their left");
    rim[p] = begin + end == 1;
  }
  for (const auto& [ab, sides] : edges)
  {
    if (sides.size() > 2)
      throw std::invalid_argument(std::to_string(sides.size()) + " facets share the edge between the points " +
                                  std::to_string(ab[0]) + " and " + std::to_string(ab[1]) + ": at most two may");
    if (sides.size() == 2 && sides[0].second == sides[1].second)
      throw std::invalid_argument("facets " + std::to_string(sides[0].first / 3) + " and " +
                                  std::to_string(sides[1].first / 3) +
                                  " are oriented differently: all must run counter-clockwise seen from outside");
    Vector sum{};
    for (const auto& [side, forwards] : sides)
      add(sum.v, 1.0, _facets[side / 3].normal.v);
    for (const auto& [side, forwards] : sides)
    {
      _facets[side / 3].edges[side % 3] = sum;
      _facets[side / 3].rim_edges[side % 3] = sides.size() == 1;
    }
    if (sides.size() == 1)
      rim[ab[0]] = rim[ab[1]] = true;
  }
  for (std::int64_t f = 0; f < num; ++f)
    for (int k = 0; k < gdim; ++k)
    {
      _facets[f].vertices[k] = at_points[facets[gdim * f + k]];
      _facets[f].rim_vertices[k] = rim[facets[gdim * f + k]];
    }
  _tree = search::BoxTree(gdim, boxes);
}

/// The closest point of a facet; a triangle's by the regions of its parts (Ericson 2005, 5.1.5).
FacetShape::Foot FacetShape::foot(const Facet& facet, const double* x) const
{
  Foot out{&facet, -1, -1, {}, 0.0};
  double ab[3], ap[3];
  subtract(facet.x[1], facet.x[0], ab);
  subtract(x, facet.x[0], ap);
  const auto along = [&](int from, int to, double t)
  {
    for (int c = 0; c < 3; ++c)
      out.x[c] = facet.x[from][c] + t * (facet.x[to][c] - facet.x[from][c]);
  };
  const auto vertex = [&](int k)
  {
    out.vertex = k;
    std::copy_n(facet.x[k], 3, out.x);
  };
  if (_gdim == 2)
  {
    const double t = dot(ab, ap) / dot(ab, ab);
    t <= 0.0 ? vertex(0) : t >= 1.0 ? vertex(1) : along(0, 1, t);
  }
  else
  {
    double ac[3], bp[3], cp[3];
    subtract(facet.x[2], facet.x[0], ac);
    subtract(x, facet.x[1], bp);
    subtract(x, facet.x[2], cp);
    const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
                 d6 = dot(ac, cp);
    const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    if (d1 <= 0.0 && d2 <= 0.0)
      vertex(0);
    else if (d3 >= 0.0 && d4 <= d3)
      vertex(1);
    else if (d6 >= 0.0 && d5 <= d6)
      vertex(2);
    else if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0)
      out.edge = 2, along(0, 1, d1 / (d1 - d3));
    else if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0)
      out.edge = 1, along(0, 2, d2 / (d2 - d6));
    else if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
      out.edge = 0, along(1, 2, (d4 - d3) / ((d4 - d3) + (d5 - d6)));
    else
      for (int c = 0; c < 3; ++c)
        out.x[c] = facet.x[0][c] + (vb * ab[c] + vc * ac[c]) / (va + vb + vc);
  }
  double d[3];
  subtract(x, out.x, d);
  out.squared = dot(d, d);
  return out;
}

double FacetShape::largest_coordinate() const
{
  double largest = 0.0;
  for (const Facet& facet : _facets)
    for (const auto& x : facet.x)
      for (double value : x)
        largest = std::max(largest, std::abs(value));
  return largest;
}

RigidPoint FacetShape::closest(std::span<const double> given) const
{
  double x[3] = {given[0], given[1], _gdim == 3 ? given[2] : 0.0};
  Foot best{};
  best.squared = std::numeric_limits<double>::infinity();
  _tree.nearest(x, best.squared,
                [&](std::int32_t i)
                {
                  const Foot found = foot(_facets[i], x);
                  if (found.squared < best.squared)
                    best = found;
                  return best.squared;
                });
  RigidPoint out{};
  if (!best.facet) // x is not a number: a run that breaks
  {
    out.gap = std::numeric_limits<double>::quiet_NaN();
    return out;
  }
  const Facet& facet = *best.facet;
  double d[3];
  subtract(x, best.x, d);
  if (best.edge < 0 && best.vertex < 0)
  {
    out.gap = dot(d, facet.normal.v);
    std::copy_n(facet.normal.v, 3, out.normal);
    return out;
  }
  const bool rim = best.edge >= 0 ? facet.rim_edges[best.edge] : facet.rim_vertices[best.vertex];
  const double* side = best.edge >= 0 ? facet.edges[best.edge].v : facet.vertices[best.vertex].v;
  const double over = dot(d, facet.normal.v);
  if (rim && best.squared - over * over < flush * flush * facet.longest * facet.longest)
  {
    out.gap = over;
    std::copy_n(facet.normal.v, 3, out.normal);
    return out;
  }
  const double distance = std::sqrt(best.squared), size = std::sqrt(dot(side, side));
  const double sign = rim || dot(d, side) >= 0.0 ? 1.0 : -1.0;
  double extent = 0.0;
  for (int k = 0; k < _gdim; ++k)
    for (int c = 0; c < 3; ++c)
      extent = std::max(extent, std::abs(facet.x[k][c]));
  out.gap = sign * distance;
  if (!(distance > 1e-14 * extent)) // on it
  {
    for (int c = 0; c < 3; ++c)
      out.normal[c] = size > 0.0 ? side[c] / size : facet.normal.v[c];
    return out;
  }
  double along[3] = {};
  if (best.edge >= 0)
  {
    subtract(facet.x[(best.edge + 2) % 3], facet.x[(best.edge + 1) % 3], along);
    const double length = std::sqrt(dot(along, along));
    for (double& v : along)
      v /= length;
  }
  for (int c = 0; c < 3; ++c)
    out.normal[c] = sign * d[c] / distance;
  for (int a = 0; a < _gdim; ++a)
    for (int b = 0; b < _gdim; ++b)
      out.hessian[3 * a + b] =
          sign * ((a == b ? 1.0 : 0.0) - along[a] * along[b] - out.normal[a] * out.normal[b]) / distance;
  return out;
}
} // namespace dolfinx_impact::gap
