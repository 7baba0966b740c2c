// SPDX-License-Identifier: MIT
// Flows, the derivative along them, the inertia of a body that spins, and what a rolling problem refuses.
#include <algorithm>
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/generators/catch_generators_range.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/OnAllRanks.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/common/dolfinx_api.h>
#include <dolfinx_impact/enforcement/penalty/QuadraturePenalty.h>
#include <dolfinx_impact/operators/petsc_check.h>
#include <dolfinx_impact/problems/KernelBody.h>
#include <dolfinx_impact/problems/RollingProblem.h>
#include <dolfinx_impact/problems/SpinningBody.h>
#include <numeric>
#include <stdexcept>

using namespace dolfinx;
using namespace dolfinx_impact;
using Catch::Matchers::ContainsSubstring;

namespace
{
auto bottom()
{
  return [](auto x)
  {
    std::vector<std::int8_t> marked(x.extent(1));
    for (std::size_t p = 0; p < marked.size(); ++p)
      marked[p] = std::abs(x(1, p)) < 1e-9;
    return marked;
  };
}

/// A square of quadrilaterals with its lower side on y = 0.
std::shared_ptr<fem::FunctionSpace<double>> square(int degree, int cells = 6)
{
  auto mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_rectangle<double>(
      MPI_COMM_SELF, {{{0.0, 0.0}, {1.0, 1.0}}}, {cells, cells}, mesh::CellType::quadrilateral));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral,
                                                     degree, basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  return std::make_shared<fem::FunctionSpace<double>>(dolfinx_impact::common::create_functionspace(mesh, element, {2}));
}

std::vector<std::int32_t> counted(std::size_t n)
{
  std::vector<std::int32_t> out(n);
  std::iota(out.begin(), out.end(), 0);
  return out;
}

std::size_t num_nodes(const fem::FunctionSpace<double>& V)
{
  return V.dofmap()->index_map->size_local() + V.dofmap()->index_map->num_ghosts();
}

std::shared_ptr<fem::Constant<double>> vector(std::vector<double> value)
{
  const std::vector<std::size_t> shape{value.size()};
  return std::make_shared<fem::Constant<double>>(value, shape);
}

/// A square or a cube of some cells.
std::shared_ptr<fem::FunctionSpace<double>> block(mesh::CellType cell)
{
  const int dim = mesh::cell_dim(cell);
  auto mesh = std::make_shared<mesh::Mesh<double>>(
      dim == 2 ? mesh::create_rectangle<double>(MPI_COMM_SELF, {{{0.0, 0.0}, {1.0, 1.0}}}, {4, 4}, cell)
               : mesh::create_box<double>(MPI_COMM_SELF, {{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}}}, {3, 3, 3}, cell));
  const auto element = basix::create_element<double>(basix::element::family::P, mesh::cell_type_to_basix_type(cell), 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  return std::make_shared<fem::FunctionSpace<double>>(
      dolfinx_impact::common::create_functionspace(mesh, element, {std::size_t(dim)}));
}

/// A square or a cube that spins about an axis through its centre, in space an oblique one; its lower side is held.
struct Spinning
{
  std::shared_ptr<fem::FunctionSpace<double>> V;
  int dim;
  std::array<double, 3> axis;
  std::shared_ptr<fem::Function<double>> u = std::make_shared<fem::Function<double>>(V);
  std::shared_ptr<fem::Constant<double>> omega = std::make_shared<fem::Constant<double>>(0.2);
  rolling::Motion motion{rolling::Spin{{0.5, 0.5, dim == 3 ? 0.5 : 0.0}, axis}, omega, counted(num_nodes(*V))};
  std::shared_ptr<rolling::Flow> flow = std::make_shared<rolling::Flow>(V, std::vector{motion});
  std::shared_ptr<problems::SpinningBody> body = std::make_shared<problems::SpinningBody>(
      u,
      std::make_shared<problems::KernelBody>(
          u,
          problems::KernelMaterial{"linear_elastic", {{"E", {10.0}}, {"nu", {0.3}}}, dim == 2 ? "plane_strain" : ""}),
      motion, problems::SpinningMaterial{2.0, counted(V->mesh()->topology()->index_map(dim)->size_local())});
  problems::BoundaryConditions bcs{std::make_shared<fem::DirichletBC<double>>(
      vector(std::vector<double>(dim, 0.0)), fem::locate_dofs_geometrical(*V, bottom()), V)};

  explicit Spinning(mesh::CellType cell = mesh::CellType::quadrilateral)
      : V(block(cell)), dim(mesh::cell_dim(cell)),
        axis(dim == 2 ? std::array<double, 3>{0.0, 0.0, 1.0} : std::array<double, 3>{2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0})
  {
  }

