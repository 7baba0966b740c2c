// SPDX-License-Identifier: MIT
#include "normals.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::surface
{
namespace
{
FacetPoint point(const FacetElement& element, int gdim, const double* x, const double* xi, double sign)
{
  FacetPoint p{};
  double phi[FacetElement::max_nodes], dphi[2 * FacetElement::max_nodes];
  element.values(xi, phi);
  element.derivatives(xi, dphi);
  const int n = element.num_nodes();
  for (int i = 0; i < n; ++i)
    for (int c = 0; c < gdim; ++c)
    {
      p.x[c] += phi[i] * x[i * gdim + c];
      for (int a = 0; a < element.tdim(); ++a)
        p.tangents[a][c] += dphi[a * n + i] * x[i * gdim + c];
    }
  normal_vector(gdim, p.tangents, p.normal);
  p.jacobian = std::sqrt(p.normal[0] * p.normal[0] + p.normal[1] * p.normal[1] + p.normal[2] * p.normal[2]);
  for (double& c : p.normal)
    c *= sign / p.jacobian;
  return p;
}
} // namespace

FacetPoint evaluate(const Facets& facets, std::size_t f, const double* x, const double* xi)
{
  return point(facets.geometry, facets.gdim, x, xi, facets.orientation[f]);
}

std::int8_t orientation(const FacetElement& element, int gdim, const double* X, const double* cell_centre)
{
  const auto centre = element.centre();
  const FacetPoint p = point(element, gdim, X, centre.data(), 1.0);
  double outward = 0.0;
  for (int c = 0; c < gdim; ++c)
    outward += p.normal[c] * (p.x[c] - cell_centre[c]);
  return outward >= 0.0 ? 1 : -1;
}

double diameter(const Facets& facets, std::size_t f)
{
  const double* X = facets.X_of(f);
  double largest = 0.0;
  for (int i = 0; i < facets.geometry.num_corners(); ++i)
    for (int j = 0; j < i; ++j)
    {
      double squared = 0.0;
      for (int c = 0; c < facets.gdim; ++c)
        squared += std::pow(X[i * facets.gdim + c] - X[j * facets.gdim + c], 2);
      largest = std::max(largest, squared);
    }
  return std::sqrt(largest);
}

void move(Facets& facets, const double* u)
{
  const int gdim = facets.gdim, n_u = facets.displacement.num_nodes(), n_x = facets.geometry.num_nodes();
  double phi[FacetElement::max_nodes][FacetElement::max_nodes];
  for (int i = 0; i < n_x; ++i)
    facets.displacement.values(facets.geometry.node(i).data(), phi[i]);
  const bool same = facets.displacement == facets.geometry;
  facets.x = facets.X;
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    const std::int32_t* nodes = facets.nodes_of(f);
    double* x = facets.x.data() + f * n_x * gdim;
    for (int i = 0; i < n_x; ++i)
      for (int k = same ? i : 0; k < (same ? i + 1 : n_u); ++k)
        for (int c = 0; c < gdim; ++c)
          x[i * gdim + c] += phi[i][k] * u[nodes[k] * gdim + c];
  }
}
} // namespace dolfinx_impact::surface
