// SPDX-License-Identifier: MIT
// Implicit steps: motions with closed forms, energy that the trapezoidal rule keeps, contact, a state that is gone back
// to, and what is refused.
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
#include <dolfinx_impact/enforcement/mortar/MortarContact.h>
#include <dolfinx_impact/integrators/newmark/MovingBody.h>
#include <dolfinx_impact/problems/LoadedBody.h>
#include <dolfinx_impact/problems/implicit_state.h>
#include <dolfinx_impact/solve/FunctionBody.h>
#include <dolfinx_impact/surface/Surface.h>
#include <stdexcept>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
constexpr double young = 100.0, density = 2.0, width = 2.0, height = 1.0;

/// A block in plane strain, its lower side at y = 0.
struct Block
{
  std::shared_ptr<mesh::Mesh<double>> mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_rectangle<double>(
      MPI_COMM_SELF, {{{0.0, 0.0}, {width, height}}}, {4, 3}, mesh::CellType::quadrilateral));
  std::shared_ptr<fem::FunctionSpace<double>> V;
  std::shared_ptr<fem::Function<double>> u, v;

  Block()
  {
    const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                       basix::element::lagrange_variant::gll_warped,
                                                       basix::element::dpc_variant::unset, false);
    V = std::make_shared<fem::FunctionSpace<double>>(dolfinx_impact::common::create_functionspace(mesh, element, {2}));
    u = std::make_shared<fem::Function<double>>(V);
    v = std::make_shared<fem::Function<double>>(V);
  }

  problems::ImplicitBody body(const problems::ImplicitBodyOptions& options = {},
                              const std::vector<problems::PrescribedMotion>& supports = {}) const
  {
    const problems::KernelMaterial law{"linear_elastic", {{"E", {young}}, {"nu", {0.3}}}, "plane_strain"};
    return problems::implicit_body(u, v, {{law, density}}, problems::prescribed_dofs(*V, supports), options);
  }

  std::vector<std::int32_t> lower() const
  {
    return mesh::locate_entities_boundary(*mesh, 1,
                                          [](auto x)
                                          {
                                            std::vector<std::int8_t> marked(x.extent(1));
                                            for (std::size_t p = 0; p < marked.size(); ++p)
                                              marked[p] = std::abs(x(1, p)) < 1e-9;
                                            return marked;
                                          });
  }

  /// The same velocity everywhere.
  void move(double vx, double vy)
  {
    for (std::size_t i = 0; i < v->x()->array().size(); i += 2)
    {
      dolfinx_impact::common::array(*v->x())[i] = vx;
      dolfinx_impact::common::array(*v->x())[i + 1] = vy;
    }
  }
};

const auto mass_options = []
{
  problems::ImplicitBodyOptions lumped, damped;
  lumped.lumping = problems::Lumping::automatic;
  damped.beta = 1e-3;
  return std::vector{problems::ImplicitBodyOptions{}, lumped, damped};
}();
} // namespace

TEST_CASE("what is known of bodies is known of them with loads, and with inertia and damping but for these",
          "[newmark]")
{
  const bool keeps = GENERATE(false, true), symmetric = GENERATE(false, true);
  const int damping = GENERATE(0, 1, 2); // none, linear, another one
  const solve::BodyProperties given{.linear = true,
                                    .keeps_tangent = keeps,
                                    .symmetric = symmetric,
                                    .inelastic = true,
                                    .has_springs = true,
                                    .rounds_positions = true};
  const Block b;
  const auto body = std::make_shared<solve::FunctionBody>(solve::FunctionBody::Functions{}, given);
  const auto loaded = std::make_shared<problems::LoadedBody>(body, b.u->x()->array().size());
  CHECK(loaded->properties().linear);
  CHECK(loaded->properties().keeps_tangent == keeps);
  CHECK(loaded->properties().symmetric == symmetric);
  CHECK(loaded->properties().inelastic);
  CHECK_FALSE(loaded->properties().has_inertia);
  CHECK(loaded->properties().has_springs);
  CHECK(loaded->properties().rounds_positions);

  std::shared_ptr<integrators::VelocityForce> force;
  if (damping > 0)
    force = std::make_shared<integrators::FunctionVelocityForce>(nullptr, nullptr, damping == 1);
  const integrators::MovingBody moving(loaded, b.u, b.v, b.body().inertia, 0.0, force);
  // The mass matrix is added to tangents of one size of steps, where they are the same in all of them.
  CHECK(moving.properties().linear == (keeps && damping < 2));
  CHECK(moving.properties().keeps_tangent == moving.properties().linear);
  CHECK(moving.properties().symmetric == (symmetric && damping == 0));
  CHECK(moving.properties().inelastic);
  CHECK(moving.properties().has_inertia);
  CHECK(moving.properties().has_springs);
  CHECK(moving.properties().rounds_positions);
}

