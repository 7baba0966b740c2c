// SPDX-License-Identifier: MIT
// Explicit problems in C++: bodies by kernel name, what acts on them in time, steps that follow the body, runs that
// fail.
#include <algorithm>
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/OnAllRanks.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/common/dolfinx_api.h>
#include <dolfinx_impact/enforcement/mortar/MortarContact.h>
#include <dolfinx_impact/enforcement/node_to_surface/NodePenalty.h>
#include <dolfinx_impact/problems/ExplicitProblem.h>
#include <dolfinx_impact/problems/StaticProblem.h>
#include <dolfinx_impact/problems/equilibrium_start.h>
#include <dolfinx_impact/problems/explicit_body.h>
#include <dolfinx_impact/problems/explicit_state.h>
#include <dolfinx_impact/surface/Surface.h>
#include <numeric>
#include <stdexcept>
#include <tuple>

using namespace dolfinx;
using namespace dolfinx_impact;
using Catch::Approx;

namespace
{
namespace explicit_test
{
auto at(int axis, double where)
{
  return [=](auto x)
  {
    std::vector<std::int8_t> marked(x.extent(1));
    for (std::size_t p = 0; p < marked.size(); ++p)
      marked[p] = std::abs(x(axis, p) - where) < 1e-9;
    return marked;
  };
}

/// A unit square of a law of E = 1, density 1.
struct Square
{
  std::shared_ptr<mesh::Mesh<double>> mesh;
  std::shared_ptr<fem::FunctionSpace<double>> V;
  std::shared_ptr<fem::Function<double>> u, v;
  problems::KernelMaterial law;

  explicit Square(std::string name, double speed = 0.0)
      : law{std::move(name), {{"E", {1.0}}, {"nu", {0.3}}}, "plane_strain"}
  {
    mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_rectangle<double>(
        MPI_COMM_SELF, {{{0.0, 0.0}, {1.0, 1.0}}}, {4, 4}, mesh::CellType::quadrilateral));
    const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                       basix::element::lagrange_variant::gll_warped,
                                                       basix::element::dpc_variant::unset, false);
    V = std::make_shared<fem::FunctionSpace<double>>(dolfinx_impact::common::create_functionspace(mesh, element, {2}));
    u = std::make_shared<fem::Function<double>>(V);
    v = std::make_shared<fem::Function<double>>(V);
    const std::vector<double> x = V->tabulate_dof_coordinates(false);
    for (std::size_t node = 0; node < x.size() / 3; ++node)
      dolfinx_impact::common::array(*v->x())[2 * node + 1] = speed * (x[3 * node + 1] - 0.5);
  }

  problems::ExplicitBody body(const problems::ExplicitBodyOptions& options = {}) const
  {
    return problems::explicit_body(u, {{law, 1.0}}, options);
  }
  /// Displacements of an edge, of the value one along y.
  std::shared_ptr<fem::DirichletBC<double>> edge(double y) const
  {
    auto values = std::make_shared<fem::Function<double>>(V);
    for (std::size_t i = 1; i < values->x()->array().size(); i += 2)
      dolfinx_impact::common::array(*values->x())[i] = 1.0;
    return std::make_shared<fem::DirichletBC<double>>(values, fem::locate_dofs_geometrical(*V, at(1, y)));
  }
  double largest() const
  {
    double out = 0.0; // both edges move as far: which of them is the first depends on round-off
    for (const double value : u->x()->array())
      out = std::max(out, std::abs(value));
    return out;
  }
};
} // namespace explicit_test
using explicit_test::Square;
} // namespace

TEST_CASE("a square that swings keeps its energy and tells every step")
{
  Square square("linear_elastic", 0.1);
  problems::ExplicitProblem problem(square.u, square.v, square.body());
  const double start = problem.energies().kinetic, limit = problem.stable_step();
  CHECK(limit == Approx(problem.safe_step().value()).epsilon(1e-14));
  int calls = 0;
  double last = 0.0;
  problem.advance(20.0 * limit, {},
                  [&](double time, const state::State& state)
                  {
                    ++calls;
                    last = time;
                    CHECK(state.field("displacement").rows() == 25);
                    CHECK(time == problem.time());
                  });
  CHECK(calls == problem.step());
  CHECK(calls == 23); // of 0.9 of the stable step
  CHECK(last == 20.0 * limit);
  CHECK(problem.history().num_rows() == 23);
  const integrators::Energies now = problem.energies();
  CHECK(start == Approx(0.5 * 0.01 * 0.09375)); // sum of m (y - 1/2)^2 over five rows of nodes
  CHECK(std::abs(problem.history().drift(now)) < 1e-3);
  CHECK(square.largest() > 0.01);
}

