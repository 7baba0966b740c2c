// SPDX-License-Identifier: MIT
// Penalty contact refuses what does not belong together, and goes back to the start of an increment.
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/enforcement/penalty/QuadraturePenalty.h>
#include <stdexcept>
#include <string>
#include <vector>

using namespace dolfinx_impact;
using namespace dolfinx_impact::enforcement;

namespace
{
/// One segment of the plane with one point above a plane.
struct OnePoint
{
  surface::Facets slave = segment(), master = segment();
  gap::Points points = gap::make_points(slave, std::vector{0.5}, std::vector{1.0}, false);
  PenaltyHistory history = make_history(points);
  std::vector<double> increment = std::vector<double>(4, 0.0);
  const gap::Rigid plane{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0, 1, 0}};

  static surface::Facets segment()
  {
    surface::Facets f;
    f.gdim = 2;
    f.displacement = f.geometry = {surface::FacetShape::interval, 1};
    f.nodes = {0, 1};
    f.X = f.x = {0.0, -0.1, 1.0, -0.1};
    f.orientation = {1};
    f.id = {0};
    return f;
  }

  /// What `evaluate` says about it.
  std::string error(const surface::Facets& own, const surface::Facets* other, PenaltyParameters parameters) const
  {
    try
    {
      evaluate(PenaltyPair{points, own, other, parameters, history, increment});
    }
    catch (const std::invalid_argument& e)
    {
      return e.what();
    }
    return "";
  }
};
} // namespace

TEST_CASE("a pair is of one slave and one master")
{
  OnePoint one;
  CHECK(one.error(one.slave, nullptr, {1.0}) == "these points were not updated for a rigid master");
  gap::update(one.points, one.slave, one.plane);
  CHECK(one.error(one.slave, nullptr, {1.0}).empty());
  const PenaltyState state = evaluate(PenaltyPair{one.points, one.slave, nullptr, {2.0}, one.history, {}});
  CHECK(state.pressure[0] == 2.0 * 0.1);
  CHECK(one.error(one.slave, nullptr, {0.0}) == "a penalty is positive, a friction coefficient not negative");
  CHECK(one.error(one.slave, nullptr, {1.0, 0.0, 0.3}) == "friction needs a positive tangential penalty");
  one.increment.clear();
  CHECK(one.error(one.slave, nullptr, {1.0, 1.0, 0.3}) == "friction needs the increments of displacement of all nodes");
  surface::Facets two = one.slave;
  two.orientation = {1, 1};
  CHECK(one.error(two, nullptr, {1.0}) == "the points belong to another slave");
  // A point that was found on a facet which the master does not have.
  one.points.master = {5};
  CHECK(one.error(one.slave, &one.master, {1.0}) == "these points were updated for another master");
  surface::Facets space = one.master;
  space.gdim = 3;
  one.points.master = {0};
  CHECK(one.error(one.slave, &space, {1.0}) == "these points were updated for another master");
  one.history.multiplier.clear();
  CHECK(one.error(one.slave, nullptr, {1.0}) == "the history belongs to other points");
}

namespace
{
/// A square of one cell whose bottom may touch a rigid plane at its height, with friction.
struct SquareOnPlane
{
  std::shared_ptr<dolfinx::mesh::Mesh<double>> mesh =
      std::make_shared<dolfinx::mesh::Mesh<double>>(dolfinx::mesh::create_rectangle<double>(
          MPI_COMM_SELF, {{{0.0, 0.0}, {1.0, 1.0}}}, {1, 1}, dolfinx::mesh::CellType::quadrilateral));
  std::shared_ptr<const surface::FunctionSpace> V =
      std::make_shared<surface::FunctionSpace>(dolfinx_impact::common::create_functionspace(
          mesh,
          basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                        basix::element::lagrange_variant::gll_warped,
                                        basix::element::dpc_variant::unset, false),
          {2}));

  surface::Facets bottom() const
  {
    const auto facets = dolfinx::mesh::locate_entities_boundary(*mesh, 1,
                                                                [](auto x)
                                                                {
                                                                  std::vector<std::int8_t> on;
                                                                  for (std::size_t p = 0; p < x.extent(1); ++p)
                                                                    on.push_back(std::abs(x(1, p)) < 1e-12);
                                                                  return on;
                                                                });
    return surface::make_surface(*V, facets);
  }

  static gap::Rigid plane(double up)
  {
    return {.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0.0, up, 0.0}};
  }

  /// Displacements of the square as a whole.
  std::vector<double> moved(double x, double y) const
  {
    std::vector<double> u(8);
    for (std::size_t i = 0; i < u.size(); ++i)
      u[i] = i % 2 ? y : x;
    return u;
  }
};
} // namespace

TEST_CASE("an increment of penalty contact is accepted, or given up by its state")
{
  const SquareOnPlane square;
  QuadraturePenalty contact("square", square.V, square.bottom(), square.plane(1.0),
                            {.penalty = 100.0, .friction = 0.5});
  const std::array<double, 3> rest{};
  contact.begin_step(square.moved(0.0, 0.0), rest);
  contact.update_gap(square.moved(0.0, -0.01));
  contact.accept_step();
  CHECK(contact.totals().force[1] == Catch::Approx(1.0));
  CHECK(contact.smallest_gap() == Catch::Approx(-0.01));
  // Dragged farther than friction bears: half of the normal force holds it.
  const state::State start = contact.state().copy();
  contact.begin_step(square.moved(0.0, -0.01), rest);
  contact.update_gap(square.moved(0.1, -0.01));
  CHECK_FALSE(contact.symmetric());
  contact.accept_step();
  CHECK(contact.totals().force[0] == Catch::Approx(-0.5));
  CHECK_FALSE(contact.state().difference_of_values(start).empty());
  contact.state().assign(start);
  CHECK(contact.state().difference_of_values(start).empty());
  CHECK(contact.state().field("slip").columns == 2 * std::size_t(contact.forces().points().per_facet));
}

TEST_CASE("an obstacle that does not face the slave is refused")
{
  const SquareOnPlane square;
  CHECK_THROWS_AS(QuadraturePenalty("square", square.V, square.bottom(), square.plane(-1.0), {.penalty = 100.0}),
                  std::invalid_argument);
  CHECK_THROWS_AS(QuadraturePenalty("square", square.V, square.bottom(), square.plane(1.0), {.penalty = -1.0}),
                  std::invalid_argument);
}
