// SPDX-License-Identifier: MIT
// Bodies of materials with kernels: consistent tangents, a bar that yields, materials by cells, a history that is gone
// back to.
#include <algorithm>
#include <array>
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <dolfinx/fem/Constant.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/common/dolfinx_api.h>
#include <dolfinx_impact/problems/KernelBody.h>
#include <dolfinx_impact/problems/StaticProblem.h>
#include <numeric>
#include <petscvec.h>
#include <stdexcept>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
constexpr double E = 200.0, nu = 0.3, Y = 0.5, H = 20.0, length = 2.0;

problems::KernelMaterial plastic(const std::string& law)
{
  return {law,
          {{"E", {E}}, {"nu", {nu}}, {"yield_stress", {Y}}, {"modulus", {H}}, {"saturation", {0.8}}, {"rate", {30.0}}},
          "3d"};
}

/// A bar along x of one cell of each half.
struct Bar
{
  std::shared_ptr<mesh::Mesh<double>> mesh;
  std::shared_ptr<fem::FunctionSpace<double>> V;
  std::shared_ptr<fem::Function<double>> u;

  Bar(mesh::CellType cell, int degree)
      : mesh(std::make_shared<mesh::Mesh<double>>(
            mesh::create_box<double>(MPI_COMM_SELF, {{{0.0, 0.0, 0.0}, {length, 1.0, 1.0}}}, {2, 1, 1}, cell)))
  {
    const auto element = basix::create_element<double>(basix::element::family::P, mesh::cell_type_to_basix_type(cell),
                                                       degree, basix::element::lagrange_variant::gll_warped,
                                                       basix::element::dpc_variant::unset, false);
    V = std::make_shared<fem::FunctionSpace<double>>(dolfinx_impact::common::create_functionspace(mesh, element, {3}));
    u = std::make_shared<fem::Function<double>>(V);
  }

  /// A smooth displacement that is no translation.
  void deform(double size)
  {
    u->interpolate(
        [size](auto x) -> std::pair<std::vector<double>, std::vector<std::size_t>>
        {
          const std::size_t n = x.extent(1);
          std::vector<double> v(3 * n);
          for (std::size_t p = 0; p < n; ++p)
            for (int i = 0; i < 3; ++i)
              v[i * n + p] = size * std::sin(1.0 + i + x(i, p) + 0.7 * x((i + 1) % 3, p));
          return {v, {3, n}};
        });
  }
};

std::vector<double> values(Vec b)
{
  const PetscScalar* from = nullptr;
  PetscInt size = 0;
  VecGetLocalSize(b, &size);
  VecGetArrayRead(b, &from);
  std::vector<double> out(from, from + size);
  VecRestoreArrayRead(b, &from);
  return out;
}

double norm(const std::vector<double>& x)
{
  return std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.0));
}

/// A bar whose end is pulled, free across.
struct Pulled : Bar
{
  std::shared_ptr<fem::Constant<double>> end = std::make_shared<fem::Constant<double>>(0.0);
  std::shared_ptr<problems::KernelBody> body;
  std::shared_ptr<problems::StaticProblem> problem;
  std::vector<std::int32_t> pulled;

  explicit Pulled(std::shared_ptr<problems::KernelBody> (*make)(Pulled&)) : Bar(mesh::CellType::hexahedron, 1)
  {
    body = make(*this);
    const auto x = V->tabulate_dof_coordinates(false);
    std::array<std::vector<std::int32_t>, 3> fixed; // by component
    for (std::int32_t node = 0; node < std::int32_t(x.size() / 3); ++node)
    {
      for (int i = 0; i < 3; ++i)
        if (std::abs(x[3 * node + i]) < 1e-9)
          fixed[i].push_back(3 * node + i);
      if (std::abs(x[3 * node] - length) < 1e-9)
        pulled.push_back(3 * node);
    }
    problems::BoundaryConditions bcs;
    for (int i = 0; i < 3; ++i)
      bcs.push_back(std::make_shared<fem::DirichletBC<double>>(
          0.0, fixed[i], std::make_shared<fem::FunctionSpace<double>>(V->sub({i}))));
    bcs.push_back(std::make_shared<fem::DirichletBC<double>>(
        end, pulled, std::make_shared<fem::FunctionSpace<double>>(V->sub({0}))));
    problem = std::make_shared<problems::StaticProblem>(u, body, bcs);
  }

  /// Stress of the bar after its end has been moved.
  double pull(double by, int steps = 1)
  {
    end->value = {by};
    const auto report = problem->solve({.steps = steps, .rtol = 1e-12});
    iterations = *std::ranges::max_element(report.iterations);
    const std::vector<double> forces = values(body->residual());
    double sum = 0.0;
    for (std::int32_t dof : pulled)
      sum += forces[dof];
    return sum;
  }
  int iterations = 0;
};
} // namespace