TEST_CASE("steps beyond the stable one are refused; taken nevertheless they fail, and the state is one that was good")
{
  Square square("linear_elastic", 0.1);
  problems::ExplicitProblem problem(square.u, square.v, square.body());
  const double limit = problem.stable_step();
  CHECK_THROWS_AS(problem.advance(100.0, {.dt = 2.0 * limit}), dolfinx_impact::common::BadValue);
  CHECK_THROWS_AS(problem.advance(-1.0), dolfinx_impact::common::BadValue);
  CHECK(problem.step() == 0);
  CHECK_THROWS_WITH(problem.advance(2000.0 * limit, {.dt = 2.0 * limit, .unsafe = true}),
                    Catch::Matchers::ContainsSubstring("went unstable") &&
                        Catch::Matchers::ContainsSubstring("number in the mesh's input"));
  CHECK(problem.time() < 2000.0 * limit);
  CHECK(square.largest() < 1.0);
  problem.advance(problem.time() + 10.0 * limit); // it goes on from there
  CHECK(std::isfinite(problem.energies().kinetic));
}

TEST_CASE("what a callback throws leaves the steps that were made, and the same call goes on with the others")
{
  Square one("linear_elastic", 0.1), other("linear_elastic", 0.1);
  problems::ExplicitProblem left(one.u, one.v, one.body()), whole(other.u, other.v, other.body());
  const double end = 30.0 * whole.stable_step();
  const auto leave = [&](double, const state::State&)
  {
    if (left.step() == 7)
      throw std::out_of_range("left");
  };
  CHECK_THROWS_AS(left.advance(end, {}, leave), std::out_of_range);
  CHECK(left.step() == 7);
  left.advance(end);
  whole.advance(end);
  CHECK(left.step() == whole.step());
  CHECK(std::ranges::equal(one.u->x()->array(), other.u->x()->array()));
}

TEST_CASE("a callback is called after steps that are multiples of its pause")
{
  Square square("linear_elastic", 0.1);
  problems::ExplicitProblem problem(square.u, square.v, square.body());
  const double end = 22.5 * problem.stable_step();
  std::vector<std::int64_t> steps;
  const auto note = [&](double, const state::State&) { steps.push_back(problem.step()); };
  CHECK_THROWS_AS(problem.advance(end, {.callback_every = 0}, note), dolfinx_impact::common::BadValue);
  problem.advance(end, {.callback_every = 10}, note);
  CHECK(problem.step() >= 20);
  CHECK(steps == (problem.step() < 30 ? std::vector<std::int64_t>{10, 20} : std::vector<std::int64_t>{10, 20, 30}));
}

TEST_CASE("a run goes on from a state that was saved as if nothing had been")
{
  Square square("j2.small.linear", 0.5);
  square.law.constants["yield_stress"] = {0.01};
  square.law.constants["modulus"] = {0.1};
  const auto facets = mesh::locate_entities_boundary(*square.mesh, 1, explicit_test::at(1, 0.0));
  const gap::Rigid floor{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0, 1, 0}};
  const auto contact = std::make_shared<enforcement::NodePenalty>(
      *square.V, surface::make_surface(*square.V, facets), floor, enforcement::NodePenaltyOptions{{.friction = 0.3}});
  problems::ExplicitProblem problem(square.u, square.v, square.body({.alpha = 0.1}), {}, {}, {{contact, "floor"}});
  problem.advance(0.5);
  const state::State saved = problems::saved_state(problem);
  const auto schedule = problem.stepper().schedule();
  const auto end = [&]
  {
    problem.advance(2.0);
    const std::span<const double> u = dolfinx_impact::common::array(*square.u->x());
    return std::pair(std::vector<double>(u.begin(), u.end()), problem.energies().values());
  };
  const auto first = end();
  problems::resume(problem, saved, schedule);
  CHECK(problem.time() == 0.5);
  CHECK(end() == first);
  CHECK(first.second[4] + first.second[7] > 0.0); // it has met the floor, and flowed
  Square other("linear_elastic");
  problems::ExplicitProblem of_another(other.u, nullptr, other.body());
  CHECK_THROWS(problems::resume(of_another, saved));
}

