// SPDX-License-Identifier: MIT
#include "TrackedSurface.h"
#include "../../common/vectors.h"
#include "../../surface/normals.h"
#include "../../surface/turned.h"
#include "../boxes.h"
#include "../closest_point/edge_normals.h"
#include "../closest_point/linear_facet.h"
#include "NormalRotation.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::search
{
namespace
{
using surface::FacetElement;
using surface::FacetShape;
constexpr double shallow = 0.05; ///< of the facet: points outside the rim by less count as over the facet

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

/// Upper bound on the motion of the offsets of smooth facets per motion of a corner. With the components k of an offset
/// it is C (|k_1| + |k_2|) + 2.94 Q |k_n| (NormalRotation), Q and C those of the flat facet's centre.
template <int gdim>
double largest_offset_motion(const surface::Facets& facets, const std::vector<double>& offsets)
{
  if (!facets.smooth)
    return 0.0;
  const int n_x = facets.geometry.num_nodes();
  const double slope = NormalRotation::slope(facets.displacement);
  double largest = 0.0;
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    const surface::FacetFrame<gdim> frame = surface::frame_of<gdim>(facets, facets.X_of(f));
    const double rate = NormalRotation::rate(gdim - 1, frame.axes, slope);
    for (int i = 0; i < n_x; ++i)
    {
      const double* k = offsets.data() + (f * n_x + i) * gdim;
      double along = 0.0;
      for (int a = 0; a < gdim - 1; ++a)
        along += std::abs(k[a]);
      largest = std::max(largest, slope * along + 2.94 * rate * std::abs(k[gdim - 1]));
    }
  }
  return largest;
}
/// Longest offset of a geometry node from the flat facet: no place of the facet has a longer one, as the functions of
/// these nodes are positive and their sum is at most 1, but for a fifth on triangles.
double largest_offset(const surface::Facets& facets, std::size_t f)
{
  const int gdim = facets.gdim, n_u = facets.displacement.num_nodes();
  const double* X = facets.X_of(f);
  double largest = 0.0;
  for (int i = n_u; i < facets.geometry.num_nodes(); ++i)
  {
    double phi[FacetElement::max_nodes], squared = 0.0;
    facets.displacement.values(facets.geometry.node(i).data(), phi);
    for (int c = 0; c < gdim; ++c)
    {
      double d = X[i * gdim + c];
      for (int j = 0; j < n_u; ++j)
        d -= phi[j] * X[j * gdim + c];
      squared += d * d;
    }
    largest = std::max(largest, std::sqrt(squared));
  }
  return largest;
}
} // namespace

void TrackedSurface::reset(surface::Facets facets)
{
  _facets = std::move(facets);
  const int gdim = _facets.gdim;
  const FacetElement& element = _facets.geometry;
  const int n_x = element.num_nodes(), n_u = _facets.displacement.num_nodes();
  const bool linear = element.degree == 1 && _facets.displacement.degree == 1;
  _kind =
      linear && int(element.shape == FacetShape::interval) == int(gdim == 2) ? Kind(int(element.shape)) : Kind::general;
  _diameters.assign(_facets.size(), 0.0);
  for (std::size_t f = 0; f < _facets.size(); ++f)
    _diameters[f] = surface::diameter(_facets, f);
  _largest = _diameters.empty() ? 0.0 : *std::max_element(_diameters.begin(), _diameters.end());
  _offsets = surface::offset_components(_facets);
  _stretch =
      1.0 + (gdim == 2 ? largest_offset_motion<2>(_facets, _offsets) : largest_offset_motion<3>(_facets, _offsets));
  _height.assign(_facets.smooth ? _facets.size() : 0, 0.0);
  _starts.assign(_height.size(), Starts::nearest);
  for (std::size_t f = 0; f < _height.size(); ++f)
  {
    // Room for facets that are stretched, and then are bent otherwise.
    _height[f] = 2.0 * largest_offset(_facets, f);
    if (gdim == 3)
      _starts[f] = bend(element, gdim, _facets.X_of(f)).starts(4 * _diameters[f]);
  }
  _slope = _stretch * NormalRotation::slope(element);
  _phi.assign(n_x * n_u, 0.0);
  for (int i = 0; i < n_x; ++i)
    _facets.displacement.values(element.node(i).data(), _phi.data() + i * n_u);
  _centre.assign(2 * FacetElement::max_nodes, 0.0);
  _facets.displacement.derivatives(_facets.displacement.centre().data(), _centre.data());
  bounding_boxes(_facets, _boxes);
  _tree = BoxTree(gdim, _boxes);
  _nodes = _facets.nodes;
  std::sort(_nodes.begin(), _nodes.end());
  _nodes.erase(std::unique(_nodes.begin(), _nodes.end()), _nodes.end());
  _undeformed.assign(_nodes.size() * gdim, 0.0);
  _node_data.assign(_nodes.size(), {});
  _nodes_per_facet = n_u;
  _corners.resize(_facets.nodes.size());
  for (std::size_t f = 0; f < _facets.size(); ++f)
    for (int j = 0; j < n_u; ++j)
    {
      const std::size_t k = f * n_u + j;
      const auto at = std::lower_bound(_nodes.begin(), _nodes.end(), _facets.nodes[k]);
      _corners[k] = std::int32_t(at - _nodes.begin());
      std::copy_n(_facets.X_of(f) + j * gdim, gdim, _undeformed.data() + std::size_t(_corners[k]) * gdim);
    }
}

