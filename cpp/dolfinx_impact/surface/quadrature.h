// SPDX-License-Identifier: MIT
#pragma once
#include "FacetElement.h"
#include <vector>

namespace dolfinx_impact::surface
{
/// Points and weights on a reference facet.
struct QuadratureRule
{
  std::vector<double> points, weights; ///< points[i*tdim + alpha]
};

/// Basix's rule that is exact for polynomials of a degree.
QuadratureRule quadrature(FacetShape shape, int degree);
} // namespace dolfinx_impact::surface
