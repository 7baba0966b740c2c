// SPDX-License-Identifier: MIT
#include "turned.h"

namespace dolfinx_impact::surface
{
namespace
{
/// Most corners of a facet. Smooth facets are of degree 1: corners are all nodes that have displacements.
constexpr int most_corners = 4;

template <int gdim>
void add_components(const Facets& facets, std::vector<double>& out)
{
  const int n_u = facets.displacement.num_corners(), n_x = facets.geometry.num_nodes();
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    const double* X = facets.X_of(f); // the corners are the first of the geometry nodes
    const FacetFrame<gdim> frame = frame_of<gdim>(facets, X);
    for (int i = n_u; i < n_x; ++i)
    {
      double phi[FacetElement::max_nodes], offset[gdim];
      facets.displacement.values(facets.geometry.node(i).data(), phi);
      for (int c = 0; c < gdim; ++c)
      {
        offset[c] = X[i * gdim + c];
        for (int j = 0; j < n_u; ++j)
          offset[c] -= phi[j] * X[j * gdim + c];
      }
      frame.components(offset, out.data() + (f * n_x + i) * gdim);
    }
  }
}

/// Positions of a facet's geometry nodes; see turned_positions.
template <int gdim>
void turn(const Facets& facets, const double* components, const double* corners, double* x)
{
  const int n_u = facets.displacement.num_corners(), n_x = facets.geometry.num_nodes();
  const FacetFrame<gdim> frame = frame_of<gdim>(facets, corners);
  for (int i = 0; i < n_x; ++i)
  {
    double phi[FacetElement::max_nodes], offset[gdim] = {};
    facets.displacement.values(facets.geometry.node(i).data(), phi);
    if (i >= n_u)
      frame.vector(components + i * gdim, offset);
    for (int c = 0; c < gdim; ++c)
    {
      double sum = offset[c];
      for (int j = 0; j < n_u; ++j)
        sum += phi[j] * corners[j * gdim + c];
      x[i * gdim + c] = sum;
    }
  }
}

template <int gdim>
void move_and_turn_all(Facets& facets, const std::vector<double>& components, const double* u)
{
  const int n_u = facets.displacement.num_corners(), n_x = facets.geometry.num_nodes();
  double corners[gdim * most_corners];
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    for (int j = 0; j < n_u; ++j)
      for (int c = 0; c < gdim; ++c)
        corners[j * gdim + c] = facets.X_of(f)[j * gdim + c] + u[std::size_t(facets.nodes_of(f)[j]) * gdim + c];
    turn<gdim>(facets, components.data() + f * n_x * gdim, corners, facets.x.data() + f * n_x * gdim);
  }
}
} // namespace

template <int gdim>
FacetFrame<gdim> frame_of(const Facets& facets, const double* corners)
{
  const FacetElement& element = facets.displacement;
  double dphi[2 * FacetElement::max_nodes];
  element.derivatives(element.centre().data(), dphi);
  FacetFrame<gdim> frame;
  frame.set(element.num_corners(), dphi, [&](int j, int c) { return corners[j * gdim + c]; });
  return frame;
}
template FacetFrame<2> frame_of<2>(const Facets&, const double*);
template FacetFrame<3> frame_of<3>(const Facets&, const double*);

std::vector<double> offset_components(const Facets& facets)
{
  if (!facets.smooth)
    return {};
  std::vector<double> out(facets.size() * facets.geometry.num_nodes() * facets.gdim, 0.0);
  facets.gdim == 2 ? add_components<2>(facets, out) : add_components<3>(facets, out);
  return out;
}

void move_and_turn(Facets& facets, const std::vector<double>& components, const double* u)
{
  if (!facets.smooth)
    return move(facets, u);
  facets.gdim == 2 ? move_and_turn_all<2>(facets, components, u) : move_and_turn_all<3>(facets, components, u);
}
} // namespace dolfinx_impact::surface
