// SPDX-License-Identifier: MIT
#include "SkipBound.h"
#include "../../common/vectors.h"
#include "NormalRotation.h"
#include <algorithm>

namespace dolfinx_impact::search
{
namespace
{
constexpr int max_values = 3 * surface::FacetElement::max_nodes;
constexpr double least_margin = 0.1; ///< below this product of normals, facing may change soon
constexpr double beside_rim = 0.05;  ///< of the facet: by so much a node with Projection::Rim::near may be outside
} // namespace

void SkipBound::must_not_rotate(double margin, double rate)
{
  _rotates = true;
  _margin = std::min(_margin, margin);
  _rate = std::max(_rate, rate);
}

void SkipBound::limit(double path)
{
  _path = std::min(_path, path);
}

bool SkipBound::set_nearest(const Projection& at)
{
  double nodes[max_values], normal[3] = {};
  _surface->positions(at.facet, {_u}, nodes);
  _surface->normal(at.facet, nodes, at.xi, normal);
  const double margin = -dot(normal, _slave_normal, _surface->facets().gdim) - _rotation;
  if (!(margin > least_margin))
    return false;
  must_not_rotate(margin, _surface->rotation_rate(at.facet, nodes, at.xi));
  _nearest = true;
  // Just outside the rim the gap is less than the distance.
  _distance = at.gap + (at.rim == Projection::Rim::near ? beside_rim * _surface->diameter(at.facet) : 0.0);
  return true;
}

// In front of facets gaps are positive, whichever of them face the node, until one of them is reached. Of those behind
// which the node is, the ones that face it must not become the nearest; the others must not rotate until they face it.
void SkipBound::add(std::int32_t f)
{
  const int gdim = _surface->facets().gdim;
  double nodes[max_values], normal[3] = {}, along = 0.0;
  _surface->positions(f, {_u}, nodes);
  const FacetProjection at = _surface->project(f, nodes, _x, nullptr);
  _surface->normal(f, nodes, at.xi, normal);
  for (int c = 0; c < gdim; ++c)
    along += (_x[c] - at.x[c]) * normal[c];
  const double farther = at.distance - _distance, free = std::max(0.0, _nearest ? 0.5 * farther : farther);
  if (along > 0.0)
    limit(at.status == ProjectionStatus::converged ? at.distance : std::max(along, free));
  else if (const double margin = dot(normal, _slave_normal, gdim) - _rotation; margin > least_margin)
    must_not_rotate(margin, _surface->rotation_rate(f, nodes, at.xi));
  else
    limit(free);
}

double SkipBound::deformation(double slave_rate) const
{
  // Half of the margin is for normals that differ from place to place on a facet.
  return std::min(0.5 * _margin, NormalRotation::most) / std::max(_rate, slave_rate);
}
} // namespace dolfinx_impact::search
