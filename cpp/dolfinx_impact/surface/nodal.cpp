// SPDX-License-Identifier: MIT
#include "nodal.h"
#include "normals.h"
#include "quadrature.h"
#include <numbers>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::surface
{
namespace
{
/// Parts of a facet's area that its nodes have: integrals of squared shape functions, adding up to one.
std::vector<double> shares(const FacetElement& element)
{
  const QuadratureRule exact = quadrature(element.shape, 2 * element.degree * element.tdim());
  std::vector<double> out(element.num_nodes(), 0.0);
  double phi[FacetElement::max_nodes], sum = 0.0;
  for (std::size_t q = 0; q < exact.weights.size(); ++q)
  {
    element.values(exact.points.data() + q * element.tdim(), phi);
    for (int i = 0; i < element.num_nodes(); ++i)
    {
      out[i] += exact.weights[q] * phi[i] * phi[i];
      sum += exact.weights[q] * phi[i] * phi[i];
    }
  }
  for (double& share : out)
    share /= sum;
  return out;
}
} // namespace

void add_nodal_areas(const Facets& facets, bool axisymmetric, std::vector<double>& areas,
                     std::span<const double> factors)
{
  if (!factors.empty() && factors.size() != facets.size())
    throw std::invalid_argument("nodal areas need a factor for each of " + std::to_string(facets.size()) + " facets");
  const FacetElement& element = facets.displacement;
  const int n = element.num_nodes(), tdim = element.tdim();
  const QuadratureRule gauss = quadrature(element.shape, 5);
  const std::vector<double> share = element.degree == 2 ? shares(element) : std::vector<double>();
  for (std::size_t f = 0; f < facets.size(); ++f)
    for (std::size_t q = 0; q < gauss.weights.size(); ++q)
    {
      const double xi[2] = {gauss.points[q * tdim], tdim == 2 ? gauss.points[q * tdim + 1] : 0.0};
      const FacetPoint p = evaluate(facets, f, facets.X_of(f), xi);
      const double area = gauss.weights[q] * p.jacobian * (axisymmetric ? 2 * std::numbers::pi * p.x[0] : 1.0) *
                          (factors.empty() ? 1.0 : factors[f]);
      double phi[FacetElement::max_nodes];
      element.values(xi, phi);
      for (int i = 0; i < n; ++i)
        areas[facets.nodes_of(f)[i]] += area * (share.empty() ? phi[i] : share[i]);
    }
}
} // namespace dolfinx_impact::surface
