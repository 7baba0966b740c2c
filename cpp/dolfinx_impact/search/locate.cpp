#include "../common/vectors.h"
#include "NodeTracking.h"
#include "linear_facet.h"
#include "umbrella.h"
#include <algorithm>
#include <cmath>

namespace impact::search
{
namespace
{
using surface::FacetElement;
using surface::FacetShape;
constexpr double list_budget = 0.2; ///< of the nearest facet's diameter: travel for which a list is good
constexpr int max_values = 3 * FacetElement::max_nodes;
} // namespace

void NodeTracking::position(std::size_t i, Configuration at, double* x) const
{
  const std::size_t node = std::size_t(_nodes[i]) * _gdim;
  for (int c = 0; c < _gdim; ++c)
    x[c] = _X[i * _gdim + c] + (at.u[node + c] - (at.du ? at.du[node + c] : 0.0));
}

void NodeTracking::positions(std::int32_t f, Configuration at, double* x) const
{
  const int n_x = _master.geometry.num_nodes(), n_u = _master.displacement.num_nodes();
  const std::int32_t* nodes = _master.nodes_of(f);
  const double* X = _master.X_of(f);
  if (n_x == n_u)
  {
    for (int i = 0; i < n_x; ++i)
      for (int c = 0; c < _gdim; ++c)
      {
        const std::size_t k = std::size_t(nodes[i]) * _gdim + c;
        x[i * _gdim + c] = X[i * _gdim + c] + (at.u[k] - (at.du ? at.du[k] : 0.0));
      }
    return;
  }
  for (int i = 0; i < n_x; ++i)
    for (int c = 0; c < _gdim; ++c)
    {
      double sum = X[i * _gdim + c];
      for (int j = 0; j < n_u; ++j)
      {
        const std::size_t k = std::size_t(nodes[j]) * _gdim + c;
        sum += _phi[i * n_u + j] * (at.u[k] - (at.du ? at.du[k] : 0.0));
      }
      x[i * _gdim + c] = sum;
    }
}

FacetProjection NodeTracking::project(std::int32_t f, const double* facet, const double* x, const double* start) const
{
  ++_counters.projections;
  FacetProjection out;
  bool found = false;
  switch (_kind)
  {
  case Kind::interval:
    found = linear::project<FacetShape::interval>(facet, x, start, out);
    break;
  case Kind::triangle:
    found = linear::project<FacetShape::triangle>(facet, x, start, out);
    break;
  case Kind::quadrilateral:
    found = linear::project<FacetShape::quadrilateral>(facet, x, start, out);
    break;
  case Kind::general:
    break;
  }
  if (found)
    return out;
  const bool curved = _master.geometry.tdim() == 2;
  const Starts starts = curved ? bend(_master.geometry, _gdim, facet).starts(2 * _size[f]) : Starts::nearest;
  return project_on_facet(_master.geometry, _gdim, facet, x, starts);
}

void NodeTracking::facet_normal(std::int32_t f, const double* facet, const double* xi, double* normal) const
{
  const double sign = _master.orientation[f];
  switch (_kind)
  {
  case Kind::interval:
    return linear::normal<FacetShape::interval>(facet, xi, sign, normal);
  case Kind::triangle:
    return linear::normal<FacetShape::triangle>(facet, xi, sign, normal);
  case Kind::quadrilateral:
    return linear::normal<FacetShape::quadrilateral>(facet, xi, sign, normal);
  case Kind::general:
    std::copy_n(surface::evaluate(_master, f, facet, xi).normal, 3, normal);
  }
}

bool NodeTracking::better(const FacetProjection& a, std::int32_t facet, const FacetProjection& best,
                          std::int32_t best_facet) const
{
  const double tolerance = 1e-12 * (best.distance + _size[best_facet]);
  if (std::abs(a.distance - best.distance) > tolerance)
    return a.distance < best.distance;
  const bool a_inside = a.status == ProjectionStatus::converged, b_inside = best.status == ProjectionStatus::converged;
  return a_inside != b_inside ? a_inside : _master.id[facet] < _master.id[best_facet];
}

Projection NodeTracking::query(std::size_t i, Configuration at, double slack, const double* shift,
                               std::span<Found> near, int& num, double& budget) const
{
  double x[3], there[3], facet[max_values], normal[3], best_normal[3];
  position(i, at, x);
  for (int c = 0; c < _gdim; ++c)
    there[c] = x[c] - shift[c];
  const double* slave_normal = _normals.data() + i * _gdim;
  const double radius = std::max(_reach, 2 * _step);
  Projection out;
  FacetProjection best;
  double dropped = std::numeric_limits<double>::infinity();
  const auto visit = [&](std::int32_t f)
  {
    positions(f, at, facet);
    const FacetProjection p = project(f, facet, x, f == _held_facet[i] ? _xi.data() + 2 * i : nullptr);
    if (p.distance <= radius && (out.facet < 0 || better(p, f, best, out.facet)))
    {
      facet_normal(f, facet, p.xi, normal);
      if (dot(normal, slave_normal, _gdim) < 0.0)
      {
        best = p;
        out.facet = f;
        std::copy_n(normal, 3, best_normal);
      }
    }
    if (num < int(near.size()))
      near[num++] = {f, p.distance};
    else
    {
      // Full: the farthest makes room.
      auto far = std::max_element(near.begin(), near.end(),
                                  [](const Found& a, const Found& b) { return a.distance < b.distance; });
      dropped = std::min(dropped, std::max(far->distance, p.distance));
      if (p.distance < far->distance)
        *far = {f, p.distance};
    }
    const double limit = out.facet < 0 ? radius : best.distance + 2 * list_budget * _size[out.facet];
    return (limit + slack) * (limit + slack);
  };
  _tree.nearest(there, (radius + slack) * (radius + slack), visit);
  if (out.facet < 0)
  {
    num = 0;
    budget = 0.0;
    return out;
  }
  // What is not in the list cannot become the nearest while slave and master travel `budget`.
  budget = std::min(list_budget * _size[out.facet], 0.5 * (dropped - best.distance));
  const double farthest = best.distance + 2 * budget + 1e-9 * _size[out.facet];
  const auto beyond = [&](const Found& f) { return f.distance > farthest; };
  num = int(std::remove_if(near.begin(), near.begin() + num, beyond) - near.begin());
  if (num > most)
  {
    std::nth_element(near.begin(), near.begin() + most, near.begin() + num,
                     [](const Found& a, const Found& b) { return a.distance < b.distance; });
    budget = std::min(budget, 0.5 * (near[most].distance - best.distance));
  }
  finish(x, best_normal, best, at, near.first(num), out);
  return out;
}

Projection NodeTracking::from_list(std::size_t i, Configuration at)
{
  double x[3], facet[max_values], normal[3], best_normal[3];
  position(i, at, x);
  const double* slave_normal = _normals.data() + i * _gdim;
  const std::span<const Found> list(_list.data() + i * most, _count[i]);
  const double moved = _travel - _listed[i], room = 1e-9 * _largest;
  const std::int32_t held = _held_facet[i];
  Projection out;
  FacetProjection best, first;
  double bound = std::numeric_limits<double>::infinity();
  bool held_faces = false;
  if (held >= 0) // most likely the nearest: saves looking at the others
  {
    positions(held, at, facet);
    first = project(held, facet, x, _xi.data() + 2 * i);
    facet_normal(held, facet, first.xi, best_normal);
    held_faces = dot(best_normal, slave_normal, _gdim) < 0.0;
    if (held_faces)
    {
      bound = first.distance;
      best = first;
      out.facet = held;
    }
  }
  for (const auto& [f, distance] : list)
  {
    if (f == held || distance - moved > bound + room)
      continue;
    positions(f, at, facet);
    const FacetProjection p = project(f, facet, x, nullptr);
    if (out.facet >= 0 && !better(p, f, best, out.facet))
      continue;
    facet_normal(f, facet, p.xi, normal);
    if (dot(normal, slave_normal, _gdim) < 0.0)
    {
      best = p;
      out.facet = f;
      bound = std::min(bound, p.distance);
      std::copy_n(normal, 3, best_normal);
    }
  }
  if (out.facet >= 0 && best.distance <= std::max(_reach, 2 * _step))
    finish(x, best_normal, best, at, list, out);
  else
    out = {};
  return out;
}

void NodeTracking::finish(const double* x, const double* normal, const FacetProjection& at, Configuration config,
                          std::span<const Found> near, Projection& out) const
{
  out.status = at.status;
  out.entity = at.entity;
  std::copy_n(at.xi, 2, out.xi);
  std::copy_n(normal, 3, out.normal);
  double d[3] = {0.0, 0.0, 0.0};
  for (int c = 0; c < _gdim; ++c)
    d[c] = x[c] - at.x[c];
  out.gap = dot(d, normal, _gdim);
  if (at.status == ProjectionStatus::converged)
    return;
  if (at.distance <= 1e-10 * _size[out.facet])
  {
    // d has no direction: the node counts as one of the facet.
    out.status = ProjectionStatus::converged;
    out.entity = -1;
    return;
  }
  double mean[3];
  const bool ends = mean_normal(at, out.facet, config, near, mean) && beside(_gdim, d, mean, _size[out.facet]);
  out.gap = (ends || dot(d, mean, _gdim) >= 0.0 ? 1.0 : -1.0) * at.distance;
  for (int c = 0; c < _gdim; ++c)
    out.normal[c] = d[c] / out.gap;
}

/// Mean normal of the facets that meet at an edge or vertex; they are all in the list.
/// @returns whether the surface ends there
bool NodeTracking::mean_normal(const FacetProjection& at, std::int32_t facet, Configuration config,
                               std::span<const Found> near, double* normal) const
{
  const FacetElement& element = _master.geometry;
  const bool edge = at.status == ProjectionStatus::edge;
  const int* ends = edge ? edge_corners(element.shape, at.entity) : nullptr;
  const std::int32_t* own = _master.nodes_of(facet);
  double t = 0.0; // position along the edge
  if (edge)
  {
    const auto a = element.node(ends[0]), b = element.node(ends[1]);
    const int c = a[0] != b[0] ? 0 : 1;
    t = (at.xi[c] - a[c]) / (b[c] - a[c]);
  }
  std::fill_n(normal, 3, 0.0);
  int meeting = 0;
  Umbrella umbrella;
  for (const auto& [f, distance] : near)
  {
    const int i = corner(_master, f, own[edge ? ends[0] : at.entity]), j = edge ? corner(_master, f, own[ends[1]]) : i;
    if (i < 0 || j < 0)
      continue;
    ++meeting;
    const auto a = element.node(i), b = element.node(j);
    const double xi[2] = {(1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1]};
    double positions_of[max_values], n[3];
    positions(f, config, positions_of);
    facet_normal(f, positions_of, xi, n);
    for (int c = 0; c < _gdim; ++c)
      normal[c] += n[c];
    if (!edge && element.tdim() == 2)
      for (int e = 0; e < element.num_corners(); ++e)
        if (const int* k = edge_corners(element.shape, e); k[0] == i || k[1] == i)
          umbrella.add(_master.nodes_of(f)[k[0] == i ? k[1] : k[0]]);
  }
  return edge || element.tdim() == 1 ? meeting < 2 : umbrella.open();
}
} // namespace impact::search