TEST_CASE("a free block under its weight falls as a point does", "[newmark]")
{
  const auto& options = mass_options[GENERATE(0, 1, 2)];
  Block b;
  problems::ImplicitBody body = b.body(options);
  problems::LoadInTime weight;
  for (std::size_t i = 1; i < body.mass.size(); i += 2)
  {
    weight.dofs.push_back(std::int32_t(i));
    weight.values.push_back(-9.81 * body.mass[i]);
  }
  if (!options.lumping) // lumped masses are no nodal forces of the consistent mass: the block would deform
  {
    std::vector<double> ones(body.mass.size(), 0.0);
    for (std::size_t i = 1; i < ones.size(); i += 2)
      ones[i] = 1.0;
    const std::vector<double> forces = body.inertia->times(ones);
    for (std::size_t k = 0; k < weight.dofs.size(); ++k)
      weight.values[k] = -9.81 * forces[weight.dofs[k]];
  }
  b.move(0.5, 0.0);
  problems::NewmarkProblem problem(b.u, b.v, body, {}, {weight});
  problem.advance(0.4, {.dt = 0.1});
  for (std::size_t i = 0; i < b.u->x()->array().size(); i += 2)
  {
    CHECK(b.u->x()->array()[i] == Catch::Approx(0.2).epsilon(1e-9));
    CHECK(b.u->x()->array()[i + 1] == Catch::Approx(-0.5 * 9.81 * 0.16).epsilon(1e-9));
    CHECK(b.v->x()->array()[i + 1] == Catch::Approx(-9.81 * 0.4).epsilon(1e-9));
  }
  const double mass = density * width * height;
  CHECK(problem.energies().kinetic == Catch::Approx(0.5 * mass * (0.25 + 9.81 * 9.81 * 0.16)).epsilon(1e-9));
  CHECK(problem.energies().external == Catch::Approx(mass * 9.81 * 0.5 * 9.81 * 0.16).epsilon(1e-9));
  CHECK(problem.step() == 4);
  CHECK(problem.history().num_rows() == 5);
}

TEST_CASE("the trapezoidal rule keeps the energy of a linear body, and damping takes from it", "[newmark]")
{
  const int which = GENERATE(0, 1, 2);
  Block b;
  for (std::size_t i = 0; i < b.u->x()->array().size(); i += 2)
    dolfinx_impact::common::array(*b.u->x())[i] = 0.01 * std::sin(0.3 * double(i));
  problems::NewmarkProblem problem(b.u, b.v, b.body(mass_options[which]));
  const double start = problem.energies().internal;
  problem.advance(2.0, {.dt = 0.05});
  const integrators::Energies e = problem.energies();
  CHECK(start > 0.0);
  CHECK(e.kinetic + e.internal + e.damping == Catch::Approx(start).epsilon(which == 2 ? 0.2 : 1e-9));
  CHECK((e.damping > 0.01 * start) == (which == 2));
}

