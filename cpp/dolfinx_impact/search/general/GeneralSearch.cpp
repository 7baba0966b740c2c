// SPDX-License-Identifier: MIT
#include "GeneralSearch.h"
#include "../../common/vectors.h"
#include "../../operators/nodal_sums.h"
#include "../closest_point/edge_normals.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <mpi.h>

namespace dolfinx_impact::search
{
namespace
{
/// Cosine of the angle between outward normals up to which surfaces face each other.
constexpr double facing = -0.1;
/// Angle by which the normals of a facet turn up to which it counts as flat [rad].
constexpr double flat = 0.05;
/// A point is not over a flat facet whose reference coordinates it is beside by more than this: other facets are
/// closer.
constexpr double beside_flat = 0.5;
/// A point is closer to one of two facets if its distances differ by more than this part.
constexpr double equally_near = 1e-9;
/// Entries by node.
enum Entry
{
  body_entry,
  height_entry,
  group_entry,
  num_entries
};

/// Centre of a flat facet, and the vectors dual to its tangents there.
void set_plane(int gdim, const surface::FacetPoint& centre, double* plane)
{
  const double *a = centre.tangents[0], *b = centre.tangents[1];
  const bool curve = gdim == 2;
  const double aa = dot(a, a, gdim), bb = curve ? 1.0 : dot(b, b, gdim), ab = curve ? 0.0 : dot(a, b, gdim);
  const double det = aa * bb - ab * ab;
  std::copy_n(centre.x, gdim, plane);
  for (int c = 0; c < gdim && det > 0.0; ++c)
  {
    plane[gdim + c] = (bb * a[c] - (curve ? 0.0 : ab * b[c])) / det;
    plane[2 * gdim + c] = curve ? 0.0 : (aa * b[c] - ab * a[c]) / det;
  }
}
} // namespace

GeneralSearch::GeneralSearch(std::shared_ptr<const surface::FunctionSpace> V, const surface::Facets& facets,
                             std::span<const NamedPair> named)
    : _space(std::move(V)), _surface(*_space, facets, named), _gdim(facets.gdim)
{
  for (const double height : _surface.height)
    _highest = std::max(_highest, height);
  MPI_Allreduce(MPI_IN_PLACE, &_highest, 1, MPI_DOUBLE, MPI_MAX, _space->mesh()->comm());
  for (std::size_t node = 0; node < _surface.height.size(); ++node)
  {
    _owned.push_back(_surface.body[node]);
    _owned.push_back(_surface.height[node]);
    _owned.push_back(double(_surface.groups[node]));
  }
}

GeneralSearch::FacetValues GeneralSearch::values_of(const surface::Facets& facets,
                                                    std::span<const double> at_nodes) const
{
  FacetValues out;
  const int num = facets.displacement.num_nodes();
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    std::int64_t group = ~std::int64_t(0);
    double height = std::numeric_limits<double>::infinity();
    for (int i = 0; i < num; ++i)
    {
      const double* values = at_nodes.data() + std::size_t(facets.nodes_of(f)[i]) * num_entries;
      group &= std::int64_t(values[group_entry]);
      height = std::min(height, values[height_entry]);
    }
    out.body.push_back(std::int32_t(at_nodes[std::size_t(facets.nodes_of(f)[0]) * num_entries + body_entry]));
    out.height.push_back(height);
    out.group.push_back(group);
  }
  return out;
}

void GeneralSearch::update(PairSearch& pair, std::span<const double> start)
{
  _now = &pair.closest();
  _own = &pair.slave();
  if (_exchange != pair.exchange())
  {
    _exchange = pair.exchange();
    const auto map = _exchange->map();
    std::vector<double> values(std::size_t(map->size_local() + map->num_ghosts()) * num_entries, 0.0);
    std::ranges::copy(_owned, values.begin());
    values = operators::from_owners(map, std::move(values), num_entries);
    _slave = values_of(pair.slave(), values);
    _master = values_of(pair.master(), values);
    _slave_start = pair.slave();
    _master_start = pair.master();
  }
  std::vector<double> displacements(_exchange->size());
  _exchange->forward(start, displacements);
  surface::move(_slave_start, displacements.data());
  surface::move(_master_start, displacements.data());
  const surface::Facets& m = pair.master();
  _master.normal.resize(m.size() * _gdim);
  _master.facing.resize(m.size());
  _master.plane.assign(m.size() * 3 * _gdim, 0.0);
  for (std::size_t f = 0; f < m.size(); ++f)
  {
    const surface::FacetPoint centre = surface::evaluate(m, f, m.x_of(f), m.geometry.centre().data());
    std::copy_n(centre.normal, _gdim, _master.normal.data() + f * _gdim);
    double least = 1.0; // cosine of the angle by which the facet's normals turn, seen from the centre
    for (int i = 0; i < m.geometry.num_nodes(); ++i)
      least = std::min(least,
                       dot(surface::evaluate(m, f, m.x_of(f), m.geometry.node(i).data()).normal, centre.normal, _gdim));
    const double turn = std::acos(std::clamp(least, -1.0, 1.0)) + 1e-6;
    _master.facing[f] = std::cos(std::max(0.0, std::acos(facing) - turn));
    if (turn < flat)
      set_plane(_gdim, centre, _master.plane.data() + f * 3 * _gdim);
  }
  _motion = pair.motion();
}