TEST_CASE("supports and loads follow their functions of time")
{
  Square square("linear_elastic");
  const auto amplitude = [](double t) { return 0.01 * t * t; };
  // A force of one along x on the upper right corner.
  const auto corner = fem::locate_dofs_geometrical(*square.V,
                                                   [](auto x)
                                                   {
                                                     std::vector<std::int8_t> marked(x.extent(1));
                                                     for (std::size_t p = 0; p < marked.size(); ++p)
                                                       marked[p] = x(0, p) > 1.0 - 1e-9 && x(1, p) > 1.0 - 1e-9;
                                                     return marked;
                                                   });
  const problems::LoadInTime load{
      {2 * corner.at(0)}, {1.0}, problems::FunctionOfTime([](double t) { return 0.1 * t; })};
  problems::ExplicitProblem problem(square.u, square.v, square.body(), {{square.edge(0.0), {amplitude}}}, {load});
  problem.advance(2.0);
  double lowest = 1.0, highest = 0.0;
  for (const std::int32_t node : fem::locate_dofs_geometrical(*square.V, explicit_test::at(1, 0.0)))
  {
    lowest = std::min(lowest, square.u->x()->array()[2 * node + 1]);
    highest = std::max(highest, square.u->x()->array()[2 * node + 1]);
    CHECK(square.u->x()->array()[2 * node] == 0.0);
  }
  CHECK(lowest == Approx(0.04).epsilon(1e-14));
  CHECK(highest == lowest);
  CHECK(square.u->x()->array()[2 * corner[0]] > 0.0);
  CHECK(std::abs(problem.history().drift(problem.energies())) < 0.01); // supports and load have done work
  const auto jump = [](double) { return 1.0; };
  Square still("linear_elastic");
  CHECK_THROWS_AS(problems::ExplicitProblem(still.u, nullptr, still.body(), {{still.edge(0.0), {jump}}}),
                  dolfinx_impact::common::BadValue);
  const auto no_number = [](double t) { return t > 1.0 ? std::nan("") : 0.0; };
  problems::ExplicitProblem stops(still.u, nullptr, still.body(), {{still.edge(0.0), {no_number}}});
  CHECK_THROWS_WITH(stops.advance(2.0), Catch::Matchers::ContainsSubstring("is nan at the time"));
}

TEST_CASE("damping and bulk viscosity take energy, and shorten the stable step")
{
  Square square("neo_hookean", 0.1);
  problems::ExplicitProblem free(square.u, square.v, square.body());
  Square damped("neo_hookean", 0.1);
  problems::ExplicitProblem slow(damped.u, damped.v,
                                 damped.body({.alpha = 0.1, .beta = 0.02, .bulk_viscosity = {0.06, 1.2}}));
  CHECK(slow.stable_step() < free.stable_step());
  slow.advance(3.0);
  const integrators::Energies taken = slow.energies();
  CHECK(taken.damping > 0.0);
  CHECK(taken.viscosity > 0.0);
  CHECK(std::abs(slow.history().drift(taken)) < 0.01);
  CHECK_THROWS_AS(problems::ExplicitProblem(damped.u, damped.v, damped.body({.beta = 0.02}), {}, {}, {},
                                            {.scheme = integrators::Scheme::classical}),
                  std::invalid_argument);
}

TEST_CASE("steps follow a body that stiffens")
{
  Square square("neo_hookean");
  const auto press = [](double t) { return -0.2 * std::min(t, 2.0) * std::min(t, 2.0) / 4.0; };
  problems::ExplicitProblem problem(square.u, square.v, square.body(),
                                    {{square.edge(1.0), {press}}, {square.edge(0.0), {[](double) { return 0.0; }}}});
  const double start = problem.safe_step().value();
  problem.advance(2.0);
  CHECK(problem.safe_step().value() < 0.95 * start);
  CHECK(problem.stepper().nominal_step() < problem.stable_step() * (1.0 + 1e-12));
}