TEST_CASE("a support follows its function of time, whose motion is that of the body", "[newmark]")
{
  Block b;
  const auto dofs = fem::locate_dofs_topological(*b.mesh->topology_mutable(), *b.V->dofmap(), 1, b.lower());
  const auto unit = std::make_shared<fem::DirichletBC<double>>(
      std::make_shared<fem::Constant<double>>(std::vector{1.0, 0.0}, std::vector<std::size_t>{2}), dofs, b.V);
  const std::vector<problems::PrescribedMotion> supports{
      {unit, problems::FunctionOfTime([](double t) { return 0.1 * t; })}};
  b.move(0.1, 0.0);
  problems::NewmarkProblem problem(b.u, b.v, b.body({}, supports), supports);
  problem.advance(0.5, {.dt = 0.1});
  for (std::size_t i = 0; i < b.u->x()->array().size(); i += 2)
    CHECK(b.u->x()->array()[i] == Catch::Approx(0.05).epsilon(1e-9));
}

TEST_CASE("a block meets a rigid plane: it stays above it, and the state before is gone back to", "[newmark]")
{
  Block b;
  problems::ImplicitBodyOptions options;
  options.massless_facets = b.lower();
  problems::ImplicitBody body = b.body(options);
  double total = 0.0;
  for (double m : body.inertia->times(std::vector<double>(body.mass.size(), 1.0)))
    total += m;
  CHECK(total == Catch::Approx(2.0 * density * width * height).epsilon(1e-12)); // in two directions
  const auto plane = std::make_shared<const gap::Rigid>(
      gap::Rigid{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0, 1, 0}});
  const auto slave = surface::make_surface(*b.V, b.lower());
  auto contact = std::make_shared<enforcement::MortarContact>(b.V, slave, plane, enforcement::MortarOptions{},
                                                              std::vector<std::int8_t>(body.mass.size(), 0));
  b.move(0.0, -0.5);
  problems::NewmarkProblem problem(b.u, b.v, body, {}, {}, {{contact}});
  const double before = problem.energies().kinetic;
  problem.advance(0.02, {.dt = 0.01});
  const state::State saved = problem.state().copy();
  const auto run = [&]
  {
    problem.advance(0.1, {.dt = 0.01});
    return std::vector<double>(b.u->x()->array().begin(), b.u->x()->array().end());
  };
  const std::vector<double> first = run();
  CHECK(contact->force().value()[1] > 0.0);
  CHECK(contact->smallest_gap() > -1e-9);
  const integrators::Energies e = problem.energies();
  CHECK(e.kinetic + e.internal == Catch::Approx(before).epsilon(0.02));
  problem.state().assign(saved);
  problem.resume();
  CHECK(problem.time() == Catch::Approx(0.02));
  const std::vector<double> second = run();
  for (std::size_t i = 0; i < first.size(); ++i)
    CHECK(second[i] == Catch::Approx(first[i]).margin(1e-10));
}

TEST_CASE("what does not fit is refused, and a callback that throws leaves the last step", "[newmark]")
{
  Block b;
  CHECK_THROWS_AS(problems::implicit_body(b.u, b.v, {{{"linear_elastic", {}, "plane_strain"}, 0.0}},
                                          problems::prescribed_dofs(*b.V, std::vector<problems::PrescribedMotion>{})),
                  std::invalid_argument);
  CHECK_THROWS_AS(problems::implicit_body(b.u, nullptr, {{{"linear_elastic", {}, "plane_strain"}, 1.0}},
                                          std::vector<std::int8_t>(40, 0), {.beta = 1.0}),
                  std::invalid_argument);
  for (const problems::LoadInTime& load : {problems::LoadInTime{{40}, {1.0}}, problems::LoadInTime{{0, 1}, {1.0}}})
    CHECK_THROWS_AS(problems::NewmarkProblem(b.u, b.v, b.body(), {}, {load}), std::invalid_argument);
  problems::NewmarkProblem problem(b.u, b.v, b.body());
  CHECK_THROWS_AS(problem.advance(1.0, {.dt = 0.0}), dolfinx_impact::common::BadValue);
  CHECK_THROWS_AS(problem.advance(1.0, {.dt = 0.1, .smallest = 0.2}), dolfinx_impact::common::BadValue);
  int called = 0;
  const auto callback = [&](double time, const state::State& state)
  {
    CHECK(state.part("motion").field("velocity").rows() == 20);
    if (++called == 2)
      throw std::runtime_error("stop at " + std::to_string(time));
  };
  CHECK_THROWS_AS(problem.advance(1.0, {.dt = 0.25}, callback), std::runtime_error);
  CHECK(problem.step() == 2);
  CHECK_THROWS_AS(problem.advance(0.1, {.dt = 0.25}), dolfinx_impact::common::BadValue);
  problem.advance(1.0, {.dt = 0.25});
  CHECK(problem.step() == 4);
  CHECK(std::isinf(problem.stable_step()));
}

