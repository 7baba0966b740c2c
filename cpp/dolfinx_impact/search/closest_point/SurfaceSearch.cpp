// SPDX-License-Identifier: MIT
#include "SurfaceSearch.h"
#include "../../common/vectors.h"
#include "../boxes.h"
#include "edge_normals.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::search
{
namespace
{
double centre_distance(const surface::Facets& facets, std::size_t f, const double* x)
{
  double phi[surface::FacetElement::max_nodes], d[3];
  facets.geometry.values(facets.geometry.centre().data(), phi);
  std::copy_n(x, facets.gdim, d);
  for (int i = 0; i < facets.geometry.num_nodes(); ++i)
    for (int c = 0; c < facets.gdim; ++c)
      d[c] -= phi[i] * facets.x_of(f)[i * facets.gdim + c];
  return std::sqrt(dot(d, d, facets.gdim));
}
} // namespace

SurfaceSearch::SurfaceSearch(const surface::Facets& master) : _master(&master)
{
  bounding_boxes(master, _boxes);
  _tree = BoxTree(master.gdim, _boxes);
  update();
}

void SurfaceSearch::update()
{
  const int gdim = _master->gdim;
  bounding_boxes(*_master, _boxes);
  _tree.refit(_boxes);
  _bend.resize(_master->size());
  _size.resize(_master->size());
  for (std::size_t f = 0; f < _master->size(); ++f)
  {
    _bend[f] = bend(_master->geometry, gdim, _master->x_of(f));
    double squared = 0.0;
    for (int c = 0; c < gdim; ++c)
      squared += std::pow(_boxes[2 * gdim * f + gdim + c] - _boxes[2 * gdim * f + c], 2);
    _size[f] = std::sqrt(squared);
  }
}

Starts SurfaceSearch::starts(std::int32_t f, const double* x) const
{
  return _bend[f].starts(centre_distance(*_master, f, x));
}

Projection SurfaceSearch::project(const double* x, const double* slave_normal, double reach, std::int32_t previous,
                                  double margin) const
{
  const surface::Facets& m = *_master;
  const auto faces = [&](std::int32_t f, const double* xi)
  { return dot(surface::evaluate(m, f, m.x_of(f), xi).normal, slave_normal, m.gdim) < -right_angle; };
  Projection out;
  FacetProjection best;
  const auto visit = [&](std::int32_t f)
  {
    const FacetProjection at = project_on_facet(m.geometry, m.gdim, m.x_of(f), x, starts(f, x));
    if (at.distance <= reach &&
        (out.facet < 0 || closer(at, _master->id[f], best, _master->id[out.facet], _size[out.facet])) &&
        faces(f, at.xi))
    {
      best = at;
      out.facet = f;
    }
    const double limit = out.facet < 0 ? reach : best.distance + 2e-12 * (best.distance + _size[out.facet]);
    return limit * limit;
  };
  _tree.nearest(x, reach * reach, visit);
  if (out.facet < 0)
    return out;
  if (previous >= 0 && previous < std::int32_t(m.size()) && previous != out.facet)
  {
    const FacetProjection at = project_on_facet(m.geometry, m.gdim, m.x_of(previous), x, Starts::all, margin);
    if (at.status == ProjectionStatus::converged && at.distance <= best.distance + 1e-3 * _size[previous] &&
        at.distance <= reach && faces(previous, at.xi))
    {
      best = at;
      out.facet = previous;
    }
  }
  finish(x, best, out);
  return out;
}

void SurfaceSearch::finish(const double* x, const FacetProjection& at, Projection& out) const
{
  const surface::Facets& m = *_master;
  const surface::FacetPoint p = surface::evaluate(m, out.facet, m.x_of(out.facet), at.xi);
  out.status = at.status;
  out.entity = at.entity;
  std::copy_n(at.xi, 2, out.xi);
  std::copy_n(p.normal, 3, out.normal);
  double d[3] = {0.0, 0.0, 0.0};
  for (int c = 0; c < m.gdim; ++c)
    d[c] = x[c] - p.x[c];
  out.gap = dot(d, p.normal, m.gdim);
  if (at.status == ProjectionStatus::converged)
    return;
  if (at.distance <= 1e-10 * _size[out.facet])
  {
    // d has no direction: the point counts as one of the facet.
    out.status = ProjectionStatus::converged;
    out.entity = -1;
    return;
  }
  double mean[3];
  const bool ends = mean_normal(at, out.facet, mean) && beside(m.gdim, d, mean, _size[out.facet]);
  if (ends)
    out.rim = Projection::Rim::beside;
  const double sign = ends || dot(d, mean, m.gdim) >= 0.0 ? 1.0 : -1.0;
  out.gap = sign * at.distance;
  for (int c = 0; c < m.gdim; ++c)
    out.normal[c] = d[c] / out.gap;
}

/// Mean normal of the facets that meet at an edge or vertex.
/// @returns whether the surface ends there
bool SurfaceSearch::mean_normal(const FacetProjection& at, std::int32_t facet, double* normal) const
{
  const surface::Facets& m = *_master;
  double box[6];
  for (int c = 0; c < m.gdim; ++c)
  {
    box[c] = at.x[c] - 1e-9 * _size[facet];
    box[m.gdim + c] = at.x[c] + 1e-9 * _size[facet];
  }
  const auto normal_at = [&](std::int32_t f, const double* xi, double* n)
  { std::copy_n(surface::evaluate(m, f, m.x_of(f), xi).normal, 3, n); };
  return search::mean_normal(m, at, facet, [&](auto&& visit) { _tree.overlapping(box, visit); }, normal_at, normal);
}
} // namespace dolfinx_impact::search