TEST_CASE("a law with internal variables flows; materials have their cells; added mass lengthens steps")
{
  Square square("j2.small.linear", 0.5);
  square.law.constants["yield_stress"] = {0.01};
  square.law.constants["modulus"] = {0.1};
  problems::ExplicitProblem problem(square.u, square.v, square.body());
  problem.advance(1.0);
  CHECK(problem.energies().plastic > 0.01 * problem.energies().kinetic);
  CHECK(std::abs(problem.history().drift(problem.energies())) < 0.01);

  Square two("linear_elastic");
  std::vector<std::int32_t> cells(16), values(16);
  std::iota(cells.begin(), cells.end(), 0);
  for (int k = 0; k < 16; ++k)
    values[k] = k < 6 ? 1 : 2;
  const mesh::MeshTags<std::int32_t> tags(two.mesh->topology(), 2, cells, values);
  const auto sum = [](const problems::ExplicitBody& body)
  { return std::accumulate(body.mass.begin(), body.mass.end(), 0.0) / 2.0; };
  CHECK(sum(problems::explicit_body(two.u, {{two.law, 1.0, 1}, {two.law, 3.0, 2}}, {}, &tags)) ==
        Approx((6.0 + 3.0 * 10.0) / 16.0));
  CHECK_THROWS_AS(problems::explicit_body(two.u, {{two.law, 1.0, 1}}, {}, &tags), std::invalid_argument);
  CHECK_THROWS_AS(problems::explicit_body(two.u, {{two.law, 0.0}}), std::invalid_argument);
  const double limit = problems::ExplicitProblem(two.u, nullptr, two.body()).stable_step();
  const problems::ExplicitBody heavy = two.body({.mass_scaling = 2.0 * limit});
  CHECK(sum(heavy) == Approx(4.0));
  CHECK(problems::ExplicitProblem(two.u, nullptr, heavy).stable_step() == Approx(2.0 * limit));
}

TEST_CASE("quadratic cells are lumped by their kind: positive masses with the right sum")
{
  // Of the mass of a cell a corner has 3/57 by Hinton, Rock and Zienkiewicz (1976) in a triangle, and 1/36 by the
  // weights of the nodes in a quadrilateral.
  for (const auto& [kind, cell, cells, share] :
       {std::tuple(mesh::CellType::triangle, basix::cell::type::triangle, 2, 3.0 / 57.0),
        std::tuple(mesh::CellType::quadrilateral, basix::cell::type::quadrilateral, 1, 1.0 / 36.0)})
  {
    const auto mesh = std::make_shared<mesh::Mesh<double>>(
        mesh::create_rectangle<double>(MPI_COMM_SELF, {{{0.0, 0.0}, {1.0, 1.0}}}, {1, 1}, kind));
    const auto element =
        basix::create_element<double>(basix::element::family::P, cell, 2, basix::element::lagrange_variant::gll_warped,
                                      basix::element::dpc_variant::unset, false);
    const auto V =
        std::make_shared<fem::FunctionSpace<double>>(dolfinx_impact::common::create_functionspace(mesh, element, {2}));
    const auto u = std::make_shared<fem::Function<double>>(V);
    const problems::KernelMaterial law{"linear_elastic", {{"E", {1.0}}, {"nu", {0.3}}}, "plane_strain"};
    const std::vector<double> mass = problems::explicit_body(u, {{law, 1.0}}).mass;
    CHECK(std::accumulate(mass.begin(), mass.end(), 0.0) == Approx(2.0)); // once a direction
    CHECK(std::ranges::min(mass) == Approx(share / cells));
  }
}

