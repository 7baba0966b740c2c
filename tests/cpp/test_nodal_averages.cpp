// SPDX-License-Identifier: MIT
// Averages at nodes of values at quadrature points.
#include <algorithm>
#include <basix/finite-element.h>
#include <basix/quadrature.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/operators/nodal_averages.h>
#include <memory>
#include <stdexcept>
#include <vector>

namespace
{
/// Unit square of n x n cells, and vectors on it.
std::shared_ptr<dolfinx::fem::FunctionSpace<double>> square(int n)
{
  const auto mesh = std::make_shared<dolfinx::mesh::Mesh<double>>(dolfinx::mesh::create_rectangle<double>(
      MPI_COMM_SELF, {{{0.0, 0.0}, {1.0, 1.0}}}, {n, n}, dolfinx::mesh::CellType::quadrilateral));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  return std::make_shared<dolfinx::fem::FunctionSpace<double>>(
      dolfinx_impact::common::create_functionspace(mesh, element, {2}));
}

const auto rule = basix::quadrature::make_quadrature<double>(
    basix::quadrature::type::Default, basix::cell::type::quadrilateral, basix::polyset::type::standard, 2);
} // namespace

TEST_CASE("a node has the mean of the cells around it", "[averages]")
{
  const auto V = square(2);
  const auto& [points, weights] = rule;
  std::vector<double> values;
  for (int cell = 0; cell < 4; ++cell)
    for (std::size_t p = 0; p < weights.size(); ++p)
    {
      values.push_back(cell); // the first component differs between cells
      values.push_back(5.0);
    }
  const std::vector<double> found = dolfinx_impact::operators::nodal_averages(*V, points, weights, values);
  REQUIRE(found.size() == 18);
  for (std::int32_t node = 0; node < 9; ++node)
  {
    double sum = 0.0;
    int count = 0;
    for (int cell = 0; cell < 4; ++cell)
      if (const auto dofs = V->dofmap()->cell_dofs(cell); std::ranges::find(dofs, node) != dofs.end())
      {
        sum += cell;
        ++count;
      }
    CHECK(found[2 * node] == Catch::Approx(sum / count).margin(1e-14)); // cells are of one size
    CHECK(found[2 * node + 1] == Catch::Approx(5.0).epsilon(1e-14));
  }
  values.pop_back();
  CHECK_THROWS_AS(dolfinx_impact::operators::nodal_averages(*V, points, weights, values), std::invalid_argument);
}
