// SPDX-License-Identifier: MIT
// A law of one's own: the kernels of foam.py, which `dolfinx-impact compile` writes when this program is built. A block
// of foam is stretched to one and a half of its length, its sides are free; closed forms give its force, its energy and
// its stress. Runs on any number of ranks, without Python.
#include "demo.h"
#include "foam.h"
#include <basix/finite-element.h>
#include <cmath>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/dolfinx_api.h>
#include <dolfinx_impact/kernels/KernelTable.h>
#include <dolfinx_impact/kernels/constants.h>
#include <dolfinx_impact/operators/InternalForce.h>
#include <dolfinx_impact/problems/KernelBody.h>
#include <dolfinx_impact/problems/StaticProblem.h>
#include <numeric>
#include <petscsys.h>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
constexpr double stretch = 1.5; // length after over length before [1]

/// The integrals of a kernel of the foam over cells.
std::vector<operators::Integral> integrals(const std::string& name, const std::vector<std::int32_t>& cells)
{
  const impact_kernel* kernel = kernels::find({.name = name, .cell = "hexahedron"}).at(0);
  return {{kernel, cells, kernels::constants(*kernel, foam::constants())}};
}

bool run()
{
  kernels::add(foam::kernels());
  auto mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_box<double>(
      MPI_COMM_WORLD, {{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}}}, {4, 3, 3}, mesh::CellType::hexahedron));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::hexahedron, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  auto V = std::make_shared<fem::FunctionSpace<double>>(create_functionspace(mesh, element, {3}));
  std::vector<std::int32_t> cells(mesh->topology()->index_map(3)->size_local());
  std::iota(cells.begin(), cells.end(), 0);

  // Three faces are planes of symmetry, the end x = 1 is moved.
  auto u = std::make_shared<fem::Function<double>>(V);
  problems::BoundaryConditions bcs;
  for (auto [axis, place] : {std::pair{0, 0.0}, {0, 1.0}, {1, 0.0}, {2, 0.0}})
  {
    const auto face = mesh::locate_entities_boundary(*mesh, 2,
                                                     [&](auto x)
                                                     {
                                                       std::vector<std::int8_t> marked(x.extent(1));
                                                       for (std::size_t p = 0; p < marked.size(); ++p)
                                                         marked[p] = std::abs(x(axis, p) - place) < 1e-9;
                                                       return marked;
                                                     });
    auto W = std::make_shared<fem::FunctionSpace<double>>(V->sub({axis}));
    const auto dofs = fem::locate_dofs_topological(*mesh->topology_mutable(), *W->dofmap(), 2, face);
    bcs.push_back(std::make_shared<fem::DirichletBC<double>>(place > 0.0 ? stretch - 1.0 : 0.0, dofs, W));
  }

  const problems::KernelMaterial material{"foam", foam::constants()};
  problems::StaticProblem problem(u, std::make_shared<problems::KernelBody>(u, material), bcs);
  const bool converged = problem.solve({.steps = 4, .rtol = 1e-13}).converged;

  const operators::InternalForce force(mesh, V, integrals("foam.force", cells), {{"u", u}});
  la::Vector<double> f(V->dofmap()->index_map, 3);
  double pulls[2] = {}; // of both ends
  force.apply(f);
  for (int end = 0; end < 2; ++end)
    for (auto dofs = bcs[end]->dof_indices(); std::int32_t dof : dofs.first.first(dofs.second))
      pulls[end] += f.array()[dof];

  const operators::InternalForce energy(mesh, nullptr, integrals("foam.energy", cells), {{"u", u}});
  operators::InternalForce stress(mesh, V, integrals("foam.stress", cells), {{"u", u}});
  stress.assemble(dolfinx_impact::common::array(f));
  const auto& points = *stress.history(0);
  const std::vector<double> components = points.values(points.find("stress"), true); // xx, yy, zz, xy, yz, xz
  double sums[3] = {pulls[1], energy.value(), pulls[0] + pulls[1]}, axial = components.empty() ? 0.0 : components[0];
  MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  MPI_Allreduce(MPI_IN_PLACE, &axial, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  const double mu = foam::constants().at("mu")[0], side = std::pow(stretch, -0.25), volume = stretch * side * side;
  const double pull = mu * (std::pow(stretch, -0.5) - std::pow(stretch, -3.0));
  const double stored = mu / 2.0 * (std::pow(stretch, -2.0) + 2.0 / (side * side) + 2.0 * volume - 5.0);
  PetscPrintf(MPI_COMM_WORLD, "cells per kernel call: %d\nforce / exact = %.14f\nenergy / exact = %.14f\n",
              force.width(), sums[0] / pull, sums[1] / stored);
  PetscPrintf(MPI_COMM_WORLD, "stress / exact = %.14f\n", axial / (pull / (side * side)));
  return converged && std::abs(sums[0] / pull - 1.0) < 1e-12 && std::abs(sums[1] / stored - 1.0) < 1e-12 &&
         std::abs(axial * side * side / pull - 1.0) < 1e-12 && std::abs(sums[2]) < 1e-12 * pull;
}
} // namespace

int main(int argc, char* argv[])
{
  return run_demo(argc, argv, "own_law", run);
}
