// SPDX-License-Identifier: MIT
// ForceTerm: a form's force in the residual, and its work. The form is that of an elastic square in uniaxial strain.
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/integrators/ForceTerm.h>
#include <dolfinx_impact/kernels/KernelTable.h>
#include <stdexcept>

using Catch::Approx;
using namespace dolfinx_impact;
using namespace dolfinx_impact::integrators;

namespace
{
/// The unit square in two cells, one of the early and one of the outer operator; E = 3, nu = 0.
struct Square
{
  static constexpr double young = 3.0;

  Square()
  {
    mesh = std::make_shared<dolfinx::mesh::Mesh<double>>(dolfinx::mesh::create_rectangle<double>(
        MPI_COMM_SELF, {{{0.0, 0.0}, {1.0, 1.0}}}, {2, 1}, dolfinx::mesh::CellType::quadrilateral));
    const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                       basix::element::lagrange_variant::gll_warped,
                                                       basix::element::dpc_variant::unset, false);
    V = std::make_shared<dolfinx::fem::FunctionSpace<double>>(
        dolfinx_impact::common::create_functionspace(mesh, element, {2}));
    u = std::make_shared<dolfinx::fem::Function<double>>(V);
    x = V->tabulate_dof_coordinates(false);
  }

  std::shared_ptr<InternalForce> operation(std::int32_t cell) const { return on_cells({cell}); }
  std::shared_ptr<InternalForce> on_cells(std::vector<std::int32_t> cells) const
  {
    const impact_kernel* kernel =
        kernels::find({.name = "linear_elastic.force", .cell = "quadrilateral", .hypothesis = "plane_strain"}).at(0);
    std::vector<operators::Integral> integrals{{kernel, std::move(cells), {young, 0.0}}};
    return std::make_shared<InternalForce>(mesh, V, integrals,
                                           std::map<std::string, std::shared_ptr<const operators::Function>>{{"u", u}});
  }
  FormForces forms() const { return {operation(0), operation(1), on_cells({}), "u", ""}; }

  /// Fields with a displacement and a velocity in x that grow linearly with x.
  NodalFields fields(double strain, double rate) const
  {
    NodalFields fields(V->dofmap()->index_map, 2);
    stretch(fields, strain, rate);
    return fields;
  }
  void stretch(NodalFields& fields, double strain, double rate) const
  {
    for (std::size_t node = 0; node < x.size() / 3; ++node)
    {
      fields.u[2 * node] = strain * x[3 * node];
      fields.v[2 * node] = rate * x[3 * node];
    }
  }

  std::shared_ptr<dolfinx::mesh::Mesh<double>> mesh;
  std::shared_ptr<dolfinx::fem::FunctionSpace<double>> V;
  std::shared_ptr<dolfinx::fem::Function<double>> u; ///< stays zero: the term reads the fields
  std::vector<double> x;                             ///< three coordinates of each node
};
} // namespace

TEST_CASE("sums of products take what four sums leave over")
{
  const double a[] = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0}, b[] = {1.0, -1.0, 2.0, 0.5, 3.0, 0.0, 10.0};
  CHECK(sum_of_products(7, a, b) == 92.0);
  CHECK(sum_of_products(3, a, b) == 5.0);
  CHECK(sum_of_products(0, a, b) == 0.0);
}

TEST_CASE("a force term adds the force of its form to the residual")
{
  const Square square;
  const double strain = 0.01, stress = Square::young * strain;
  NodalFields fields = square.fields(strain, 0.0);
  const bool external = GENERATE(false, true);
  const double sign = external ? -1.0 : 1.0; // loads have the other sign there
  ForceTerm term(square.forms(), external ? WorkKind::external : WorkKind::viscosity, fields);
  for (double& r : fields.r)
    r = 100.0;
  term.evaluate(fields, 0.1);
  for (std::size_t node = 0; node < square.x.size() / 3; ++node)
  {
    // Half of the stress on each of the two nodes of an end; both cells cancel in the middle.
    const double at = square.x[3 * node], force = at > 0.75 ? 0.5 * stress : at < 0.25 ? -0.5 * stress : 0.0;
    CHECK(fields.r[2 * node] == Approx(100.0 + sign * force).epsilon(1e-14));
    CHECK(fields.r[2 * node + 1] == Approx(100.0).epsilon(1e-14));
  }
  CHECK(term.position() == Approx(stress * strain).epsilon(1e-12));
  CHECK(term.signed_position() == Approx(sign * stress * strain).epsilon(1e-12));
  CHECK(term.work.value() == 0.0); // nothing moves
}

TEST_CASE("the work of a force term is that of the trapezoidal rule")
{
  // Two steps of a strain that grows: the force is linear in it, so that the rule is exact up to the ends.
  const Square square;
  const double dt = 0.5, rate = 0.2, E = Square::young;
  NodalFields fields = square.fields(0.0, rate);
  ForceTerm term(square.forms(), WorkKind::damping, fields);
  CHECK(term.kind() == WorkKind::damping);
  term.evaluate(fields, 0.0);
  double expected = 0.0;
  for (int step = 1; step <= 2; ++step)
  {
    const double before = rate * dt * (step - 1), now = rate * dt * step;
    square.stretch(fields, now, rate);
    term.work_of_step(fields, dt);
    term.evaluate(fields, dt);
    expected += 0.5 * E * (before + now) * rate * dt;
    CHECK(term.work.value() == Approx(expected).epsilon(1e-12));
    term.work.commit(0.0);
  }
  CHECK(expected == Approx(0.5 * E * std::pow(2 * rate * dt, 2)).epsilon(1e-12));
  SECTION("another term goes on from what was saved")
  {
    ForceTerm other(square.forms(), WorkKind::damping, fields);
    other.restore(fields, term.saved_force(fields), term.work, term.position());
    CHECK(other.position() == term.position());
    term.work_of_step(fields, dt);
    other.work_of_step(fields, dt);
    CHECK(other.work.value() == term.work.value());
    CHECK(other.work.value() > expected);
  }
  SECTION("a start is from zero")
  {
    term.reset();
    CHECK(term.work.value() == 0.0);
    term.work_of_step(fields, dt);
    CHECK(term.work.value() == 0.0); // no force is left either
  }
}

TEST_CASE("a force term refuses what it cannot evaluate")
{
  const Square square;
  const NodalFields fields = square.fields(0.0, 0.0);
  const auto term = [&](FormForces forms, WorkKind kind) { return ForceTerm(std::move(forms), kind, fields); };
  CHECK_THROWS_AS(term(square.forms(), WorkKind::contact), std::invalid_argument);
  const auto refused = [&](auto change)
  {
    FormForces forms = square.forms();
    change(forms);
    CHECK_THROWS_AS(term(forms, WorkKind::damping), std::invalid_argument);
  };
  refused([](FormForces& forms) { forms.early = nullptr; });
  refused([](FormForces& forms) { forms.outer = nullptr; });
  refused([](FormForces& forms) { forms.late = nullptr; });
  refused([](FormForces& forms) { forms.displacement = "w"; });
  refused([](FormForces& forms) { forms.velocity = "w"; });
}
