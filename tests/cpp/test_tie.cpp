// SPDX-License-Identifier: MIT
// A slit ring that is tied to itself: conditions, the system of the explicit step, a tie in Newton's method, refusals.
#include <algorithm>
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/enforcement/mortar/Tie.h>
#include <dolfinx_impact/enforcement/mortar/TieSystem.h>
#include <dolfinx_impact/enforcement/mortar/tied_nodes.h>
#include <dolfinx_impact/operators/CholeskyFactors.h>
#include <dolfinx_impact/surface/Surface.h>
#include <memory>
#include <numbers>
#include <numeric>
#include <petscmat.h>
#include <stdexcept>
#include <utility>

using namespace dolfinx_impact;
using namespace dolfinx_impact::enforcement;
using Catch::Approx;
using Catch::Matchers::ContainsSubstring;

namespace
{
namespace tie_test
{
/// A ring of radii 1 and 2 with a slit along the positive first axis, whose sides have nodes at other radii.
struct SlitRing
{
  std::shared_ptr<surface::FunctionSpace> V;
  surface::Facets slave, master;
  std::size_t size = 0;

  /// @param[in] share part of the slit, from inside, that the master has
  explicit SlitRing(double share = 1.0)
  {
    const auto mesh = std::make_shared<dolfinx::mesh::Mesh<double>>(dolfinx::mesh::create_rectangle<double>(
        MPI_COMM_SELF, {{{0.0, 1.0}, {1.0, 2.0}}}, {8, 4}, dolfinx::mesh::CellType::quadrilateral));
    const auto side = [](double at, double up_to)
    {
      return [=](auto x)
      {
        std::vector<std::int8_t> on;
        for (std::size_t p = 0; p < x.extent(1); ++p)
          on.push_back(std::abs(x(0, p) - at) < 1e-9 && x(1, p) < up_to + 1e-9);
        return on;
      };
    };
    const std::vector<std::int32_t> first = dolfinx::mesh::locate_entities_boundary(*mesh, 1, side(0.0, 2.0));
    const std::vector<std::int32_t> last = dolfinx::mesh::locate_entities_boundary(*mesh, 1, side(1.0, 1.0 + share));
    const std::span<double> x = mesh->geometry().x();
    for (std::size_t k = 0; k < x.size(); k += 3)
    {
      const double turn = x[k], angle = 2.0 * std::numbers::pi * turn;
      const double radius = x[k + 1] + 0.06 * turn * std::sin(std::numbers::pi * (x[k + 1] - 1.0));
      x[k] = radius * std::cos(angle);
      x[k + 1] = turn == 1.0 ? 0.0 : radius * std::sin(angle);
    }
    const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                       basix::element::lagrange_variant::gll_warped,
                                                       basix::element::dpc_variant::unset, false);
    V = std::make_shared<surface::FunctionSpace>(dolfinx_impact::common::create_functionspace(mesh, element, {2}));
    slave = surface::make_surface(*V, first);
    master = surface::make_surface(*V, last);
    size = 2 * std::size_t(V->dofmap()->index_map->size_local());
  }

  TieConditions conditions(const TieOptions& options = {}, std::vector<std::int8_t> fixed = {}) const
  {
    fixed.resize(size, 0);
    return TieConditions(V, slave, master, options, std::move(fixed));
  }
  /// A field of the positions.
  template <typename F>
  std::vector<double> field(F&& f) const
  {
    const std::vector<double> x = V->tabulate_dof_coordinates(false);
    std::vector<double> out;
    for (std::size_t k = 0; k < x.size(); k += 3)
      for (double value : f(x[k], x[k + 1]))
        out.push_back(value);
    return out;
  }
  std::vector<double> noise() const
  {
    return field([k = 0](double, double) mutable { return std::array{std::sin(7.0 * ++k), std::cos(3.0 * k)}; });
  }
};

double largest(std::span<const double> values)
{
  double out = 0.0;
  for (double value : values)
    out = std::max(out, std::abs(value));
  return out;
}
} // namespace tie_test
using tie_test::largest;
using tie_test::SlitRing;
} // namespace

