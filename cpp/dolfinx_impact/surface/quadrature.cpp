// SPDX-License-Identifier: MIT
#include "quadrature.h"
#include <basix/quadrature.h>

namespace dolfinx_impact::surface
{
QuadratureRule quadrature(FacetShape shape, int degree)
{
  using basix::cell::type;
  const type cell = shape == FacetShape::interval   ? type::interval
                    : shape == FacetShape::triangle ? type::triangle
                                                    : type::quadrilateral;
  auto [points, weights] = basix::quadrature::make_quadrature<double>(basix::quadrature::type::Default, cell,
                                                                      basix::polyset::type::standard, degree);
  return {std::move(points), std::move(weights)};
}
} // namespace dolfinx_impact::surface