TEST_CASE("a callback is called after implicit steps that are multiples of its pause", "[newmark]")
{
  Block b;
  problems::NewmarkProblem problem(b.u, b.v, b.body());
  std::vector<std::int64_t> steps;
  const auto note = [&](double, const state::State&) { steps.push_back(problem.step()); };
  CHECK_THROWS_AS(problem.advance(1.0, {.dt = 0.1, .callback_every = 0}, note), dolfinx_impact::common::BadValue);
  problem.advance(0.5, {.dt = 0.1, .callback_every = 4}, note);
  problem.advance(1.1, {.dt = 0.1, .callback_every = 4}, note);
  CHECK(problem.step() == 11);
  CHECK(steps == std::vector<std::int64_t>{4, 8});
}

TEST_CASE("a run asks for the times at which steps end, and tells of steps and values", "[newmark]")
{
  Block b, plain;
  b.move(0.5, 0.0);
  plain.move(0.5, 0.0);
  problems::NewmarkProblem problem(b.u, b.v, b.body()), other(plain.u, plain.v, plain.body());
  std::vector<double> ends, updates;
  int starts = 0, begins = 0;
  problems::ImplicitRunEvents events;
  events.update = [&](double time) { updates.push_back(time); };
  events.started = [&] { ++starts; };
  events.begins = [&] { ++begins; };
  events.goal = [&] { return problem.time() < 0.25 ? 0.25 : 1.0; };
  events.accepted = [&] { ends.push_back(problem.time()); };
  problem.advance(0.4, {.dt = 0.1}, {}, events);
  REQUIRE(ends.size() == 5);
  CHECK(ends[2] == 0.25);
  CHECK(ends[4] == 0.4);
  CHECK(updates[0] == 0.0); // values of the start are asked for, too
  CHECK(updates.back() == 0.4);
  CHECK(starts == 1);
  CHECK(begins == 1);
  // Another problem goes on from there, and moves as the first one does.
  const state::State kept = problems::saved_state(problem);
  problems::resume(other, kept);
  CHECK(other.step() == 5);
  CHECK(problems::saved_state(other).difference_of_values(kept).empty());
  for (problems::NewmarkProblem* one : {&problem, &other})
  {
    one->forget();
    one->advance(0.8, {.dt = 0.1});
  }
  CHECK(std::ranges::equal(b.u->x()->array(), plain.u->x()->array()));
}

TEST_CASE("a scheme that is stable with small steps only says how small", "[newmark]")
{
  Block b;
  problems::NewmarkOptions options;
  options.scheme = integrators::ImplicitScheme::newmark(1.0 / 6.0, 0.5);
  problems::NewmarkProblem problem(b.u, b.v, b.body(), {}, {}, {}, options);
  const double limit = problem.stable_step();
  CHECK(limit > 0.0);
  b.move(0.0, 0.0);
  for (double part : {0.98, 1.05})
  {
    Block c;
    for (std::size_t i = 0; i < c.u->x()->array().size(); ++i)
      dolfinx_impact::common::array(*c.u->x())[i] = 1e-3 * std::sin(7.0 * double(i));
    problems::NewmarkProblem run(c.u, c.v, c.body(), {}, {}, {}, options);
    const double start = run.energies().internal;
    run.advance(200 * part * limit, {.dt = part * limit});
    CHECK((run.energies().internal > 1e3 * start) == (part > 1.0));
  }
}