bool GeneralSearch::leaves_out(std::int32_t first, std::int32_t second) const
{
  return _surface.left_out(_master.group[first], _master.group[second]);
}

/// Is a point so far beside a flat facet that it is not over it?
bool GeneralSearch::far_beside(std::int32_t facet, const double* x) const
{
  const surface::FacetElement& element = _now->master().geometry;
  const double* plane = _master.plane.data() + std::size_t(facet) * 3 * _gdim;
  const auto centre = element.centre();
  double xi[2] = {centre[0], centre[1]}, size = 0.0;
  for (int k = 0; k < element.tdim(); ++k)
    for (int c = 0; c < _gdim; ++c)
    {
      const double along = plane[(1 + k) * _gdim + c];
      xi[k] += along * (x[c] - plane[c]);
      size += along * along;
    }
  return size > 0.0 && !element.inside(xi, beside_flat);
}

/// May a point of one facet meet another facet, as far as both facets tell?
bool GeneralSearch::may_meet(std::int32_t own, std::int32_t other, const double* normal) const
{
  if (dot(_master.normal.data() + std::size_t(other) * _gdim, normal, _gdim) > _master.facing[other])
    return false;
  const surface::Facets& m = _now->master();
  const int num = m.displacement.num_nodes();
  for (int i = 0; i < num; ++i)
    for (int j = 0; j < num; ++j)
      if (_own->nodes_of(own)[i] == m.nodes_of(other)[j])
        return false;
  return !_surface.left_out(_slave.group[own], _master.group[other]);
}

/// Has a point that is behind a facet come there through it, in this increment or before?
bool GeneralSearch::came_through(const SearchingPoint& point, std::int32_t facet) const
{
  const surface::Facets& m = _master_start;
  const surface::FacetPoint own =
      surface::evaluate(_slave_start, point.facet, _slave_start.x_of(point.facet), point.xi);
  const FacetProjection at = project_on_facet(m.geometry, _gdim, m.x_of(facet), own.x, _now->starts(facet, own.x));
  const surface::FacetPoint there = surface::evaluate(m, facet, m.x_of(facet), at.xi);
  double along = 0.0;
  for (int c = 0; c < _gdim; ++c)
    along += there.normal[c] * (own.x[c] - there.x[c]);
  return along > -point.depth - shallow_part * _master.height[facet];
}

/// Gap and normal of a point with its closest point on a facet.
/// @returns false if the point is closer to another facet of the same part of the surface
bool GeneralSearch::set_side(const SearchingPoint& point, const FacetProjection& at, const surface::FacetPoint& p,
                             Projection& out) const
{
  const surface::Facets& m = _now->master();
  out.status = at.status;
  out.entity = at.entity;
  std::copy_n(at.xi, 2, out.xi);
  std::copy_n(p.normal, 3, out.normal);
  double d[3] = {0.0, 0.0, 0.0};
  for (int c = 0; c < _gdim; ++c)
    d[c] = point.x[c] - p.x[c];
  out.gap = dot(d, p.normal, _gdim);
  if (at.status == ProjectionStatus::converged)
    return true;
  const double size = _now->size(out.facet);
  if (at.distance <= 1e-10 * size)
  {
    // d has no direction: the point counts as one of the facet.
    out.status = ProjectionStatus::converged;
    out.entity = -1;
    return true;
  }
  bool behind = true, closest = true;
  double box[6], mean[3];
  for (int c = 0; c < _gdim; ++c)
  {
    box[c] = at.x[c] - 1e-9 * size;
    box[_gdim + c] = at.x[c] + 1e-9 * size;
  }
  const bool ends = mean_normal(
      m, at, out.facet, [&](auto&& visit) { _now->tree().overlapping(box, visit); },
      [&](std::int32_t f, const double* xi, double* n)
      {
        std::copy_n(surface::evaluate(m, f, m.x_of(f), xi).normal, 3, n);
        behind &= dot(d, n, _gdim) < 0.0;
        if (f == out.facet || !closest)
          return;
        const FacetProjection on = project_on_facet(m.geometry, _gdim, m.x_of(f), point.x, _now->starts(f, point.x));
        closest = !(on.distance < (1.0 - equally_near) * at.distance);
      },
      mean);
  const bool beside_rim = ends && beside(_gdim, d, mean, size);
  if (beside_rim)
    out.rim = Projection::Rim::beside;
  const double sign = behind && !beside_rim ? -1.0 : 1.0;
  out.gap = sign * at.distance;
  for (int c = 0; c < _gdim; ++c)
    out.normal[c] = d[c] / out.gap;
  return closest;
}

