// SPDX-License-Identifier: MIT
#include "turned.h"

namespace dolfinx_impact::surface
{
FacetFrame frame_of(const Facets& facets, const double* corners)
{
  const FacetElement& element = facets.displacement;
  double dphi[2 * FacetElement::max_nodes];
  element.derivatives(element.centre().data(), dphi);
  FacetFrame frame;
  frame.set(facets.gdim, element.num_nodes(), dphi, [&](int j, int c) { return corners[j * facets.gdim + c]; });
  return frame;
}

std::vector<double> offset_components(const Facets& facets)
{
  if (!facets.smooth)
    return {};
  const int gdim = facets.gdim, n_u = facets.displacement.num_nodes(), n_x = facets.geometry.num_nodes();
  std::vector<double> out(facets.size() * n_x * gdim, 0.0);
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    const double* X = facets.X_of(f); // the corners are the first of the geometry nodes
    const FacetFrame frame = frame_of(facets, X);
    for (int i = n_u; i < n_x; ++i)
    {
      double phi[FacetElement::max_nodes], offset[3];
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
  return out;
}

void turned_positions(const Facets& facets, const double* components, const double* corners, double* x)
{
  const int gdim = facets.gdim, n_u = facets.displacement.num_nodes(), n_x = facets.geometry.num_nodes();
  const FacetFrame frame = frame_of(facets, corners);
  for (int i = 0; i < n_x; ++i)
  {
    double phi[FacetElement::max_nodes], offset[3] = {0.0, 0.0, 0.0};
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

void move_and_turn(Facets& facets, const std::vector<double>& components, const double* u)
{
  if (!facets.smooth)
    return move(facets, u);
  const int gdim = facets.gdim, n_u = facets.displacement.num_nodes(), n_x = facets.geometry.num_nodes();
  double corners[3 * FacetElement::max_nodes];
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    for (int j = 0; j < n_u; ++j)
      for (int c = 0; c < gdim; ++c)
        corners[j * gdim + c] = facets.X_of(f)[j * gdim + c] + u[std::size_t(facets.nodes_of(f)[j]) * gdim + c];
    turned_positions(facets, components.data() + f * n_x * gdim, corners, facets.x.data() + f * n_x * gdim);
  }
}
} // namespace dolfinx_impact::surface