double TrackedSurface::moved(const double* u) const
{
  const int gdim = _facets.gdim;
  double largest = 0.0;
  for (std::size_t k = 0; k < _nodes.size(); ++k)
    for (int c = 0; c < gdim; ++c)
    {
      const double x = _undeformed[k * gdim + c] + u[std::size_t(_nodes[k]) * gdim + c];
      largest = std::max(largest, std::abs(x - _node_data[k].x[c]));
    }
  return _stretch * std::sqrt(double(gdim)) * largest;
}

/// As surface::turned_positions, with the values of shape functions that are known here.
template <int gdim>
void TrackedSurface::smooth_positions(std::int32_t f, Configuration at, double* x) const
{
  const int n_x = _facets.geometry.num_nodes(), n_u = _facets.displacement.num_corners();
  const std::int32_t* nodes = _facets.nodes_of(f);
  const double *X = _facets.X_of(f), *offsets = _offsets.data() + std::size_t(f) * n_x * gdim;
  for (int j = 0; j < n_u; ++j) // the corners are the first of the geometry nodes
    for (int c = 0; c < gdim; ++c)
      x[j * gdim + c] = X[j * gdim + c] + at.at(std::size_t(nodes[j]) * gdim + c);
  surface::FacetFrame<gdim> frame;
  frame.set(n_u, _centre.data(), [&](int j, int c) { return x[j * gdim + c]; });
  for (int i = n_u; i < n_x; ++i)
  {
    double offset[gdim];
    frame.vector(offsets + i * gdim, offset);
    for (int c = 0; c < gdim; ++c)
    {
      double sum = offset[c];
      for (int j = 0; j < n_u; ++j)
        sum += _phi[i * n_u + j] * x[j * gdim + c];
      x[i * gdim + c] = sum;
    }
  }
}

void TrackedSurface::positions(std::int32_t f, Configuration at, double* x) const
{
  const int gdim = _facets.gdim, n_x = _facets.geometry.num_nodes(), n_u = _facets.displacement.num_nodes();
  const std::int32_t* nodes = _facets.nodes_of(f);
  const double* X = _facets.X_of(f);
  if (n_x == n_u)
  {
    for (int i = 0; i < n_x; ++i)
      for (int c = 0; c < gdim; ++c)
      {
        const std::size_t k = std::size_t(nodes[i]) * gdim + c;
        x[i * gdim + c] = X[i * gdim + c] + at.at(k);
      }
    return;
  }
  if (_facets.smooth)
  {
    gdim == 2 ? smooth_positions<2>(f, at, x) : smooth_positions<3>(f, at, x);
    return;
  }
  for (int i = 0; i < n_x; ++i)
    for (int c = 0; c < gdim; ++c)
    {
      double sum = X[i * gdim + c];
      for (int j = 0; j < n_u; ++j)
      {
        const std::size_t k = std::size_t(nodes[j]) * gdim + c;
        sum += _phi[i * n_u + j] * at.at(k);
      }
      x[i * gdim + c] = sum;
    }
}

FacetProjection TrackedSurface::project(std::int32_t f, const double* facet, const double* x, const double* start) const
{
  ++_projections;
  FacetProjection out;
  bool found = false;
  const Corners corners(facet, _facets.gdim);
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
  const bool curved = _facets.geometry.tdim() == 2;
  const Starts starts = !curved          ? Starts::nearest
                        : _facets.smooth ? _starts[f]
                                         : bend(_facets.geometry, _facets.gdim, facet).starts(2 * _diameters[f]);
  return project_on_facet(_facets.geometry, _facets.gdim, facet, x, starts, linear::margin, start);
}

void TrackedSurface::normal(std::int32_t f, const double* facet, const double* xi, double* normal) const
{
  const double sign = _facets.orientation[f];
  const Corners corners(facet, _facets.gdim);
  switch (_kind)
  {
  case Kind::interval:
    return linear::normal<FacetShape::interval>(corners.X, xi, sign, normal);
  case Kind::triangle:
    return linear::normal<FacetShape::triangle>(corners.X, xi, sign, normal);
  case Kind::quadrilateral:
    return linear::normal<FacetShape::quadrilateral>(corners.X, xi, sign, normal);
  case Kind::general:
    std::copy_n(surface::evaluate(_facets, f, facet, xi).normal, 3, normal);
  }
}

template <FacetShape S>
void TrackedSurface::flat_normal_before(std::int32_t f, const double* xi, double* normal) const
{
  constexpr int D = linear::dimension<S>;
  const std::int32_t* corners = this->corners(f);
  double x[linear::num_nodes<S>][D];
  for (int j = 0; j < linear::num_nodes<S>; ++j)
    for (int c = 0; c < D; ++c)
      x[j][c] = _node_data[corners[j]].x[c] - _node_data[corners[j]].du[c];
  linear::normal<S>(x, xi, _facets.orientation[f], normal);
}