double GeneralSearch::overlap(const SearchingPoint& point, double reach) const
{
  const surface::Facets& m = _now->master();
  // By body, as a point in front of one may be inside of another.
  std::vector<std::pair<std::int32_t, FacetProjection>> nearest;
  std::vector<std::int32_t> facets;
  const auto visit = [&](std::int32_t f)
  {
    const std::int32_t body = _master.body[f];
    if (body == _slave.body[point.facet])
      return reach * reach;
    const FacetProjection at = project_on_facet(m.geometry, _gdim, m.x_of(f), point.x, _now->starts(f, point.x));
    const auto place = std::ranges::find(nearest, body, &std::pair<std::int32_t, FacetProjection>::first);
    if (place == nearest.end())
    {
      nearest.emplace_back(body, at);
      facets.push_back(f);
    }
    else if (at.distance < place->second.distance)
    {
      place->second = at;
      facets[place - nearest.begin()] = f;
    }
    return reach * reach;
  };
  _now->tree().nearest(point.x, reach * reach, visit);
  double out = 0.0;
  for (std::size_t k = 0; k < nearest.size(); ++k)
  {
    const FacetProjection& at = nearest[k].second;
    Projection found;
    found.facet = facets[k];
    if (at.distance <= reach && !_surface.left_out(_slave.group[point.facet], _master.group[found.facet]))
      set_side(point, at, surface::evaluate(m, found.facet, m.x_of(found.facet), at.xi), found);
    if (found.gap < 0.0)
      out = std::max(out, -found.gap);
  }
  return out;
}

Projection GeneralSearch::project(const SearchingPoint& point, double reach, std::int32_t previous, double margin) const
{
  const surface::Facets& m = _now->master();
  Projection out;
  FacetProjection best;
  const auto consider = [&](std::int32_t f, const FacetProjection& at, Projection& found)
  {
    const surface::FacetPoint p = surface::evaluate(m, f, m.x_of(f), at.xi);
    if (!(at.distance <= reach) || !(dot(p.normal, point.normal, _gdim) < facing))
      return false;
    // Farther than what the point is in front of, a facet counts only if the point is behind it.
    if (out.facet >= 0 && !(out.gap < 0.0) && at.distance > best.distance)
    {
      double along = 0.0;
      for (int c = 0; c < _gdim; ++c)
        along += p.normal[c] * (point.x[c] - p.x[c]);
      if (!(along < 0.0))
        return false;
    }
    found.facet = f;
    return set_side(point, at, p, found) && (!(found.gap < 0.0) || came_through(point, f));
  };
  const auto better = [&](std::int32_t f, const FacetProjection& at, const Projection& found)
  {
    if (out.facet < 0)
      return true;
    const bool behind = found.gap < 0.0;
    return behind != (out.gap < 0.0) ? behind : closer(at, m.id[f], best, m.id[out.facet], _now->size(out.facet));
  };
  const auto visit = [&](std::int32_t f)
  {
    if (may_meet(point.facet, f, point.normal) && !far_beside(f, point.x))
    {
      const FacetProjection at = project_on_facet(m.geometry, _gdim, m.x_of(f), point.x, _now->starts(f, point.x));
      Projection found;
      if (consider(f, at, found) && better(f, at, found))
      {
        best = at;
        out = found;
      }
    }
    if (out.facet < 0)
      return reach * reach;
    double limit = best.distance + 2e-12 * (best.distance + _now->size(out.facet));
    // What a point is behind may be farther away than what it is in front of, but no deeper than it can have come.
    if (!(out.gap < 0.0))
      limit = std::max(limit, std::min(reach, point.depth + shallow_part * _highest + _motion));
    return limit * limit;
  };
  _now->tree().nearest(point.x, reach * reach, visit);
  if (out.facet < 0)
    return out;
  if (previous >= 0 && previous < std::int32_t(m.size()) && previous != out.facet &&
      may_meet(point.facet, previous, point.normal))
  {
    const FacetProjection at = project_on_facet(m.geometry, _gdim, m.x_of(previous), point.x, Starts::all, margin);
    Projection found;
    if (at.status == ProjectionStatus::converged && at.distance <= best.distance + 1e-3 * _now->size(previous) &&
        consider(previous, at, found))
      return found;
  }
  return out;
}
} // namespace dolfinx_impact::search