TEST_CASE("bodies that overlap their obstacle at the start are refused; others are pushed back")
{
  const gap::Rigid deep{.kind = gap::Rigid::Kind::plane, .gdim = 2, .point = {0.0, 0.2, 0.0}, .direction = {0, 1, 0}};
  const gap::Rigid floor{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0, 1, 0}};
  Square square("linear_elastic");
  const auto facets = mesh::locate_entities_boundary(*square.mesh, 1, explicit_test::at(1, 0.0));
  const auto contact = [&](const gap::Rigid& rigid)
  {
    return std::make_shared<enforcement::NodePenalty>(*square.V, surface::make_surface(*square.V, facets), rigid,
                                                      enforcement::NodePenaltyOptions{});
  };
  CHECK_THROWS_WITH(problems::ExplicitProblem(square.u, square.v, square.body(), {}, {}, {{contact(deep), "pit"}}),
                    Catch::Matchers::StartsWith("pit: ") && Catch::Matchers::ContainsSubstring("overlap at the start"));
  for (std::size_t i = 1; i < square.v->x()->array().size(); i += 2)
    dolfinx_impact::common::array(*square.v->x())[i] = -0.01;
  problems::ExplicitProblem problem(square.u, square.v, square.body(), {}, {}, {{contact(floor), "floor"}});
  problem.advance(4.0);
  const auto forces = problem.history().row(5).subspan(1 + integrators::Energies::size);
  CHECK(forces[1] > 0.0);
  const std::span<const double> speeds = problem.velocity()->x()->array();
  double mean = 0.0;
  for (std::size_t i = 1; i < speeds.size(); i += 2)
    mean += speeds[i] / 25.0;
  CHECK(mean == Approx(0.01).epsilon(0.1));
}

TEST_CASE("a run goes on from a state that was saved as it went on before, in the same problem and in another one")
{
  Square one("neo_hookean", 0.1), two("neo_hookean", 0.1);
  problems::ExplicitProblem problem(one.u, one.v, one.body()), other(two.u, two.v, two.body());
  const double step = problem.stable_step();
  problem.advance(10.0 * step);
  const state::State saved = problems::saved_state(problem);
  CHECK(saved.values<std::int64_t>("step")[0] == problem.step());
  CHECK(problems::empty_state(other).difference_of_structure(saved).empty());
  problem.advance(25.0 * step);
  const std::vector<double> end(one.u->x()->array().begin(), one.u->x()->array().end());
  const std::int64_t steps = problem.step();
  for (auto* from : {&problem, &other})
  {
    problems::resume(*from, saved);
    CHECK(from->time() == 10.0 * step);
    from->advance(25.0 * step);
    CHECK(from->step() == steps);
    CHECK(std::ranges::equal(from->displacement()->x()->array(), end));
  }
  Square third("linear_elastic");
  problems::ExplicitProblem another(third.u, third.v, third.body());
  CHECK_FALSE(problems::empty_state(another).difference_of_structure(saved).empty());
}

namespace
{
namespace explicit_test
{
/// A plate of cells h = 0.1 high and 0.5 wide, of E = 100 without lateral contraction and density 2, on a floor. Its
/// fastest mode moves the rows of nodes against each other, up and down: that of a chain of masses and springs.
struct Plate
{
  static constexpr double E = 100.0, density = 2.0, h = 0.1, wide = 0.5;
  std::shared_ptr<fem::FunctionSpace<double>> V;
  std::shared_ptr<fem::Function<double>> u;
  problems::KernelMaterial law{"linear_elastic", {{"E", {E}}, {"nu", {0.0}}}, "plane_strain"};
  gap::Rigid floor{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0, 1, 0}};

  explicit Plate(int rows)
  {
    auto mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_rectangle<double>(
        MPI_COMM_SELF, {{{0.0, 0.0}, {4 * wide, rows * h}}}, {4, rows}, mesh::CellType::quadrilateral));
    const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                       basix::element::lagrange_variant::gll_warped,
                                                       basix::element::dpc_variant::unset, false);
    V = std::make_shared<fem::FunctionSpace<double>>(dolfinx_impact::common::create_functionspace(mesh, element, {2}));
    u = std::make_shared<fem::Function<double>>(V);
  }
  surface::Facets side(double y) const
  {
    return surface::make_surface(*V, mesh::locate_entities_boundary(*V->mesh(), 1, at(1, y)));
  }
  std::shared_ptr<enforcement::NodePenalty> springs(const enforcement::NodePenaltyOptions& options = {}) const
  {
    return std::make_shared<enforcement::NodePenalty>(*V, side(0.0), floor, options);
  }
  problems::ExplicitProblem problem(std::vector<problems::ContactInTime> contacts = {},
                                    const problems::ExplicitBodyOptions& options = {},
                                    std::vector<problems::PrescribedMotion> supports = {}) const
  {
    return {u, nullptr, problems::explicit_body(u, {{law, density}}, options), std::move(supports), {}, contacts};
  }
};
} // namespace explicit_test
using explicit_test::Plate;
using problems::StableStepMethod;
} // namespace

