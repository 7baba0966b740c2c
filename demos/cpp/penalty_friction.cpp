// SPDX-License-Identifier: MIT
// A block is pressed on a rigid plane and dragged along it: Newton's method with penalty contact and Coulomb friction,
// residual and tangent added to PETSc's objects, without Python. Pressed, the force is that of two springs in series;
// dragged, friction is the coefficient times the normal force. Runs on any number of ranks.
#include <basix/finite-element.h>
#include <basix/quadrature.h>
#include <cmath>
#include <cstdio>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/enforcement/penalty/QuadraturePenalty.h>
#include <dolfinx_impact/kernels/KernelTable.h>
#include <dolfinx_impact/operators/Tangent.h>
#include <dolfinx_impact/surface/Surface.h>
#include <numeric>
#include <petscksp.h>
#include <spdlog/spdlog.h>
#include <vector>

using namespace dolfinx;
using namespace dolfinx_impact;

namespace
{
constexpr double E = 1000.0, nu = 0.0, friction = 0.3, penalty = 1e5, width = 2.0, height = 1.0, pressed = 0.01;

/// Marks points at a height.
auto at_height(double y)
{
  return [y](auto x)
  {
    std::vector<std::int8_t> marked(x.extent(1));
    for (std::size_t p = 0; p < marked.size(); ++p)
      marked[p] = std::abs(x(1, p) - y) < 1e-9;
    return marked;
  };
}

/// J du = -R with the rows of prescribed degrees of freedom replaced by du = jump. @returns du
std::vector<double> solve(Mat J, Vec R, const std::vector<PetscInt>& prescribed, const std::vector<double>& jump)
{
  Vec du;
  VecDuplicate(R, &du);
  VecSet(du, 0.0);
  VecSetValues(du, PetscInt(prescribed.size()), prescribed.data(), jump.data(), INSERT_VALUES);
  VecAssemblyBegin(du);
  VecAssemblyEnd(du);
  VecScale(R, -1.0);
  MatZeroRowsColumns(J, PetscInt(prescribed.size()), prescribed.data(), 1.0, du, R);
  KSP ksp;
  KSPCreate(PETSC_COMM_WORLD, &ksp);
  KSPSetOperators(ksp, J, J);
  KSPSetType(ksp, KSPPREONLY);
  PC pc;
  KSPGetPC(ksp, &pc);
  PCSetType(pc, PCLU);
  PCFactorSetMatSolverType(pc, MATSOLVERMUMPS);
  KSPSolve(ksp, R, du);
  const double* values;
  PetscInt size;
  VecGetLocalSize(du, &size);
  VecGetArrayRead(du, &values);
  std::vector<double> out(values, values + size);
  VecRestoreArrayRead(du, &values);
  KSPDestroy(&ksp);
  VecDestroy(&du);
  return out;
}

bool run()
{
  auto mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_rectangle<double>(
      MPI_COMM_WORLD, {{{0.0, 0.0}, {width, height}}}, {12, 6}, mesh::CellType::quadrilateral));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::quadrilateral, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  auto V = std::make_shared<fem::FunctionSpace<double>>(fem::create_functionspace(mesh, element, {2}));
  const auto map = V->dofmap()->index_map;
  std::vector<std::int32_t> cells(mesh->topology()->index_map(2)->size_local());
  std::iota(cells.begin(), cells.end(), 0);
  const auto kernel =
      kernels::find({.name = "linear_elastic.tangent", .cell = "quadrilateral", .hypothesis = "plane_strain"});
  operators::Tangent bodies({V, V}, {{kernel.at(0), cells, {E, nu}}}, {});
  bodies.assemble();

  const auto bottom = mesh::locate_entities_boundary(*mesh, 1, at_height(0.0));
  const auto rule = basix::quadrature::make_quadrature<double>(
      basix::quadrature::type::Default, basix::cell::type::interval, basix::polyset::type::standard, 4);
  const gap::Rigid plane{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0, 1, 0}};
  enforcement::QuadraturePenalty contact({V, surface::make_surface(*V, bottom), rule[0], rule[1]},
                                         std::make_shared<gap::Rigid>(plane));
  contact.parameters = {.normal = penalty, .tangential = penalty, .friction = friction};

  std::vector<PetscInt> prescribed; // components of the top's nodes, in turn
  for (std::int32_t node : fem::locate_dofs_geometrical(*V, at_height(height)))
    for (int c = 0; c < 2 && node < map->size_local(); ++c)
      prescribed.push_back(2 * (map->local_range()[0] + node) + c);

  la::Vector<double> u(map, 2);
  u.set(0.0);
  Vec x, R;
  VecCreateMPIWithArray(PETSC_COMM_WORLD, 2, 2 * map->size_local(), PETSC_DETERMINE, u.array().data(), &x);
  VecDuplicate(x, &R);
  double force[2][2] = {}; // of both steps
  bool converged = true;
  for (int step = 0; step < 2; ++step)
  {
    const std::vector<double> start(u.array().begin(), u.array().end());
    const double reached[2] = {step ? 0.5 * height : 0.0, -pressed}; // of the top
    double norm = 0.0;
    for (int iteration = 0; iteration < 20; ++iteration)
    {
      std::vector<double> increment(start.size());
      std::transform(u.array().begin(), u.array().end(), start.begin(), increment.begin(), std::minus<double>());
      contact.update_gap(u.array(), start, iteration > 0);
      contact.evaluate(increment);
      MatMult(bodies.matrix(), x, R);
      contact.add_residual(R);
      std::vector<double> jump;
      for (std::size_t i = 0; i < prescribed.size(); ++i)
        jump.push_back(reached[i % 2] - u.array()[prescribed[i] - 2 * map->local_range()[0]]);
      Mat J;
      MatDuplicate(bodies.matrix(), MAT_COPY_VALUES, &J);
      MatAXPY(J, 1.0, contact.tangent(), DIFFERENT_NONZERO_PATTERN);
      const std::vector<double> du = solve(J, R, prescribed, jump);
      MatDestroy(&J);
      norm = 0.0;
      for (std::size_t i = 0; i < du.size(); ++i)
        norm = std::max(norm, std::abs(du[i]));
      MPI_Allreduce(MPI_IN_PLACE, &norm, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
      if (norm < 1e-12 * height)
        break;
      std::transform(du.begin(), du.end(), u.array().begin(), u.mutable_array().begin(), std::plus<double>());
      u.scatter_fwd();
    }
    converged = converged && norm < 1e-12 * height;
    contact.accept_step();
    const std::vector<double> nodal = contact.contact_forces();
    for (std::size_t i = 0; i < nodal.size(); ++i)
      force[step][i % 2] += nodal[i];
    MPI_Allreduce(MPI_IN_PLACE, force[step], 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  }
  VecDestroy(&x);
  VecDestroy(&R);
  const double normal = force[0][1] / (width * pressed / (height / E + 1.0 / penalty));
  const double slipping = -force[1][0] / (friction * force[1][1]);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0)
    std::printf("normal force / exact = %.12f\nfriction / (coefficient * normal force) = %.12f\n", normal, slipping);
  return converged && std::abs(normal - 1.0) < 1e-9 && std::abs(slipping - 1.0) < 1e-9;
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
    std::fprintf(stderr, "penalty_friction: %s\n", e.what());
  }
  PetscFinalize();
  return passed ? 0 : 1;
}
