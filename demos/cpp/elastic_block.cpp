// SPDX-License-Identifier: MIT
// An elastic block without Python: kernels from the package's table, the force f(u) without a matrix, the tangent K in
// a PETSc matrix, and the check that K u = f(u). Runs on any number of ranks.
#include <basix/finite-element.h>
#include <cmath>
#include <cstdio>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/la/Vector.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/kernels/KernelTable.h>
#include <dolfinx_impact/operators/InternalForce.h>
#include <dolfinx_impact/operators/KernelTangent.h>
#include <exception>
#include <memory>
#include <numeric>
#include <petscmat.h>
#include <spdlog/spdlog.h>
#include <vector>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
/// The integrals of a form of the table over all cells of this rank.
std::vector<operators::Integral> over_all_cells(const kernels::Key& key, const mesh::Mesh<double>& mesh,
                                                const std::vector<double>& constants)
{
  std::vector<std::int32_t> cells(mesh.topology()->index_map(3)->size_local());
  std::iota(cells.begin(), cells.end(), 0);
  std::vector<operators::Integral> integrals;
  for (const impact_kernel* kernel : kernels::find(key))
    integrals.push_back({kernel, cells, constants});
  return integrals;
}

/// Norm of K u - f over the norm of f.
double difference(Mat K, const fem::Function<double>& u, const la::Vector<double>& f)
{
  const auto map = u.function_space()->dofmap()->index_map;
  const int size = 3 * map->size_local();
  Vec x, b, y;
  VecCreateMPIWithArray(PETSC_COMM_WORLD, 1, size, PETSC_DETERMINE, u.x()->array().data(), &x);
  VecCreateMPIWithArray(PETSC_COMM_WORLD, 1, size, PETSC_DETERMINE, f.array().data(), &b);
  VecDuplicate(b, &y);
  MatMult(K, x, y);
  VecAXPY(y, -1.0, b);
  double error = 0.0, scale = 0.0;
  VecNorm(y, NORM_2, &error);
  VecNorm(b, NORM_2, &scale);
  for (Vec* v : {&x, &b, &y})
    VecDestroy(v);
  return error / scale;
}

bool run()
{
  auto mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_box<double>(
      MPI_COMM_WORLD, {{{0.0, 0.0, 0.0}, {2.0, 1.0, 1.0}}}, {5, 3, 3}, mesh::CellType::hexahedron));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::hexahedron, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  auto V = std::make_shared<fem::FunctionSpace<double>>(fem::create_functionspace(mesh, element, {3}));

  auto u = std::make_shared<fem::Function<double>>(V);
  u->interpolate(
      [](auto x) -> std::pair<std::vector<double>, std::vector<std::size_t>>
      {
        const std::size_t n = x.extent(1);
        std::vector<double> values(3 * n);
        for (std::size_t p = 0; p < n; ++p)
        {
          values[p] = 1e-3 * std::sin(2 * x(0, p));
          values[n + p] = 1e-3 * x(0, p) * x(1, p);
          values[2 * n + p] = 1e-3 * std::cos(x(2, p));
        }
        return {values, {3, n}};
      });
  u->x()->scatter_fwd();

  // Constants in the order of the kernel's description: Young's modulus [Pa] and Poisson's ratio [1] of steel.
  const std::vector<double> steel{207e9, 0.3};
  const auto force = over_all_cells({.name = "linear_elastic.force", .cell = "hexahedron"}, *mesh, steel);
  const operators::InternalForce internal_force(mesh, V, force, {{"u", u}});
  la::Vector<double> f(V->dofmap()->index_map, V->dofmap()->index_map_bs());
  internal_force.apply(f);

  const auto stiffness = over_all_cells({.name = "linear_elastic.tangent", .cell = "hexahedron"}, *mesh, steel);
  operators::KernelTangent tangent({V, V}, stiffness, {});
  tangent.assemble();
  const double error = difference(tangent.matrix(), *u, f);

  // A kernel refuses a mesh that it was not compiled for.
  bool refused = false;
  try
  {
    const auto other = over_all_cells({.name = "linear_elastic.force", .cell = "tetrahedron"}, *mesh, steel);
    operators::InternalForce(mesh, V, other, {{"u", u}});
  }
  catch (const std::runtime_error& e)
  {
    refused = std::string(e.what()).find("tetrahedron") != std::string::npos;
  }
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0)
  {
    std::printf("cells per kernel call: %d\n", internal_force.width());
    std::printf("|K u - f(u)| / |f(u)| = %.2e\n", error);
    std::printf("a kernel for tetrahedra on hexahedra: %s\n", refused ? "refused" : "taken");
  }
  return error < 1e-12 && refused; // some hundred roundings of 1e-16 per entry
}
} // namespace

int main(int argc, char* argv[])
{
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  spdlog::set_level(spdlog::level::warn); // DOLFINx tells every step otherwise
  bool passed = false;
  try
  {
    passed = run();
  }
  catch (const std::exception& e)
  {
    std::fprintf(stderr, "elastic_block: %s\n", e.what());
  }
  PetscFinalize();
  return passed ? 0 : 1;
}
