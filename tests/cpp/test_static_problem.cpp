// SPDX-License-Identifier: MIT
// A static problem in C++: a stretched block of two laws, a load in parts, and a state that is gone back to.
#include <algorithm>
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/OnAllRanks.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/common/dolfinx_api.h>
#include <dolfinx_impact/enforcement/penalty/QuadraturePenalty.h>
#include <dolfinx_impact/problems/KernelBody.h>
#include <dolfinx_impact/problems/static_state.h>
#include <dolfinx_impact/surface/Surface.h>
#include <stdexcept>
#include <utility>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
constexpr double E = 1000.0, height = 2.0;

/// A block of the plane whose lower end stands on a plane by penalty, its sides free; the upper end is moved.
struct Block
{
  std::shared_ptr<fem::FunctionSpace<double>> V;
  std::shared_ptr<fem::Function<double>> u, top;
  std::shared_ptr<problems::KernelBody> body;
  std::shared_ptr<enforcement::QuadraturePenalty> contact;
  std::shared_ptr<problems::StaticProblem> problem;

  static auto at(double y)
  {
    return [y](auto x)
    {
      std::vector<std::int8_t> marked(x.extent(1));
      for (std::size_t p = 0; p < marked.size(); ++p)
        marked[p] = std::abs(x(1, p) - y) < 1e-9;
      return marked;
    };
  }

  explicit Block(const std::string& law, const solve::LinearSolver::Options& petsc = {})
  {
    auto mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_rectangle<double>(
        MPI_COMM_SELF, {{{0.0, 0.0}, {1.0, height}}}, {2, 3}, mesh::CellType::quadrilateral));
    const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                       basix::element::lagrange_variant::gll_warped,
                                                       basix::element::dpc_variant::unset, false);
    V = std::make_shared<fem::FunctionSpace<double>>(dolfinx_impact::common::create_functionspace(mesh, element, {2}));
    u = std::make_shared<fem::Function<double>>(V);
    top = std::make_shared<fem::Function<double>>(V);
    problems::BoundaryConditions bcs{
        std::make_shared<fem::DirichletBC<double>>(top, fem::locate_dofs_geometrical(*V, at(height)))};
    body = std::make_shared<problems::KernelBody>(
        u, problems::KernelMaterial{law, {{"E", {E}}, {"nu", {0.0}}}, "plane_strain"});
    const auto facets = mesh::locate_entities_boundary(*mesh, 1, at(0.0));
    const gap::Rigid plane{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0, 1, 0}};
    contact = std::make_shared<enforcement::QuadraturePenalty>("floor", V, surface::make_surface(*V, facets), plane,
                                                               enforcement::PenaltyOptions{.penalty = 1e4});
    problem = std::make_shared<problems::StaticProblem>(
        u, body, bcs, std::vector<std::shared_ptr<enforcement::StaticContact>>{contact},
        problems::SolverOptions{.petsc = petsc});
  }

  void press(double by)
  {
    std::span<double> moved = dolfinx_impact::common::array(*top->x());
    for (std::size_t i = 0; i < moved.size(); ++i)
      moved[i] = i % 2 ? -by : 0.0;
  }
};
} // namespace

TEST_CASE("a pressed block has the force of two springs in series")
{
  Block block("linear_elastic");
  CHECK(block.body->properties().linear);
  block.press(0.01);
  const auto report = block.problem->solve({.steps = 2});
  CHECK(report.fractions == std::vector{0.5, 1.0});
  CHECK(block.contact->totals().force[1] == Catch::Approx(0.01 / (height / E + 1e-4)).epsilon(1e-9));
}

TEST_CASE("a problem goes back to a copied state, and on from there to the same end")
{
  Block block("neo_hookean");
  CHECK_FALSE(block.body->properties().linear);
  block.press(0.01);
  block.problem->solve();
  const state::State half = block.problem->state().copy();
  block.press(0.03);
  block.problem->solve();
  const state::State end = block.problem->state().copy();
  CHECK_FALSE(end.difference_of_values(half).empty());
  block.problem->state().assign(half);
  CHECK(block.problem->state().difference_of_values(half).empty());
  block.problem->solve();
  const auto one = std::get<std::span<double>>(end.field("displacement").values);
  const std::span<const double> other = dolfinx_impact::common::array(*block.u->x());
  double difference = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i)
    difference = std::max(difference, std::abs(one[i] - other[i]));
  CHECK(difference < 1e-9 * 0.03); // Newton's tolerance is 1e-10 of the force
}