TEST_CASE("the stable step of a free plate is the time of a wave through a cell, by all methods")
{
  const double cell = Plate::h * std::sqrt(Plate::density / Plate::E); // 2 / omega of a free chain with lumped masses
  for (const int rows : {1, 5})
  {
    problems::ExplicitProblem problem = Plate(rows).problem();
    for (const auto method : {StableStepMethod::length, StableStepMethod::element, StableStepMethod::eigenvalue})
      CHECK(problem.stable_step(method) == Approx(cell).epsilon(1e-8)); // tolerance of the eigenvalue
  }
  const double alpha = 0.3 * 2.0 / cell, xi = 0.15; // seed (3.78): alpha/(2 omega)
  problems::ExplicitProblem damped = Plate(5).problem({}, {.alpha = alpha});
  for (const auto method : {StableStepMethod::length, StableStepMethod::element, StableStepMethod::eigenvalue})
    CHECK(damped.stable_step(method) == Approx(cell * (std::sqrt(1.0 + xi * xi) - xi)).epsilon(1e-8));
}

TEST_CASE("springs of a given penalty lower the stable step, which nobody has to tell")
{
  const double E = Plate::E, h = Plate::h, mass = 0.5 * Plate::density * h, penalty = 3000.0; // per area
  const Plate plate(1);
  problems::ExplicitProblem problem = plate.problem({{plate.springs({{}, penalty}), "floor"}});
  // Two masses m with a spring k = E/h between them, one of them on the spring of the floor.
  const double k = E / h;
  const double highest = (2.0 * k + penalty + std::sqrt(4.0 * k * k + penalty * penalty)) / (2.0 * mass);
  CHECK(problem.stable_step(StableStepMethod::eigenvalue) == Approx(2.0 / std::sqrt(highest)).epsilon(1e-8));
  const double bound = 2.0 / std::sqrt(2.0 * k / mass + penalty / mass);
  for (const auto method : {StableStepMethod::length, StableStepMethod::element})
    CHECK(problem.stable_step(method) == Approx(bound).epsilon(1e-12));
  CHECK(problem.safe_step().value() == Approx(bound).epsilon(1e-12));
  // Held at its other end, one mass swings between both springs.
  auto still = std::make_shared<fem::Function<double>>(plate.V);
  auto top = std::make_shared<fem::DirichletBC<double>>(
      still, fem::locate_dofs_geometrical(*plate.V, explicit_test::at(1, h)));
  problems::ExplicitProblem held = plate.problem({{plate.springs({{}, penalty}), "floor"}}, {}, {{top}});
  CHECK(held.stable_step(StableStepMethod::eigenvalue) == Approx(2.0 / std::sqrt((k + penalty) / mass)).epsilon(1e-8));
}

TEST_CASE("springs without a given penalty have half the stiffness of a layer, or follow the step")
{
  const Plate plate(2);
  const double h = Plate::h, mass = 0.5 * Plate::density * h * Plate::wide; // of an inner node of the lower side
  for (std::size_t i = 1; i < plate.u->x()->array().size(); i += 2)
    dolfinx_impact::common::array(*plate.u->x())[i] = -0.01 * h;
  const auto automatic = plate.springs(), by_step = plate.springs({.by_step = true});
  problems::ExplicitProblem one = plate.problem({{automatic, "floor"}});
  problems::ExplicitProblem other = plate.problem({{by_step, "floor"}});
  const double step = one.stable_step();
  CHECK(step == Approx(h * std::sqrt(Plate::density / Plate::E)).epsilon(1e-12));
  CHECK(other.stable_step() == step);
  one.advance(0.9 * step);
  other.advance(0.9 * step);
  // Half a layer E A/(2 h) is more than what the mass bears, 0.19/0.81 m omega^2: cells are wider than high.
  const double square_frequency = 4.0 / (step * step), layer = 0.5 * Plate::E / h * Plate::wide;
  CHECK(0.19 / 0.81 * mass * square_frequency < layer);
  CHECK(std::ranges::max(automatic->stiffness()) == Approx(0.19 / 0.81 * mass * square_frequency).epsilon(1e-9));
  CHECK(std::ranges::max(by_step->stiffness()) == Approx(0.5 * mass / (0.81 * step * step)).epsilon(1e-12));
  // On its narrow side cells are longer than wide, and the layer counts: E A/(2 wide).
  const auto end =
      surface::make_surface(*plate.V, mesh::locate_entities_boundary(*plate.V->mesh(), 1, explicit_test::at(0, 0.0)));
  const gap::Rigid wall{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {1, 0, 0}};
  const auto narrow = std::make_shared<enforcement::NodePenalty>(*plate.V, end, wall);
  for (std::size_t i = 0; i < plate.u->x()->array().size(); i += 2)
    dolfinx_impact::common::array(*plate.u->x())[i] = -0.01 * h;
  problems::ExplicitProblem third = plate.problem({{narrow, "wall"}});
  third.advance(0.9 * step);
  CHECK(std::ranges::max(narrow->stiffness()) == Approx(0.5 * Plate::E / Plate::wide * h).epsilon(1e-9));
}

