// SPDX-License-Identifier: MIT
// An elastic wheel rolls on a rigid rail, without Python: freely, by a torque of zero; then with a creepage at which
// all of the contact slips. The mesh stands still, the material flows through it. Runs on any number of ranks.
#include "demo.h"
#include <basix/finite-element.h>
#include <cmath>
#include <dolfinx_impact/problems/KernelBody.h>
#include <dolfinx_impact/problems/RollingProblem.h>
#include <dolfinx_impact/problems/SpinningBody.h>
#include <numeric>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
constexpr double E = 1000.0, nu = 0.3, density = 1.0, friction = 0.3, inner = 0.5, outer = 1.0, speed = 1.0,
                 down = 5e-3;
constexpr int around = 256, across = 8;

/// A ring of quadrilaterals about the origin.
std::shared_ptr<mesh::Mesh<double>> wheel()
{
  std::vector<double> x;
  std::vector<std::int64_t> cells;
  for (int i = 0; i < around && dolfinx::MPI::rank(MPI_COMM_WORLD) == 0; ++i)
    for (int j = 0; j <= across; ++j)
    {
      const double angle = 2.0 * M_PI * i / around, r = inner + (outer - inner) * j / across;
      x.insert(x.end(), {r * std::cos(angle), r * std::sin(angle)});
      const std::int64_t node = i * (across + 1) + j, next = (i + 1) % around * (across + 1) + j;
      if (j < across)
        cells.insert(cells.end(), {node, node + 1, next, next + 1});
    }
  const fem::CoordinateElement<double> element(mesh::CellType::quadrilateral, 1);
  return std::make_shared<mesh::Mesh<double>>(
      mesh::create_mesh(MPI_COMM_WORLD, cells, element, x, {x.size() / 2, 2}, mesh::GhostMode::shared_facet));
}

/// Marks points at a distance from the axis; of the outer ones those near the rail.
auto at_radius(double r)
{
  return [r](auto x)
  {
    std::vector<std::int8_t> marked(x.extent(1));
    for (std::size_t p = 0; p < marked.size(); ++p)
      marked[p] = std::abs(std::hypot(x(0, p), x(1, p)) - r) < 1e-9 && (r < outer || x(1, p) < -0.9);
    return marked;
  };
}

bool run()
{
  const auto mesh = wheel();
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  auto V = std::make_shared<fem::FunctionSpace<double>>(create_functionspace(mesh, element, {2}));
  auto u = std::make_shared<fem::Function<double>>(V);
  const auto hub = std::make_shared<fem::Constant<double>>(std::vector{0.0, -down}, std::vector{std::size_t(2)});
  const problems::BoundaryConditions bcs{
      std::make_shared<fem::DirichletBC<double>>(hub, fem::locate_dofs_geometrical(*V, at_radius(inner)), V)};
  const auto omega = std::make_shared<fem::Constant<double>>(speed / outer);
  const std::size_t num_nodes = V->dofmap()->index_map->size_local() + V->dofmap()->index_map->num_ghosts();
  rolling::Motion spin{rolling::Spin(), omega, std::vector<std::int32_t>(num_nodes)};
  std::iota(spin.nodes.begin(), spin.nodes.end(), 0);
  const auto flow = std::make_shared<rolling::Flow>(V, std::vector{spin});
  std::vector<std::int32_t> cells(mesh->topology()->index_map(2)->size_local());
  std::iota(cells.begin(), cells.end(), 0);
  const problems::KernelMaterial steel{"linear_elastic", {{"E", {E}}, {"nu", {nu}}}, "plane_strain"};
  const auto body = std::make_shared<problems::SpinningBody>(u, std::make_shared<problems::KernelBody>(u, steel), spin,
                                                             problems::SpinningMaterial{density, cells});
  const auto tread = surface::make_surface(*V, mesh::locate_entities_boundary(*mesh, 1, at_radius(outer)));
  const auto rail = std::make_shared<const gap::Rigid>(
      gap::Rigid{.kind = gap::Rigid::Kind::plane, .gdim = 2, .point = {0, -outer, 0}, .direction = {0, 1, 0}});
  const auto contact = std::make_shared<rolling::RollingContact>(
      V, tread, rail, enforcement::MortarOptions{.name = "wheel on rail", .friction = friction},
      problems::prescribed_dofs(*V, bcs), flow);
  contact->obstacle_velocity() = {speed, 0.0, 0.0};
  const std::vector<std::shared_ptr<enforcement::StaticContact>> contacts{contact};
  problems::RollingProblem problem(std::make_shared<problems::StaticProblem>(u, body, bcs, contacts), flow);
  problem.solve({}, {}, 0.0);
  const double free = omega->value[0] * outer / speed, torque = problem.torque(flow->motions()[0]);
  omega->value[0] *= 1.05; // a creepage of 5 %
  problem.solve();
  const std::array<double, 3> force = contact->totals().force;
  const problems::PowerBalance power = problem.power_balance();
  const double slips = std::abs(force[0]) / (friction * force[1]);
  PetscPrintf(MPI_COMM_WORLD, "free rolling: omega R / V = %.6f\nslipping: force / (friction * pressure) = %.9f\n",
              free, slips);
  return std::abs(torque) < 1e-8 * force[1] && std::abs(free - 1.0) < 0.01 && std::abs(slips - 1.0) < 1e-8 &&
         std::abs(power.driving - power.friction - power.rolling) < 1e-8 * power.driving;
}
} // namespace

int main(int argc, char* argv[])
{
  return run_demo(argc, argv, "rolling_wheel", run);
}