TEST_CASE("the tangent of a body with a history is the derivative of its residual")
{
  const auto cell = GENERATE(mesh::CellType::hexahedron, mesh::CellType::tetrahedron);
  const std::string law = GENERATE("j2.small.linear", "j2.finite.linear", "j2.finite.voce");
  if (cell == mesh::CellType::tetrahedron && law == "j2.finite.voce")
    return; // not in the table
  Bar bar(cell, cell == mesh::CellType::hexahedron ? 1 : 2);
  problems::KernelBody body(bar.u, plastic(law));
  CHECK(body.properties().inelastic);
  bar.deform(0.01);
  body.residual();
  REQUIRE(body.fault().empty());
  body.accept_step();
  bar.deform(0.03);
  const std::vector<double> start(bar.u->x()->array().begin(), bar.u->x()->array().end());
  body.residual(); // the tangent is that of the local unknowns here
  Mat K = body.tangent();
  Vec d = nullptr, product = nullptr;
  MatCreateVecs(K, &d, &product);
  for (std::size_t i = 0; i < start.size(); ++i)
    VecSetValue(d, PetscInt(i), std::cos(double(3 * i)), INSERT_VALUES);
  VecAssemblyBegin(d), VecAssemblyEnd(d);
  MatMult(K, d, product);
  const std::vector<double> direction = values(d), tangent = values(product);
  VecDestroy(&d), VecDestroy(&product);
  // Central differences: the error is (h E/Y)^2 = 2e-7, as forces change over strains of Y/E, and round-off 1e-10.
  const double h = 1e-6;
  const auto force = [&](double s)
  {
    for (std::size_t i = 0; i < start.size(); ++i)
      dolfinx_impact::common::array(*bar.u->x())[i] = start[i] + s * direction[i];
    return values(body.residual());
  };
  const std::vector<double> plus = force(h), minus = force(-h);
  std::vector<double> error(plus.size());
  for (std::size_t i = 0; i < error.size(); ++i)
    error[i] = tangent[i] - (plus[i] - minus[i]) / (2 * h);
  CHECK(norm(error) < 1e-6 * norm(tangent));
}

TEST_CASE("a bar that yields has the stress of its hardening, unloads elastically and comes back to a copied state")
{
  Pulled bar([](Pulled& p) { return std::make_shared<problems::KernelBody>(p.u, plastic("j2.small.linear")); });
  const double slope = E * H / (E + H), yields = Y / E;
  CHECK(bar.pull(0.5 * yields * length) == Catch::Approx(0.5 * Y).epsilon(1e-9));
  CHECK(bar.body->stored_energy().value() == Catch::Approx(0.125 * Y * yields * length).epsilon(1e-9));
  const double strain = 4 * yields, stress = Y + slope * (strain - yields);
  CHECK(bar.pull(strain * length, 2) == Catch::Approx(stress).epsilon(1e-9));
  CHECK(bar.iterations <= 6); // converges quadratically, after one iteration that is elastic
  const state::State loaded = bar.problem->state().copy();
  CHECK(bar.pull((strain - yields) * length) == Catch::Approx(stress - Y).epsilon(1e-9));
  bar.problem->state().assign(loaded);
  CHECK(bar.pull((strain - 0.5 * yields) * length) == Catch::Approx(stress - 0.5 * Y).epsilon(1e-9));
}

namespace
{
/// A body of two materials, one on each half of the bar.
std::shared_ptr<problems::KernelBody> halves(Bar& bar, const problems::KernelMaterial& left,
                                             const problems::KernelMaterial& right)
{
  std::vector<problems::MaterialCells> both{{left, {}}, {right, {}}};
  const auto geometry = dolfinx_impact::common::geometry_dofmap(*bar.mesh);
  for (std::int32_t cell = 0; cell < std::int32_t(geometry.extent(0)); ++cell)
  {
    double centre = 0.0;
    for (std::size_t i = 0; i < geometry.extent(1); ++i)
      centre += bar.mesh->geometry().x()[3 * geometry(cell, i)] / double(geometry.extent(1));
    both[centre < 0.5 * length ? 0 : 1].cells.push_back(cell);
  }
  return std::make_shared<problems::KernelBody>(bar.u, both, problems::KernelBody::Loads{});
}
} // namespace

TEST_CASE("materials by cells: two halves of one material are the whole, an elastic half has no history")
{
  const double strain = 3 * Y / E;
  Pulled whole([](Pulled& p) { return std::make_shared<problems::KernelBody>(p.u, plastic("j2.small.linear")); });
  Pulled equal([](Pulled& p) { return halves(p, plastic("j2.small.linear"), plastic("j2.small.linear")); });
  const double stress = whole.pull(strain * length);
  CHECK(equal.pull(strain * length) == Catch::Approx(stress).epsilon(1e-11));
  CHECK(equal.body->state().parts().size() == 2);
  Pulled mixed([](Pulled& p)
               { return halves(p, plastic("j2.small.linear"), {"linear_elastic", {{"E", {E}}, {"nu", {nu}}}, "3d"}); });
  const double stiffer = mixed.pull(strain * length);
  CHECK(stiffer > 1.2 * stress); // springs in series, of which one does not yield
  CHECK(stiffer < E * strain);
  CHECK(mixed.body->state().parts().size() == 1);
}

TEST_CASE("a law that is not in the table is refused")
{
  Bar bar(mesh::CellType::hexahedron, 1);
  CHECK_THROWS_AS(problems::KernelBody(bar.u, plastic("j2.small.quadratic")), std::runtime_error);
  auto material = plastic("j2.small.linear");
  material.constants.erase("yield_stress");
  CHECK_THROWS_AS(problems::KernelBody(bar.u, material), std::invalid_argument);
}
