// SPDX-License-Identifier: MIT
// Hertz's line contact of two elastic blocks by dual Lagrange multipliers, without Python. Runs on any number of ranks.
#include "demo.h"
#include <algorithm>
#include <basix/finite-element.h>
#include <cmath>
#include <dolfinx_impact/enforcement/mortar/MortarContact.h>
#include <dolfinx_impact/problems/KernelBody.h>
#include <dolfinx_impact/problems/StaticProblem.h>
#include <dolfinx_impact/surface/Surface.h>
#include <numeric>
#include <petscsys.h>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
constexpr double E = 1000.0, nu = 0.3, radius = 50.0, size = 10.0, down = 0.03; // size: height and half width
constexpr int num = 48;                                                         // cells along half of the width

/// Two blocks of quadrilaterals, fine where they touch. The upper one's surface is y = x^2/(2 radius).
std::shared_ptr<mesh::Mesh<double>> blocks()
{
  std::vector<double> x;
  std::vector<std::int64_t> cells;
  const auto graded = [](double s) { return size * (0.15 * s + 0.85 * s * s * s * s * s); };
  for (int body = 0; body < 2 && dolfinx::MPI::rank(MPI_COMM_WORLD) == 0; ++body)
    for (int j = 0; j <= num; ++j)
      for (int i = 0; i <= 2 * num; ++i)
      {
        const double t = graded(double(j) / num), px = graded(double(i - num) / num);
        const std::int64_t node = x.size() / 2, row = 2 * num + 1;
        x.insert(x.end(), {px, body ? t + (1.0 - t / size) * px * px / (2 * radius) : -graded(1.0 - double(j) / num)});
        if (i < 2 * num && j < num)
          cells.insert(cells.end(), {node, node + 1, node + row, node + row + 1});
      }
  const fem::CoordinateElement<double> element(mesh::CellType::quadrilateral, 1);
  return std::make_shared<mesh::Mesh<double>>(
      mesh::create_mesh(MPI_COMM_WORLD, cells, element, x, {x.size() / 2, 2}, mesh::GhostMode::shared_facet));
}

/// Marks points whose coordinates a function maps to zero.
auto where(auto f)
{
  return [f](auto x)
  {
    std::vector<std::int8_t> marked(x.extent(1));
    for (std::size_t p = 0; p < marked.size(); ++p)
      marked[p] = std::abs(f(x(0, p), x(1, p))) < 1e-9;
    return marked;
  };
}

bool run()
{
  const auto mesh = blocks();
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  auto V = std::make_shared<fem::FunctionSpace<double>>(create_functionspace(mesh, element, {2}));
  auto u = std::make_shared<fem::Function<double>>(V);
  const problems::KernelMaterial steel{"linear_elastic", {{"E", {E}}, {"nu", {nu}}}, "plane_strain"};

  // Nothing moves below; the top is moved down.
  problems::BoundaryConditions bcs;
  for (double end : {-size, size})
  {
    auto nodes = fem::locate_dofs_geometrical(*V, where([=](double, double y) { return y - end; }));
    const std::vector<double> moved{0.0, end > 0.0 ? -down : 0.0};
    bcs.push_back(std::make_shared<fem::DirichletBC<double>>(
        std::make_shared<fem::Constant<double>>(moved, std::vector<std::size_t>{2}), std::move(nodes), V));
  }

  // The round surface is the slave.
  const auto facets = [&](auto f) { return mesh::locate_entities_boundary(*mesh, 1, where(f)); };
  const auto slave = surface::make_surface(*V, facets([](double x, double y) { return y - x * x / (2 * radius); }));
  const auto master = surface::make_surface(*V, facets([](double, double y) { return y; }));
  auto contact = std::make_shared<enforcement::MortarContact>(
      V, slave, master, enforcement::MortarOptions{.name = "blocks"}, problems::prescribed_dofs(*V, bcs));

  problems::StaticProblem problem(u, std::make_shared<problems::KernelBody>(u, steel), bcs, {contact});
  const solve::LoadStepReport report = problem.solve();

  const std::vector<double> nodal = contact->contact_forces(), p = contact->pressure();
  const double force = contact->totals().force[1]; // on the upper block
  double peak = p.empty() ? 0.0 : std::ranges::max(p), sum = std::accumulate(nodal.begin(), nodal.end(), 0.0);
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD); // on both bodies: zero
  MPI_Allreduce(MPI_IN_PLACE, &peak, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  const double exact = std::sqrt(force * E / (2.0 * (1.0 - nu * nu) * M_PI * radius)); // of both bodies together
  PetscPrintf(MPI_COMM_WORLD, "force %.6f\npeak pressure / Hertz = %.4f\n", force, peak / exact);
  return report.converged && std::abs(peak / exact - 1.0) < 0.01 && std::abs(sum) < 1e-10 * force;
}
} // namespace

int main(int argc, char* argv[])
{
  return run_demo(argc, argv, "hertz_multipliers", run);
}
