// SPDX-License-Identifier: MIT
// A contact by multipliers as one object: its state as a tree, an increment, what it shares with others, what it
// refuses.
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/enforcement/mortar/MortarContact.h>
#include <dolfinx_impact/enforcement/mortar/shared_nodes.h>
#include <dolfinx_impact/surface/Surface.h>
#include <memory>
#include <numeric>
#include <stdexcept>

using namespace dolfinx_impact;
using namespace dolfinx_impact::enforcement;

namespace
{
/// A square of two by one cells whose lower side is the slave, on a rigid half-space up to y = 0.
struct SquareOnPlane
{
  std::shared_ptr<surface::FunctionSpace> V;
  std::shared_ptr<const gap::Rigid> plane = std::make_shared<gap::Rigid>(
      gap::Rigid{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0.0, 1.0, 0.0}});
  surface::Facets slave;
  std::vector<double> u;

  SquareOnPlane()
  {
    const auto mesh = std::make_shared<dolfinx::mesh::Mesh<double>>(dolfinx::mesh::create_rectangle<double>(
        MPI_COMM_SELF, {{{0.0, 0.0}, {1.0, 1.0}}}, {2, 1}, dolfinx::mesh::CellType::quadrilateral));
    const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                       basix::element::lagrange_variant::gll_warped,
                                                       basix::element::dpc_variant::unset, false);
    V = std::make_shared<surface::FunctionSpace>(dolfinx_impact::common::create_functionspace(mesh, element, {2}));
    const auto below = [](auto x)
    {
      std::vector<std::int8_t> on;
      for (std::size_t p = 0; p < x.extent(1); ++p)
        on.push_back(std::abs(x(1, p)) < 1e-12);
      return on;
    };
    slave = surface::make_surface(*V, dolfinx::mesh::locate_entities_boundary(*mesh, 1, below));
    u.assign(12, 0.0);
  }

  MortarContact contact(MortarOptions options = {}) const
  {
    return MortarContact(V, slave, plane, std::move(options), std::vector<std::int8_t>(u.size(), 0));
  }

  /// All nodes moved up.
  std::vector<double> lifted(double by) const
  {
    std::vector<double> out(u);
    for (std::size_t k = 1; k < out.size(); k += 2)
      out[k] += by;
    return out;
  }
};
} // namespace

TEST_CASE("an increment of a contact closes, takes its multipliers from equilibrium, and goes back")
{
  const SquareOnPlane square;
  MortarContact c = square.contact({.name = "floor"});
  REQUIRE(c.nodes().size() == 3);
  CHECK(c.name() == "floor");
  c.begin_step(square.lifted(0.25), {});
  const state::State before = c.state().copy();
  c.update_gap(square.lifted(-0.125));
  CHECK(c.smallest_gap() == Catch::Approx(-0.125).epsilon(1e-14));
  CHECK(c.update_active_set(true) == 3);
  // Each node is pressed by a force of 0.5: over its area, a half or a quarter of the side.
  std::vector<double> residual(square.u.size(), 0.0);
  for (std::int32_t node : c.nodes())
    residual[2 * node + 1] = 0.5;
  c.update_multipliers(residual);
  const std::vector<double> weight = c.weight(), pressure = c.pressure(), forces = c.contact_forces();
  CHECK(std::accumulate(weight.begin(), weight.end(), 0.0) == Catch::Approx(1.0).epsilon(1e-14));
  for (std::size_t i = 0; i < weight.size(); ++i)
    CHECK(pressure[i] == Catch::Approx(0.5 / weight[i]).epsilon(1e-14));
  for (std::size_t k = 0; k < forces.size(); ++k)
    CHECK(forces[k] == Catch::Approx(residual[k]).epsilon(1e-14));
  CHECK(c.num_active() == 3);
  CHECK(c.constraints().size() == 3);
  c.accept_step();
  CHECK(c.totals().force[1] == Catch::Approx(1.5).epsilon(1e-14));
  CHECK(c.totals().area == Catch::Approx(1.0).epsilon(1e-14));
  CHECK(c.state().difference_of_structure(before).empty());
  CHECK(c.state().difference_of_values(before).find("active") != std::string::npos);
  c.state().assign(before);
  CHECK(c.num_active() == 0);
  CHECK(c.state().difference_of_values(before).empty());
}