TEST_CASE("conditions of a tie: rigid motions have no jump, forces no sum and no moment")
{
  const SlitRing ring;
  const TieConditions tie = ring.conditions({.name = "slit"});
  REQUIRE(tie.num_nodes() == 5);
  CHECK(tie.num_free() == 0);
  CHECK(std::accumulate(tie.area().begin(), tie.area().end(), 0.0) == Approx(1.0).epsilon(1e-12));
  CHECK(largest(tie.offset()) < 1e-14);
  CHECK(largest(tie.jump(ring.field([](double, double) { return std::array{1.0, -2.0}; }))) < 1e-14);
  CHECK(largest(tie.jump(ring.field([](double x, double y) { return std::array{3.0 * x - y, x + 2.0 * y}; }))) < 1e-13);
  CHECK(largest(tie.jump(ring.noise())) > 0.1);
  std::vector<double> z(10);
  std::iota(z.begin(), z.end(), -3.0);
  const std::vector<double> f = tie.forces(z), x = ring.field([](double a, double b) { return std::array{a, b}; });
  double sum[2] = {}, moment = 0.0;
  for (std::size_t k = 0; k < f.size(); k += 2)
  {
    sum[0] += f[k];
    sum[1] += f[k + 1];
    moment += x[k] * f[k + 1] - x[k + 1] * f[k];
  }
  CHECK(largest(f) > 0.1);
  CHECK(std::abs(sum[0]) + std::abs(sum[1]) + std::abs(moment) < 1e-12);
}

TEST_CASE("components that are prescribed or held by another tie have no condition; constants stay in the space")
{
  const SlitRing ring;
  TieConditions tie = ring.conditions();
  std::vector<std::int8_t> taken(ring.size, 0);
  taken[2 * std::size_t(tie.nodes()[2]) + 1] = 1;
  tie.leave_out(taken);
  const Constraints& rows = tie.rows();
  CHECK(std::ranges::count(rows.constrained, 1) == 9);
  double cover[2] = {};
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (std::size_t d = 0; d < 2; ++d)
      cover[d] += tie.cover()[2 * k + d];
  CHECK(cover[0] == Approx(1.0).epsilon(1e-12));
  CHECK(cover[1] == Approx(1.0).epsilon(1e-12));
  const TieConditions normal = ring.conditions({.normal_only = true});
  CHECK(std::ranges::count(normal.rows().constrained, 1) == 5);
  CHECK(largest(normal.jump(ring.field([](double x, double y) { return std::array{x * x, y}; }))) < 1e-13);
}

TEST_CASE("the system of an explicit step: its solution, and rates that conditions allow")
{
  const SlitRing ring;
  const TieConditions tie = ring.conditions();
  std::vector<double> inverse_mass(ring.size);
  for (std::size_t k = 0; k < ring.size; ++k)
    inverse_mass[k] = 1.0 + 0.1 * double(k / 2 % 3);
  const std::size_t held = 2 * std::size_t(tie.slave().nodes[0]);
  inverse_mass[held] = 0.0;
  TieSystem system({&tie}, inverse_mass);
  REQUIRE(system.size() == 10);
  CHECK(system.num_blocks() == 2); // the axes; one of them has a support
  CHECK(system.num_factors() == 2);
  const TieSystem free({&tie}, std::vector<double>(ring.size, 2.0));
  CHECK(free.num_blocks() == 2);
  CHECK(free.num_factors() == 1);
  const TieConditions normal = ring.conditions({.normal_only = true});
  CHECK(TieSystem({&normal}, inverse_mass).num_blocks() == 1);
  const std::vector<double> v = ring.noise(), w = system.project(v);
  CHECK(system.largest_jump(v) > 0.1);
  CHECK(system.largest_jump(w) < 1e-13);
  CHECK(w[held] == v[held]);
  const std::vector<double> again = system.project(w);
  for (std::size_t k = 0; k < w.size(); ++k)
    CHECK(std::abs(again[k] - w[k]) < 1e-13);
  // S z = b with S = C M^-1 C^T.
  std::vector<double> b(10), z(10);
  std::iota(b.begin(), b.end(), -4.5);
  system.solve(b, z);
  std::vector<double> moved = tie.forces(z);
  for (std::size_t k = 0; k < moved.size(); ++k)
    moved[k] *= inverse_mass[k];
  const std::vector<double> jump = tie.jump(moved);
  for (std::size_t k = 0; k < 10; ++k)
    CHECK(tie.weight()[k] * jump[k] == Approx(b[k]).epsilon(1e-12));
}