  std::vector<double> residual()
  {
    operators::Entries entries(body->residual());
    return {entries.begin(), entries.end()};
  }
  std::shared_ptr<problems::StaticProblem> equilibrium()
  {
    return std::make_shared<problems::StaticProblem>(u, body, bcs);
  }
};
} // namespace

TEST_CASE("velocities of a spin and a translation", "[rolling]")
{
  const auto V = square(1);
  const auto omega = std::make_shared<fem::Constant<double>>(3.0);
  rolling::Flow flow(V, {{rolling::Spin{{0.5, 0.5, 0.0}, {0.0, 0.0, -1.0}}, omega, counted(num_nodes(*V))}});
  const std::vector<double> w = flow.at_nodes();
  for (std::size_t i = 0; i < num_nodes(*V); ++i)
  {
    const double* x = flow.place(std::int32_t(i));
    CHECK(w[2 * i] == Catch::Approx(3.0 * (x[1] - 0.5)).margin(1e-15));
    CHECK(w[2 * i + 1] == Catch::Approx(-3.0 * (x[0] - 0.5)).margin(1e-15));
  }
  CHECK(flow.reached() == std::vector<double>{0.0}); // load steps begin at rest
  flow.mark_reached();
  CHECK(flow.reached() == std::vector<double>{3.0});
}

TEST_CASE("flows that do not fit the mesh are refused", "[rolling]")
{
  const auto V = square(1);
  const auto omega = std::make_shared<fem::Constant<double>>(1.0);
  const auto make = [&](rolling::Motion motion) { return rolling::Flow(V, {std::move(motion)}); };
  CHECK_THROWS_WITH(make({rolling::Spin{{}, {0.0, 0.0, 2.0}}, omega, {}}), ContainsSubstring("no unit vector"));
  CHECK_THROWS_WITH(make({rolling::Spin{{}, {1.0, 0.0, 0.0}}, omega, {}}), ContainsSubstring("along z"));
  CHECK_THROWS_WITH(make({rolling::Translation(), omega, {}}), ContainsSubstring("1 components"));
  CHECK_THROWS_WITH(make({rolling::Spin(), nullptr, {}}), ContainsSubstring("no rate"));
}

TEST_CASE("the derivative along the flow is exact for parabolas, but where the material enters", "[rolling]")
{
  const int degree = GENERATE(1, 2), way = GENERATE(1, -1);
  const auto V = square(degree);
  const surface::Facets facets = surface::make_surface(*V, mesh::locate_entities_boundary(*V->mesh(), 1, bottom()));
  const double speed = 2.5 * way;
  const rolling::Flow flow(V, {{rolling::Translation(), vector({speed, 0.0}), counted(num_nodes(*V))}});
  const operators::OwnedMatrix D = rolling::StreamlineDerivative(V, {&facets}).matrix(flow.at_nodes());
  Vec made[2] = {};
  operators::check(MatCreateVecs(D.get(), &made[0], &made[1]), "vectors are made");
  const operators::OwnedVector x(made[0]), y(made[1]);
  {
    operators::Entries values(x.get());
    for (std::size_t i = 0; i < values.size(); ++i)
    {
      const double s = flow.place(std::int32_t(i))[0];
      values[i] = 1.0 + 2.0 * s + 3.0 * s * s;
    }
  }
  operators::check(MatMult(D.get(), x.get(), y.get()), "a matrix is multiplied");
  operators::Entries found(y.get());
  int checked = 0;
  for (std::size_t i = 0; i < found.size(); ++i)
  {
    const double* place = flow.place(std::int32_t(i));
    const double s = way > 0 ? place[0] : 1.0 - place[0]; // way from the inlet
    if (place[1] > 1e-9)
      CHECK(found[i] == 0.0); // not on the surface
    else if (degree == 2 || s > 1.5 / 6.0)
    {
      CHECK(found[i] == Catch::Approx(speed * (2.0 + 6.0 * place[0])).epsilon(1e-11));
      ++checked;
    }
  }
  CHECK(checked == (degree == 2 ? 13 : 5));
}

constexpr mesh::CellType cells[] = {mesh::CellType::triangle, mesh::CellType::quadrilateral,
                                    mesh::CellType::tetrahedron, mesh::CellType::hexahedron};