TEST_CASE("a unit force presses one node, a unit gap opens it")
{
  const SquareOnPlane square;
  MortarContact c = square.contact();
  c.update_gap(square.u);
  const std::int64_t number = c.numbers()[1];
  const std::size_t dof = 2 * c.nodes()[1] + 1;
  std::vector<double> force = c.unit_force(number), gap = c.unit_gap(number);
  CHECK(force[dof] == c.weight()[1]);
  CHECK(gap[dof] == 1.0);
  force[dof] = gap[dof] = 0.0;
  CHECK(force == std::vector<double>(square.u.size(), 0.0));
  CHECK(gap == force);
  CHECK(c.linearised_response(square.lifted(0.5), square.lifted(0.0)).first == std::vector<double>(3, 0.5));
}

TEST_CASE("nodes that would overlap by more than a part of the largest overlap are predicted to close")
{
  const SquareOnPlane square;
  MortarContact c = square.contact();
  c.begin_step(square.u, {});
  c.update_gap(square.u);
  // The three nodes move down by 0.1, 0.2 and 0.3.
  std::vector<double> increments(square.u.size(), 0.0);
  for (std::size_t i = 0; i < 3; ++i)
    increments[2 * c.nodes()[i] + 1] = -0.1 * double(i + 1);
  const auto active = [&] { return std::vector<std::int8_t>(c.active().begin(), c.active().end()); };
  c.predict_active_set(square.lifted(0.1), 0.5); // apart
  CHECK(active() == std::vector<std::int8_t>{0, 0, 0});
  c.predict_active_set(increments, 0.9);
  CHECK(active() == std::vector<std::int8_t>{0, 0, 1});
  c.predict_active_set(increments, 0.5);
  CHECK(active() == std::vector<std::int8_t>{0, 1, 1});
  c.predict_active_set(increments, 0.9); // what is in contact stays so
  CHECK(active() == std::vector<std::int8_t>{0, 1, 1});
  MortarContact rough = square.contact({.friction = 0.3});
  rough.begin_step(square.u, {});
  rough.update_gap(square.u);
  rough.predict_active_set(increments, 0.5);
  CHECK(rough.num_active() == 0);
}

TEST_CASE("contacts with common nodes keep their multipliers, or are refused")
{
  SquareOnPlane square;
  MortarContact one = square.contact({.name = "one"}), two = square.contact({.name = "two"});
  const std::vector<MortarContact*> both{&one, &two};
  try
  {
    connect(both);
    FAIL("the same facets against the same obstacle");
  }
  catch (const std::invalid_argument& e)
  {
    CHECK(std::string(e.what()) == "one and two pair the same 2 slave facets with the same master twice, the first at "
                                   "[[0.25, 0.0], [0.75, 0.0]]: leave them out of one of the pairs");
  }
  square.plane = std::make_shared<gap::Rigid>(*square.plane); // another obstacle at the same place
  MortarContact other = square.contact({.name = "other"}), alone = square.contact({.may_share_nodes = false});
  CHECK(connect(std::vector{&one, &other}));
  CHECK(one.edges.size() == 1);
  CHECK(other.edges.at(0).mine.size() == 3);
  CHECK_FALSE(connect(std::vector{&one}));
  CHECK_THROWS_AS(connect(std::vector{&two, &alone}), std::invalid_argument);
}

TEST_CASE("a contact refuses what does not fit")
{
  SquareOnPlane square;
  CHECK_THROWS_AS(square.contact({.basis = gap::Multipliers::standard}), std::invalid_argument);
  CHECK_THROWS_AS(MortarContact(square.V, square.slave, square.plane, {}, {}), std::invalid_argument);
  MortarContact c = square.contact();
  CHECK_THROWS_AS(c.begin_step(std::vector<double>(3), {}), std::invalid_argument);
  CHECK_THROWS_AS(c.update_multipliers(std::vector<double>(3)), std::invalid_argument);
  CHECK_THROWS_AS(c.set_linearised(std::vector<std::int8_t>(3), c.gap(), {}), std::invalid_argument);
  square.plane =
      std::make_shared<gap::Rigid>(gap::Rigid{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0, -1, 0}});
  CHECK_THROWS_AS(square.contact(), std::invalid_argument); // the slave is on its wrong side
}