TEST_CASE("an explicit run goes on from an equilibrium of multipliers at rest")
{
  const Plate plate(5);
  const double pressure = 0.5, weight = 4 * Plate::wide * pressure;
  const auto body = std::make_shared<problems::KernelBody>(plate.u, plate.law);
  problems::LoadInTime load;
  for (const std::int32_t node : fem::locate_dofs_geometrical(*plate.V, explicit_test::at(1, 5 * Plate::h)))
  {
    const double x = plate.V->tabulate_dof_coordinates(false)[3 * node];
    const double part = x < 1e-9 || x > 4 * Plate::wide - 1e-9 ? 0.5 : 1.0;
    load.dofs.push_back(2 * node + 1);
    load.values.push_back(-pressure * Plate::wide * part);
    body->loads()[2 * node + 1] = load.values.back();
  }
  std::vector<std::int32_t> sideways; // the middle cannot go there
  for (const std::int32_t node : fem::locate_dofs_geometrical(*plate.V, explicit_test::at(0, 2 * Plate::wide)))
    sideways.push_back(2 * node);
  const auto Vx = std::make_shared<fem::FunctionSpace<double>>(plate.V->sub({0}));
  auto held = std::make_shared<fem::DirichletBC<double>>(std::make_shared<fem::Constant<double>>(0.0), sideways, Vx);
  const problems::BoundaryConditions bcs{held};
  auto contact = std::make_shared<enforcement::MortarContact>(
      plate.V, plate.side(0.0), std::make_shared<const gap::Rigid>(plate.floor), enforcement::MortarOptions{},
      problems::prescribed_dofs(*plate.V, bcs));
  problems::StaticProblem equilibrium(plate.u, body, bcs, {contact});
  equilibrium.solve();
  REQUIRE(contact->totals().force[1] == Approx(weight));

  const auto springs = plate.springs();
  auto u = std::make_shared<fem::Function<double>>(plate.V);
  std::ranges::copy(plate.u->x()->array(), dolfinx_impact::common::array(*u->x()).begin());
  problems::ExplicitProblem run(u, nullptr, problems::explicit_body(u, {{plate.law, Plate::density}}), {{held}}, {load},
                                {{springs, "floor"}});
  problems::start_from_equilibrium(run, *equilibrium.equilibrium());
  CHECK(run.time() == 0.0);
  CHECK(springs->force()[1] == Approx(weight).epsilon(1e-5)); // the approach is found to 1e-6
  // What the springs give way by: weight over the sum of their stiffness.
  double sum = 0.0;
  for (const double k : springs->stiffness())
    sum += k;
  CHECK(plate.u->x()->array()[1] - u->x()->array()[1] == Approx(weight / sum).epsilon(1e-5));
  run.advance(20.0 * run.stable_step());
  const double impact = pressure / std::sqrt(Plate::E * Plate::density); // velocity of a surface that is loaded at once
  for (const double v : run.velocity()->x()->array())
    CHECK(std::abs(v) < 1e-4 * impact);
  problems::ExplicitProblem apart = plate.problem();
  CHECK_THROWS_AS(problems::start_from_equilibrium(apart, *equilibrium.equilibrium()), std::invalid_argument);
}
