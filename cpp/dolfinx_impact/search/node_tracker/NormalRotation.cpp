// SPDX-License-Identifier: MIT
#include "NormalRotation.h"
#include "../../common/vectors.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::search
{
using surface::FacetElement;

double NormalRotation::rate(int tdim, const double a[2][3], double slope)
{
  const double first = std::sqrt(dot(a[0], a[0], 3));
  if (tdim == 1)
    return 0.5 * slope / first;
  const double second = std::sqrt(dot(a[1], a[1], 3)), along = dot(a[0], a[1], 3);
  return 0.5 * slope * (first + second) / std::sqrt(std::max(first * first * second * second - along * along, 0.0));
}

double NormalRotation::slope(const FacetElement& element)
{
  // At the nodes and the centre: elsewhere the derivatives of functions of degree 2 add up to less.
  double largest = 0.0, dphi[2 * FacetElement::max_nodes];
  for (int i = 0; i <= element.num_nodes(); ++i)
  {
    const auto xi = i < element.num_nodes() ? element.node(i) : element.centre();
    element.derivatives(xi.data(), dphi);
    for (int a = 0; a < element.tdim(); ++a)
    {
      double sum = 0.0;
      for (int k = 0; k < element.num_nodes(); ++k)
        sum += std::abs(dphi[a * element.num_nodes() + k]);
      largest = std::max(largest, sum);
    }
  }
  return largest;
}
} // namespace dolfinx_impact::search
