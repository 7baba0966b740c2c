// SPDX-License-Identifier: MIT
// A block is pressed on a rigid plane and dragged along it: Newton's method with penalty contact and Coulomb friction,
// residual and tangent added to PETSc's objects, without Python. Pressed, the force is that of two springs in series;
// dragged, friction is the coefficient times the normal force. Runs on any number of ranks.
#include <array>
#include <basix/finite-element.h>
#include <cmath>
#include <cstdio>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/la/petsc.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/enforcement/penalty/QuadraturePenalty.h>
#include <dolfinx_impact/kernels/KernelTable.h>
#include <dolfinx_impact/operators/Tangent.h>
#include <dolfinx_impact/surface/Surface.h>
#include <numeric>
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
  const gap::Rigid plane{.kind = gap::Rigid::Kind::plane, .gdim = 2, .direction = {0, 1, 0}};
  enforcement::QuadraturePenalty contact("block on plane", V, surface::make_surface(*V, bottom), plane,
                                         {.penalty = penalty, .friction = friction});

  const PetscInt first = 2 * map->local_range()[0];
  std::vector<PetscInt> prescribed; // components of the top's nodes, in turn
  for (std::int32_t node : fem::locate_dofs_geometrical(*V, at_height(height)))
    for (int c = 0; c < 2 && node < map->size_local(); ++c)
      prescribed.push_back(first + 2 * node + c);

  la::Vector<double> u(map, 2), du(map, 2);
  u.set(0.0);
  Vec x = la::petsc::create_vector_wrap(u), dx = la::petsc::create_vector_wrap(du), R;
  VecDuplicate(dx, &R);
  la::petsc::KrylovSolver solver(MPI_COMM_WORLD);
  for (auto [key, value] :
       {std::pair{"ksp_type", "preonly"}, {"pc_type", "lu"}, {"pc_factor_mat_solver_type", "mumps"}})
    la::petsc::options::set(key, value);
  solver.set_from_options();
  std::array<double, 3> force[2]; // on the block, of both steps
  double change = 0.0;
  for (int step = 0; step < 2 && change < 1e-12; ++step)
  {
    contact.begin_step(u.array(), std::array{0.0, 0.0, 0.0}); // the plane does not move
    for (std::size_t i = 0; i < prescribed.size(); ++i)
      u.mutable_array()[prescribed[i] - first] = i % 2 ? -pressed : step * 0.5 * height;
    u.scatter_fwd();
    for (int iteration = 0; iteration < 20 && (iteration == 0 || change > 1e-12); ++iteration)
    {
      contact.update_gap(u.array());
      MatMult(bodies.matrix(), x, R);
      contact.add_residual(R);
      Mat J;
      MatDuplicate(bodies.matrix(), MAT_COPY_VALUES, &J);
      MatAXPY(J, 1.0, contact.tangent(), DIFFERENT_NONZERO_PATTERN);
      VecSet(dx, 0.0); // prescribed values are reached
      MatZeroRowsColumns(J, PetscInt(prescribed.size()), prescribed.data(), 1.0, dx, R);
      solver.set_operator(J);
      solver.solve(dx, R);
      VecAXPY(x, -1.0, dx);
      VecNorm(dx, NORM_INFINITY, &change);
      u.scatter_fwd();
      MatDestroy(&J);
    }
    contact.accept_step();
    force[step] = contact.totals().force;
  }
  for (Vec* v : {&x, &dx, &R})
    VecDestroy(v);
  const double normal = force[0][1] / (width * pressed / (height / E + 1.0 / penalty));
  const double slipping = -force[1][0] / (friction * force[1][1]);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0)
    std::printf("normal force / exact = %.12f\nfriction / (coefficient * normal force) = %.12f\n", normal, slipping);
  return change < 1e-12 && std::abs(normal - 1.0) < 1e-9 && std::abs(slipping - 1.0) < 1e-9;
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