TEST_CASE("a tie in Newton's method: its constraints close the jump, multipliers come from equilibrium and are kept")
{
  const SlitRing ring;
  Tie tie(ring.V, ring.slave, ring.master, {.name = "slit"}, std::vector<std::int8_t>(ring.size, 0));
  const std::vector<double> u = ring.noise();
  tie.begin_step(u, std::nullopt, {});
  tie.update_gap(u);
  const std::vector<double> jump = tie.conditions().jump(u);
  CHECK(tie.violation() * tie.conditions().size() == Approx(largest(jump)).epsilon(1e-14));
  CHECK_THAT(tie.largest_violation(), ContainsSubstring("slit: the surfaces are apart by"));
  CHECK(tie.update_active_set(true, std::nullopt) == 0);
  CHECK(tie.num_active() == 5);
  const Constraints rows = tie.constraints();
  for (std::size_t k = 0; k < jump.size(); ++k)
    CHECK(rows.known[k] == Approx(-jump[k]).epsilon(1e-14));
  std::vector<double> residual(ring.size, 0.0);
  for (std::int32_t node : tie.nodes())
    residual[2 * std::size_t(node) + 1] = 0.5;
  tie.update_multipliers(residual);
  const std::vector<double> forces = tie.contact_forces();
  for (std::int32_t node : tie.nodes())
    CHECK(forces[2 * std::size_t(node) + 1] == Approx(0.5).epsilon(1e-13));
  tie.accept_step();
  CHECK(tie.totals().force[1] == Approx(2.5).epsilon(1e-13));
  CHECK(tie.totals().area == Approx(1.0).epsilon(1e-12));
  const state::State saved = tie.saved_state();
  Tie other(ring.V, ring.slave, ring.master, {.name = "slit"}, std::vector<std::int8_t>(ring.size, 0));
  other.resume(saved, u);
  CHECK(other.traction() == tie.traction());
  CHECK(other.totals().force[1] == tie.totals().force[1]);
}

TEST_CASE("a tie refuses what does not fit")
{
  const SlitRing ring, half(0.5);
  CHECK_THROWS_WITH(half.conditions({.name = "half"}), ContainsSubstring("half: 1 of 5 slave nodes have no master"));
  const TieConditions partial = half.conditions({.partial = true});
  CHECK(partial.num_nodes() == 4);
  CHECK(partial.num_free() == 1);
  CHECK_THROWS_AS(TieConditions(ring.V, ring.slave, ring.master, {}, {}), std::invalid_argument);
  TieConditions tie = ring.conditions();
  CHECK_THROWS_AS(tie.leave_out(std::vector<std::int8_t>(3)), std::invalid_argument);
  CHECK_THROWS_AS(tie.jump(std::vector<double>(3)), std::invalid_argument);
  CHECK_THROWS_AS(tie.forces(std::vector<double>(3)), std::invalid_argument);
  CHECK_THROWS_AS(TieSystem({&tie}, std::vector<double>(3)), std::invalid_argument);
  const std::vector<std::int8_t> none(ring.size, 0);
  Tie one(ring.V, ring.slave, ring.master, {.name = "one"}, none),
      two(ring.V, ring.slave, ring.master, {.name = "two"}, none);
  Tie back(ring.V, ring.master, ring.slave, {.name = "back"}, none);
  CHECK_THROWS_WITH(connect(std::vector{&one, &two}, {}), ContainsSubstring("tie the same surfaces twice"));
  CHECK_THROWS_WITH(connect(std::vector{&one, &back}, {}), ContainsSubstring("the slave of each is the master"));
}

TEST_CASE("Cholesky factors of a sparse matrix: entries of longer vectors; a matrix that is not positive definite")
{
  Mat A = nullptr;
  REQUIRE(MatCreateSeqAIJ(PETSC_COMM_SELF, 3, 3, 3, nullptr, &A) == 0);
  for (PetscInt k = 0; k < 3; ++k)
    REQUIRE(MatSetValue(A, k, k, 4.0, INSERT_VALUES) == 0);
  for (const auto& [i, j] : {std::pair{0, 2}, {2, 0}})
    REQUIRE(MatSetValue(A, i, j, 1.0, INSERT_VALUES) == 0);
  REQUIRE(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY) == 0);
  REQUIRE(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY) == 0);
  operators::CholeskyFactors factors(A);
  const std::vector<PetscInt> places{0, 2, 4};
  const std::vector<double> b{6.0, -1.0, 8.0, -1.0, 9.0};
  std::vector<double> x(5, 0.0);
  factors.solve(places, b, x);
  CHECK(x[0] == Approx(1.0).epsilon(1e-15));
  CHECK(x[2] == Approx(2.0).epsilon(1e-15));
  CHECK(x[4] == Approx(2.0).epsilon(1e-15));
  CHECK(x[1] == 0.0);
  REQUIRE(MatSetValue(A, 1, 1, 0.0, INSERT_VALUES) == 0);
  REQUIRE(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY) == 0);
  REQUIRE(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY) == 0);
  CHECK_THROWS_WITH(operators::CholeskyFactors(A), ContainsSubstring("not positive definite"));
  REQUIRE(MatDestroy(&A) == 0);
}
