// SPDX-License-Identifier: MIT
// Resultants of nodal forces, and gaps that are adjusted.
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/gap/InitialPenetration.h>
#include <dolfinx_impact/gap/search_distance.h>
#include <dolfinx_impact/operators/resultant.h>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

namespace
{
std::shared_ptr<dolfinx::fem::FunctionSpace<double>> one_cell()
{
  const auto mesh = std::make_shared<dolfinx::mesh::Mesh<double>>(dolfinx::mesh::create_rectangle<double>(
      MPI_COMM_SELF, {{{0.0, 0.0}, {1.0, 1.0}}}, {1, 1}, dolfinx::mesh::CellType::quadrilateral));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  return std::make_shared<dolfinx::fem::FunctionSpace<double>>(
      dolfinx_impact::common::create_functionspace(mesh, element, {2}));
}

dolfinx_impact::surface::Facets one_segment(double height)
{
  dolfinx_impact::surface::Facets f;
  f.gdim = 2;
  f.displacement = f.geometry = {dolfinx_impact::surface::FacetShape::interval, 1};
  f.nodes = {0, 1};
  f.X = f.x = {0.0, height, 1.0, height};
  f.orientation = {1};
  f.id = {0};
  return f;
}
} // namespace

TEST_CASE("resultants are at deformed positions, and count each degree of freedom once")
{
  using dolfinx_impact::operators::resultant;
  const auto V = one_cell();
  const std::vector<double> x = V->tabulate_dof_coordinates(false);
  std::vector<double> u(8, 0.0), forces(8);
  double force[2] = {}, moment = 0.0;
  for (int node = 0; node < 4; ++node)
  {
    u[2 * node] = 0.5;
    forces[2 * node] = 1.0 + node;
    forces[2 * node + 1] = 2.0 - node;
    for (int c = 0; c < 2; ++c)
      force[c] += forces[2 * node + c];
    moment += (x[3 * node] + 0.5 - 1.0) * forces[2 * node + 1] - (x[3 * node + 1] - 2.0) * forces[2 * node];
  }
  const std::vector<std::int32_t> all{0, 1, 2, 3, 4, 5, 6, 7, 7, 0}, first{0};
  const auto found = resultant(*V, u, forces, all, {1.0, 2.0, 0.0});
  CHECK(found.force[0] == Catch::Approx(force[0]));
  CHECK(found.force[1] == Catch::Approx(force[1]));
  CHECK(found.force[2] == 0.0);
  CHECK(found.moment[2] == Catch::Approx(moment));
  CHECK(found.moment[0] == 0.0);
  CHECK(resultant(*V, u, forces, first, {}).force[0] == forces[0]);
  const std::vector<std::int32_t> unknown{8};
  CHECK_THROWS_AS(resultant(*V, u, forces, unknown, {}), std::invalid_argument);
  CHECK_THROWS_AS(resultant(*V, u, std::vector<double>(3), first, {}), std::invalid_argument);
}

TEST_CASE("initial gaps are adjusted by layers, clearances and limits")
{
  using dolfinx_impact::gap::GapAdjustment;
  using dolfinx_impact::gap::InitialPenetration;
  const auto V = one_cell();
  const auto slave = one_segment(0.0);
  const std::vector<double> x{0.0, 0.0, 0.5, 0.0, 1.0, 0.0};
  const std::vector<double> gaps{-0.01, 0.02, std::numeric_limits<double>::infinity()};
  const auto offsets = [&](const GapAdjustment& adjustment)
  { return InitialPenetration("pair", *V, slave, nullptr, x, gaps, adjustment).offset(); };
  const double inf = std::numeric_limits<double>::infinity();
  CHECK(offsets({}) == std::vector<double>{0.0, 0.0, 0.0});
  CHECK(GapAdjustment{.adjust = 0.0}.removes_penetration());
  CHECK(offsets({.adjust = 0.0}) == std::vector<double>{0.01, 0.0, 0.0});
  CHECK(offsets({.offset = 0.25}) == std::vector<double>{-0.25, -0.25, -0.25});
  CHECK(offsets({.clearance = 0.25}) == std::vector<double>{0.25 + 0.01, 0.25 - 0.02, 0.0});
  CHECK(offsets({.offset = 0.25, .clearance = 0.5, .adjust = -0.24}) == std::vector<double>{0.51, -0.25, -0.25});
  const InitialPenetration told("pair", *V, slave, nullptr, x, gaps, {.clearance = 0.25});
  CHECK(told.num_adjusted() == 2);
  CHECK(told.largest_adjustment() == Catch::Approx(0.26));
  CHECK(told.where_adjusted() == std::vector<double>{0.0, 0.0});
  CHECK(told.num_points() == 1);
  CHECK(gaps[2] == inf);
  const auto master = one_segment(1.0);
  using dolfinx_impact::gap::search_distance;
  CHECK(search_distance(MPI_COMM_SELF, slave, &master, 0.0, 0.0) == 0.0);
  CHECK(search_distance(MPI_COMM_SELF, slave, &master, 0.0, 0.5) == Catch::Approx(2.5));
  CHECK(search_distance(MPI_COMM_SELF, slave, &master, 0.75, 0.5) == 0.75);
  CHECK_THROWS_AS(search_distance(MPI_COMM_SELF, slave, &master, 0.5, 0.5), std::invalid_argument);
}