TEST_CASE("methods of PETSc's find the same equilibrium, and are told of by the same events")
{
  const std::string method = GENERATE("shell", "python", "newtonls", "newtontr"); // the first two are our own
  Block right("neo_hookean"), block("neo_hookean", {{"snes_type", method}});
  for (Block* one : {&right, &block})
    one->press(0.05);
  right.problem->solve();
  int iterations = 0, lines = 0, accepted = 0;
  problems::SolveEvents events;
  events.newton.iteration = [&](int, double norm, double, std::int64_t, std::int64_t) { iterations += norm >= 0.0; };
  events.steps.log = [&](const std::string&) { ++lines; };
  events.steps.accepted = [&](double) { ++accepted; };
  const auto report = block.problem->solve({.steps = 2, .rtol = 1e-11}, events);
  CHECK(accepted == 2);
  CHECK(lines >= 2);
  CHECK(std::size_t(iterations) == report.residual_norms[0].size() + report.residual_norms[1].size());
  CHECK(block.contact->totals().force[1] == Catch::Approx(right.contact->totals().force[1]).epsilon(1e-8));
  // Forces of the support balance that of the contact.
  const std::vector<double> reactions = block.problem->reactions();
  double sum = 0.0;
  for (std::size_t i = 1; i < reactions.size(); i += 2)
    sum += reactions[i];
  CHECK(-sum == Catch::Approx(block.contact->totals().force[1]).epsilon(1e-8));
}

TEST_CASE("options of SNES that PETSc does not take are refused")
{
  Block block("linear_elastic", {{"snes_type", "none such"}});
  block.press(0.01);
  CHECK_THROWS_AS(block.problem->solve(), std::invalid_argument);
}

TEST_CASE("what an event throws leaves the last converged state, from which the next solve goes on")
{
  Block right("neo_hookean"), block("neo_hookean");
  for (Block* one : {&right, &block})
    one->press(0.05);
  right.problem->solve({.steps = 2});
  problems::SolveEvents events;
  events.newton.iteration = [&, first = true](int iteration, double, double, std::int64_t, std::int64_t) mutable
  {
    if (iteration == 0 && !std::exchange(first, false))
      throw std::domain_error("enough"); // in the second increment
  };
  CHECK_THROWS_AS(block.problem->solve({.steps = 2}, events), std::domain_error);
  const double half = block.contact->totals().force[1], whole = right.contact->totals().force[1];
  CHECK(half > 0.4 * whole);
  CHECK(half < 0.6 * whole);
  block.problem->solve();
  CHECK(block.contact->totals().force[1] == Catch::Approx(whole).epsilon(1e-8));
}

TEST_CASE("an event may not solve the problem that tells it")
{
  Block block("linear_elastic");
  block.press(0.01);
  problems::SolveEvents events;
  events.steps.accepted = [&](double) { block.problem->solve(); };
  CHECK_THROWS_AS(block.problem->solve({}, events), dolfinx_impact::common::Failure);
  block.problem->solve(); // and afterwards it can be solved
  CHECK(block.contact->totals().force[1] == Catch::Approx(0.01 / (height / E + 1e-4)).epsilon(1e-9));
}

TEST_CASE("whether multipliers are condensed is true or false")
{
  CHECK_THROWS_AS(Block("linear_elastic", {{"contact_condense", "maybe"}}), std::invalid_argument);
  CHECK_NOTHROW(Block("linear_elastic", {{"contact_condense", ""}}));
}

TEST_CASE("increments may be solved by a function of one's own")
{
  Block block("linear_elastic");
  block.press(0.01);
  solve::IncrementSolver own(block.problem->equilibrium(), {});
  int calls = 0;
  const auto report = block.problem->solve(
      [&](std::span<const double> goal)
      {
        solve::Increment found = own.run(goal);
        return ++calls == 1 ? found.failed("made to fail") : found;
      });
  CHECK(report.cut_backs == 1);
  CHECK(report.fractions == std::vector{0.5, 1.0});
  CHECK(block.contact->totals().force[1] == Catch::Approx(0.01 / (height / E + 1e-4)).epsilon(1e-9));
}

TEST_CASE("another problem goes on from what one has saved")
{
  Block block("neo_hookean"), again("neo_hookean");
  block.press(0.01);
  block.problem->solve();
  const state::State kept = problems::saved_state(*block.problem);
  problems::resume(*again.problem, kept);
  CHECK(problems::saved_state(*again.problem).difference_of_values(kept).empty());
  for (Block* one : {&block, &again})
  {
    one->problem->forget();
    one->press(0.03);
    one->problem->solve();
  }
  CHECK(again.problem->state().difference_of_values(block.problem->state()).empty());
}

TEST_CASE("a static problem refuses what it has not")
{
  Block block("linear_elastic");
  block.problem->move_obstacle(0, {0.0, 1e-3, 0.0});
  CHECK_THROWS_AS(block.problem->move_obstacle(1, {}), std::out_of_range);
  CHECK_THROWS_AS(Block("no_such_law"), std::runtime_error);
  CHECK_THROWS_AS(block.problem->solve({.steps = 0}), std::invalid_argument);
  CHECK_THROWS_AS(block.problem->solve({.rtol = -1.0}), std::invalid_argument);
}
