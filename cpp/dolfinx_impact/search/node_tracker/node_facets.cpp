// SPDX-License-Identifier: MIT
#include "../../common/vectors.h"
#include "NodeTracking.h"
#include "../closest_point/linear_facet.h"
#include "../closest_point/edge_normals.h"
#include <algorithm>
#include <cmath>

// What a facet is to a node: positions, projection, normal, box, what the rim makes of them.
namespace dolfinx_impact::search
{
namespace
{
using surface::FacetElement;
using surface::FacetShape;
constexpr int max_values = 3 * FacetElement::max_nodes;

/// Where the first nodes of a facet are in an array of positions.
struct Corners
{
  const double* X[4];
  Corners(const double* facet, int gdim)
  {
    for (int i = 0; i < 4; ++i)
      X[i] = facet + i * gdim;
  }
};
} // namespace

void NodeTracking::position(std::size_t i, Configuration at, double* x) const
{
  const std::size_t k = std::size_t(_node[i].number) * _gdim;
  for (int c = 0; c < _gdim; ++c)
    x[c] = _node[i].X[c] + at.at(k + c);
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
        x[i * _gdim + c] = X[i * _gdim + c] + at.at(k);
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
        sum += _phi[i * n_u + j] * at.at(k);
      }
      x[i * _gdim + c] = sum;
    }
}

FacetProjection NodeTracking::project(std::int32_t f, const double* facet, const double* x, const double* start) const
{
  ++_counters.projections;
  FacetProjection out;
  bool found = false;
  const Corners corners(facet, _gdim);
  switch (_kind)
  {
  case Kind::interval:
    found = linear::project<FacetShape::interval>(corners.X, x, start, out);
    break;
  case Kind::triangle:
    found = linear::project<FacetShape::triangle>(corners.X, x, start, out);
    break;
  case Kind::quadrilateral:
    found = linear::project<FacetShape::quadrilateral>(corners.X, x, start, out);
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
  const Corners corners(facet, _gdim);
  switch (_kind)
  {
  case Kind::interval:
    return linear::normal<FacetShape::interval>(corners.X, xi, sign, normal);
  case Kind::triangle:
    return linear::normal<FacetShape::triangle>(corners.X, xi, sign, normal);
  case Kind::quadrilateral:
    return linear::normal<FacetShape::quadrilateral>(corners.X, xi, sign, normal);
  case Kind::general:
    std::copy_n(surface::evaluate(_master, f, facet, xi).normal, 3, normal);
  }
}

/// The distance of the box around a facet: never more than that of the facet itself. Zero if not known.
double NodeTracking::box_distance(std::int32_t f, const double* x) const
{
  const auto corner = [&](int j) { return _masters[corners(f)[j]].x; };
  const double* X[4];
  switch (_kind)
  {
  case Kind::interval:
    for (int j = 0; j < 2; ++j)
      X[j] = corner(j);
    return std::sqrt(linear::box_distance<FacetShape::interval>(X, x));
  case Kind::triangle:
    for (int j = 0; j < 3; ++j)
      X[j] = corner(j);
    return std::sqrt(linear::box_distance<FacetShape::triangle>(X, x));
  case Kind::quadrilateral:
    for (int j = 0; j < 4; ++j)
      X[j] = corner(j);
    return std::sqrt(linear::box_distance<FacetShape::quadrilateral>(X, x));
  case Kind::general:
    break;
  }
  return 0.0;
}

void NodeTracking::finish(const double* x, const double* normal, const FacetProjection& at, Configuration config,
                          std::span<const std::int32_t> near, Projection& out) const
{
  out.status = at.status;
  out.entity = at.entity;
  std::copy_n(at.xi, 2, out.xi);
  std::copy_n(normal, 3, out.normal);
  double d[3] = {0.0, 0.0, 0.0};
  for (int c = 0; c < _gdim; ++c)
    d[c] = x[c] - at.x[c];
  const double along = dot(d, normal, _gdim);
  out.gap = out.clearance = along;
  if (at.status == ProjectionStatus::converged)
    return;
  if (at.distance <= 1e-10 * _size[out.facet])
  {
    // d has no direction: the node counts as one of the facet.
    out.status = ProjectionStatus::converged;
    out.entity = -1;
    out.rim = Projection::Rim::near;
    return;
  }
  double mean[3];
  const bool rim = mean_normal(at, out.facet, config, near, mean);
  // Beside the rim by less than a twentieth of the facet: over the facet. Flush edges stay in contact.
  const double far = 0.05 * _size[out.facet];
  const double aside = std::sqrt(std::max(at.distance * at.distance - along * along, 0.0));
  if (rim && aside < far)
  {
    out.rim = Projection::Rim::near;
    return;
  }
  const bool ends = rim && beside(_gdim, d, mean, _size[out.facet]);
  out.gap = (ends || dot(d, mean, _gdim) >= 0.0 ? 1.0 : -1.0) * at.distance;
  out.clearance = out.gap;
  if (rim)
  {
    // The gap jumps where a node comes in from the side, also because the facet turns.
    out.rim = along < 0.0 ? Projection::Rim::below : Projection::Rim::beside;
    out.clearance = 0.0;
  }
  for (int c = 0; c < _gdim; ++c)
    out.normal[c] = d[c] / out.gap;
}

/// Mean normal of the facets that meet at an edge or vertex; they are all in the list.
/// @returns whether the surface ends there
bool NodeTracking::mean_normal(const FacetProjection& at, std::int32_t facet, Configuration config,
                               std::span<const std::int32_t> near, double* normal) const
{
  const auto each_near = [&](auto&& visit) { std::for_each(near.begin(), near.end(), visit); };
  const auto normal_at = [&](std::int32_t f, const double* xi, double* n)
  {
    double positions_of[max_values];
    positions(f, config, positions_of);
    facet_normal(f, positions_of, xi, n);
  };
  return search::mean_normal(_master, at, facet, each_near, normal_at, normal);
}
} // namespace dolfinx_impact::search
