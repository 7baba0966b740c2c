// SPDX-License-Identifier: MIT
// Increments of load: which there are, what is halved, and what a solve that fails leaves. The bodies are not asked.
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/common/dolfinx_api.h>
#include <dolfinx_impact/solve/FunctionBody.h>
#include <dolfinx_impact/solve/LoadSteps.h>
#include <memory>
#include <stdexcept>

using Catch::Approx;
using namespace dolfinx_impact;

namespace
{
/// One interval, its two ends prescribed, and a load of two numbers that goes from (1, 0) to (3, 8).
struct Stretched
{
  std::shared_ptr<solve::EquilibriumProblem> problem = std::make_shared<solve::EquilibriumProblem>();
  std::vector<double> load{3.0, 8.0}, reached{1.0, 0.0}, target{0.0, 4.0};
  std::vector<double> seen; ///< of the load's second number, at each increment
  int accepted = 0;

  Stretched()
  {
    const auto mesh = std::make_shared<dolfinx::mesh::Mesh<double>>(
        dolfinx::mesh::create_interval<double>(MPI_COMM_SELF, 1, {0.0, 1.0}));
    const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::interval, 1,
                                                       basix::element::lagrange_variant::gll_warped,
                                                       basix::element::dpc_variant::unset, false);
    const auto V = std::make_shared<dolfinx::fem::FunctionSpace<double>>(
        dolfinx_impact::common::create_functionspace(mesh, element, std::vector<std::size_t>{}));
    problem->u = std::make_shared<dolfinx::fem::Function<double>>(V);
    solve::FunctionBody::Functions functions;
    functions.accept_step = [this] { ++accepted; };
    problem->body = std::make_shared<solve::FunctionBody>(functions, solve::BodyProperties{});
  }

  /// A solver that takes prescribed values over, and fails where a step is longer than it bears.
  solve::LoadStepReport run(double bears, solve::LoadStepOptions options)
  {
    solve::LoadSteps steps(problem, target, {{load, reached}}, {});
    const auto solver = [&](std::span<const double> prescribed)
    {
      std::span<double> u = dolfinx_impact::common::array(*problem->u->x());
      solve::Increment out;
      out.iterations = 2;
      seen.push_back(load[1]);
      const bool far = prescribed[1] - u[1] > bears;
      std::ranges::copy(prescribed, u.begin()); // also where it fails: it must be taken back
      return far ? out.failed("the step is too long") : out.converged();
    };
    return steps.run(solver, options);
  }
};
} // namespace

TEST_CASE("equal increments end exactly at the loads")
{
  Stretched model;
  const solve::LoadStepReport report = model.run(10.0, {.steps = 4});
  CHECK(report.fractions == std::vector<double>{0.25, 0.5, 0.75, 1.0});
  CHECK(report.iterations == std::vector<int>{2, 2, 2, 2});
  CHECK(report.cut_backs == 0);
  CHECK(model.accepted == 4);
  CHECK(model.seen == std::vector<double>{2.0, 4.0, 6.0, 8.0});
  CHECK(model.problem->u->x()->array()[1] == 4.0);
  CHECK(model.reached == model.load); // the next solve begins there
}

TEST_CASE("increments that do not converge are halved, and stay so")
{
  Stretched model;
  const solve::LoadStepReport report = model.run(1.1, {.steps = 1, .cut_backs = 3}); // of a way of 4
  CHECK(report.cut_backs == 2);
  CHECK(report.fractions == std::vector<double>{0.25, 0.5, 0.75, 1.0});
  CHECK(report.rejected_iterations == std::vector<int>{2, 2});
  CHECK(model.accepted == 4);
  CHECK(model.seen == std::vector<double>{8.0, 4.0, 2.0, 4.0, 6.0, 8.0});
}

TEST_CASE("a solve that fails leaves the last increment that converged, and the user's loads")
{
  Stretched model;
  std::string said;
  try
  {
    model.run(0.7, {.steps = 2, .cut_backs = 1}); // increments of 2, then of 1
  }
  catch (const std::runtime_error& error)
  {
    said = error.what();
  }
  CHECK(said.starts_with("the step is too long"));
  CHECK(model.accepted == 0);
  CHECK(model.problem->u->x()->array()[1] == 0.0);
  CHECK(model.load == std::vector<double>{3.0, 8.0});
  CHECK(model.reached == std::vector<double>{1.0, 0.0});
}

TEST_CASE("the solver's exceptions pass through, and the problem is where the last increment left it")
{
  Stretched model;
  solve::LoadSteps steps(model.problem, model.target, {{model.load, model.reached}}, {});
  int calls = 0;
  const auto solver = [&](std::span<const double> prescribed) -> solve::Increment
  {
    std::ranges::copy(prescribed, dolfinx_impact::common::array(*model.problem->u->x()).begin());
    if (++calls == 3)
      throw std::domain_error("stop");
    return solve::Increment().converged();
  };
  CHECK_THROWS_AS(steps.run(solver, {.steps = 4}), std::domain_error);
  CHECK(model.problem->u->x()->array()[1] == Approx(2.0));
  CHECK(model.reached[1] == Approx(4.0));
  CHECK(model.load[1] == 8.0);
  CHECK_THROWS_AS(solve::LoadSteps(model.problem, {0.0}, {}, {}), std::invalid_argument);
}