TEST_CASE("the tangent of a body that spins is the derivative of its residual", "[rolling]")
{
  Spinning s(GENERATE(from_range(cells)));
  const std::size_t n = s.u->x()->array().size();
  std::vector<double> way(n);
  for (std::size_t i = 0; i < n; ++i)
    way[i] = std::sin(1.0 + 3.0 * double(i));
  Vec made[2] = {};
  operators::check(MatCreateVecs(s.body->tangent(), &made[0], &made[1]), "vectors are made");
  const operators::OwnedVector x(made[0]), y(made[1]);
  for (double rate : {0.2, 1.5}) // the matrix is that of the present rate
  {
    s.omega->value[0] = rate;
    std::ranges::fill(dolfinx_impact::common::array(*s.u->x()), 0.0);
    const std::vector<double> before = s.residual();
    std::ranges::copy(way, dolfinx_impact::common::array(*s.u->x()).begin());
    const std::vector<double> after = s.residual();
    {
      operators::Entries values(x.get());
      std::ranges::copy(way, values.begin());
    }
    operators::check(MatMult(s.body->tangent(), x.get(), y.get()), "a matrix is multiplied");
    operators::Entries product(y.get());
    for (std::size_t i = 0; i < n; ++i)
      CHECK(product[i] == Catch::Approx(after[i] - before[i]).margin(1e-12)); // linear in the displacement
  }
}

TEST_CASE("the centrifugal load is mass times acceleration", "[rolling]")
{
  Spinning s(GENERATE(from_range(cells)));
  const std::vector<double> r = s.residual();
  // Work of the forces on the places from the centre: density omega^2 times the integral of the squared distance from
  // the axis, which is 1/6 for any axis through the centre of a cube.
  double work = 0.0;
  for (std::size_t i = 0; i < r.size() / s.dim; ++i)
    for (int c = 0; c < s.dim; ++c)
      work -= r[s.dim * i + c] * (s.flow->place(std::int32_t(i))[c] - 0.5);
  CHECK(work == Catch::Approx(2.0 * 0.04 / 6.0).epsilon(1e-12));
}

TEST_CASE("rolling problems without friction, and calls that are refused", "[rolling]")
{
  Spinning s;
  problems::RollingProblem problem(s.equilibrium(), s.flow);
  const problems::RollingReport report = problem.solve();
  CHECK(report.steps.converged);
  CHECK(report.warning == "");
  CHECK(s.flow->reached() == std::vector<double>{0.2});
  CHECK(problem.negative_directions() == 0);
  const std::vector<double> before(s.u->x()->array().begin(), s.u->x()->array().end());
  CHECK_THROWS_AS(problem.solve({}, {}, 0.0), std::invalid_argument); // a torque without friction
  CHECK_THROWS_AS(problem.power_balance(), std::invalid_argument);
  problems::SolveEvents nested;
  nested.steps.accepted = [&](double) { problem.solve(); };
  CHECK_THROWS_AS(problem.solve({}, nested), dolfinx_impact::common::Failure);
  s.omega->value[0] = 50.0; // waves of shear travel around it with 1.4
  CHECK_THROWS_WITH(problem.solve(), ContainsSubstring("beyond the critical one"));
  CHECK(std::ranges::equal(s.u->x()->array(), before));
  CHECK(s.flow->reached() == std::vector<double>{0.2});
  s.omega->value[0] = 0.2;
  CHECK(problem.solve().steps.converged);
}

TEST_CASE("contacts with friction and others are not mixed", "[rolling]")
{
  Spinning s;
  const gap::Rigid plane{.kind = gap::Rigid::Kind::plane, .gdim = 2, .point = {0, -0.1, 0}, .direction = {0, 1, 0}};
  const auto rail = std::make_shared<const gap::Rigid>(plane);
  const surface::Facets facets = surface::make_surface(*s.V, mesh::locate_entities_boundary(*s.V->mesh(), 1, bottom()));
  const std::vector<std::int8_t> fixed = problems::prescribed_dofs(*s.V, s.bcs);
  const auto rolls = std::make_shared<rolling::RollingContact>(
      s.V, facets, rail, enforcement::MortarOptions{.name = "rolls", .friction = 0.3}, fixed, s.flow);
  CHECK(rolls->friction() == 0.0); // of slips of increments
  CHECK(rolls->options().friction == 0.3);
  const auto problem =
      [&](std::vector<std::shared_ptr<enforcement::StaticContact>> contacts, std::shared_ptr<rolling::Flow> flow)
  { problems::RollingProblem(std::make_shared<problems::StaticProblem>(s.u, s.body, s.bcs, contacts), flow); };
  CHECK_NOTHROW(problem({rolls}, s.flow));
  const auto other = std::make_shared<rolling::Flow>(s.V, std::vector{s.motion});
  CHECK_THROWS_WITH(problem({rolls}, other), ContainsSubstring("another flow"));
  const auto pressed = std::make_shared<enforcement::QuadraturePenalty>("pressed", s.V, facets, plane,
                                                                        enforcement::PenaltyOptions{.penalty = 10.0});
  CHECK_THROWS_WITH(problem({rolls, pressed}, s.flow), ContainsSubstring("all contacts are RollingContacts"));
  CHECK_NOTHROW(problem({pressed}, s.flow));
}