void TrackedSurface::normal_before(std::int32_t f, const double* xi, const double* u, const double* du,
                                   double* normal) const
{
  switch (_kind)
  {
  case Kind::interval:
    return flat_normal_before<FacetShape::interval>(f, xi, normal);
  case Kind::triangle:
    return flat_normal_before<FacetShape::triangle>(f, xi, normal);
  case Kind::quadrilateral:
    return flat_normal_before<FacetShape::quadrilateral>(f, xi, normal);
  case Kind::general:
    double x[3 * FacetElement::max_nodes];
    positions(f, {u, du}, x);
    return this->normal(f, x, xi, normal);
  }
}

double TrackedSurface::rotation_rate(std::int32_t f, const double* facet, const double* xi) const
{
  return NormalRotation::factor *
         NormalRotation::rate(_facets.gdim - 1, surface::evaluate(_facets, f, facet, xi).tangents, _slope);
}

double TrackedSurface::box_distance(std::int32_t f, const double* x) const
{
  if (_kind == Kind::general && !_facets.smooth)
    return 0.0;
  const double* X[4];
  for (int j = 0; j < std::min(_nodes_per_facet, 4); ++j)
    X[j] = _node_data[corners(f)[j]].x;
  double squared = 0.0;
  switch (_facets.displacement.shape)
  {
  case FacetShape::interval:
    squared = linear::box_distance<FacetShape::interval>(X, x);
    break;
  case FacetShape::triangle:
    squared = linear::box_distance<FacetShape::triangle>(X, x);
    break;
  case FacetShape::quadrilateral:
    squared = linear::box_distance<FacetShape::quadrilateral>(X, x);
    break;
  }
  return std::max(std::sqrt(squared) - (_facets.smooth ? _height[f] : 0.0), 0.0);
}

Projection TrackedSurface::closest_point(const double* x, std::int32_t facet, const double* normal,
                                         const FacetProjection& at, Configuration configuration,
                                         std::span<const std::int32_t> near) const
{
  const int gdim = _facets.gdim;
  const double diameter = _diameters[facet];
  Projection out;
  out.facet = facet;
  out.status = at.status;
  out.entity = at.entity;
  std::copy_n(at.xi, 2, out.xi);
  std::copy_n(normal, 3, out.normal);
  double d[3] = {0.0, 0.0, 0.0};
  for (int c = 0; c < gdim; ++c)
    d[c] = x[c] - at.x[c];
  const double along = dot(d, normal, gdim);
  out.gap = out.clearance = along;
  if (at.status == ProjectionStatus::converged)
    return out;
  if (at.distance <= 1e-10 * diameter)
  {
    // d has no direction: the node counts as one of the facet.
    out.status = ProjectionStatus::converged;
    out.entity = -1;
    out.rim = Projection::Rim::near;
    return out;
  }
  double mean[3];
  const bool rim = mean_normal(at, facet, configuration, near, mean);
  // Outside the rim by less than a twentieth of the facet: over the facet. Flush edges stay in contact.
  const double aside = std::sqrt(std::max(at.distance * at.distance - along * along, 0.0));
  if (rim && aside < shallow * diameter)
  {
    out.rim = Projection::Rim::near;
    return out;
  }
  const bool ends = rim && beside(gdim, d, mean, diameter);
  out.gap = (ends || dot(d, mean, gdim) >= 0.0 ? 1.0 : -1.0) * at.distance;
  out.clearance = out.gap;
  if (rim)
  {
    // The gap jumps where a node comes in from the side, also because the facet rotates.
    out.rim = along < 0.0 ? Projection::Rim::below : Projection::Rim::beside;
    out.clearance = 0.0;
  }
  for (int c = 0; c < gdim; ++c)
    out.normal[c] = d[c] / out.gap;
  return out;
}

/// Mean normal of the facets that meet at an edge or vertex; they are all in the list.
/// @returns whether the surface ends there
bool TrackedSurface::mean_normal(const FacetProjection& at, std::int32_t facet, Configuration configuration,
                                 std::span<const std::int32_t> near, double* normal) const
{
  const auto each_near = [&](auto&& visit) { std::for_each(near.begin(), near.end(), visit); };
  const auto normal_at = [&](std::int32_t f, const double* xi, double* n)
  {
    double nodes[3 * FacetElement::max_nodes];
    positions(f, configuration, nodes);
    this->normal(f, nodes, xi, n);
  };
  return search::mean_normal(_facets, at, facet, each_near, normal_at, normal);
}

void TrackedSurface::fit_tree(const double* u)
{
  for (std::size_t f = 0; f < _facets.size(); ++f)
    positions(std::int32_t(f), {u}, _facets.x.data() + f * _facets.geometry.num_nodes() * _facets.gdim);
  bounding_boxes(_facets, _boxes);
  _tree.refit(_boxes);
}
} // namespace dolfinx_impact::search
