// SPDX-License-Identifier: MIT
// A steel block without Python, clamped at one end and pulled at the other: a static problem with the package's own
// kernels. Runs on any number of ranks. A mesh that the kernels were not compiled for is refused.
#include "demo.h"
#include <basix/finite-element.h>
#include <cmath>
#include <cstdio>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/problems/KernelBody.h>
#include <dolfinx_impact/problems/StaticProblem.h>
#include <memory>
#include <string>
#include <vector>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
constexpr double E = 207e9, nu = 0.0,
                 length = 2.0;      // [Pa], [1]: no contraction, so that the clamp disturbs nothing; [m]
constexpr double elongation = 1e-3; // [m]

/// Displacements on a box of these cells, of degree 1.
std::shared_ptr<fem::Function<double>> displacement(mesh::CellType cell, int degree)
{
  auto mesh = std::make_shared<mesh::Mesh<double>>(
      mesh::create_box<double>(MPI_COMM_WORLD, {{{0.0, 0.0, 0.0}, {length, 1.0, 1.0}}}, {5, 3, 3}, cell));
  const auto element = basix::create_element<double>(basix::element::family::P, mesh::cell_type_to_basix_type(cell),
                                                     degree, basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  return std::make_shared<fem::Function<double>>(
      std::make_shared<fem::FunctionSpace<double>>(create_functionspace(mesh, element, {3})));
}

/// Nodes at a position along the block.
std::vector<std::int32_t> nodes_at(const fem::FunctionSpace<double>& V, double x0)
{
  return fem::locate_dofs_geometrical(V,
                                      [x0](auto x)
                                      {
                                        std::vector<std::int8_t> marked(x.extent(1));
                                        for (std::size_t p = 0; p < marked.size(); ++p)
                                          marked[p] = std::abs(x(0, p) - x0) < 1e-9;
                                        return marked;
                                      });
}

bool run()
{
  const problems::KernelMaterial steel{"linear_elastic", {{"E", {E}}, {"nu", {nu}}}};
  const auto u = displacement(mesh::CellType::hexahedron, 1);
  const auto V = u->function_space();
  const auto clamped = std::make_shared<fem::Constant<double>>(std::vector<double>{0.0, 0.0, 0.0});
  const auto pulled = std::make_shared<fem::Constant<double>>(std::vector<double>{elongation, 0.0, 0.0});
  const problems::BoundaryConditions bcs{std::make_shared<fem::DirichletBC<double>>(clamped, nodes_at(*V, 0.0), V),
                                         std::make_shared<fem::DirichletBC<double>>(pulled, nodes_at(*V, length), V)};
  const auto body = std::make_shared<problems::KernelBody>(u, steel);
  problems::StaticProblem problem(u, body, bcs);
  const solve::LoadStepReport report = problem.solve();
  // Of a linear material half the work of the force: E A elongation^2 / (2 length), with the area 1.
  const double energy = body->stored_energy().value(), exact = 0.5 * E * elongation * elongation / length;

  bool refused = false;
  try
  {
    problems::KernelBody(displacement(mesh::CellType::hexahedron, 3), steel);
  }
  catch (const std::runtime_error& e)
  {
    refused = std::string(e.what()).find("degree 3") != std::string::npos;
  }
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0)
  {
    std::printf("cells per kernel call: %d\n", body->forces().front().force->width());
    std::printf("iterations: %d\n", report.iterations[0]);
    std::printf("stored energy / exact = %.12f\n", energy / exact);
    std::printf("kernels for degree 3: %s\n", refused ? "refused" : "found");
  }
  return std::abs(energy / exact - 1.0) < 1e-9 && refused; // Newton's tolerance is 1e-10 of the force
}
} // namespace

int main(int argc, char* argv[])
{
  return run_demo(argc, argv, "elastic_block", run);
}
