// SPDX-License-Identifier: MIT
// Hertz's line contact of two elastic blocks: dual Lagrange multipliers by mortar integrals, a primal-dual active set
// and condensation, without Python. Runs on any number of ranks.
#include <algorithm>
#include <basix/finite-element.h>
#include <cmath>
#include <dolfinx/fem/utils.h>
#include <dolfinx/la/petsc.h>
#include <dolfinx_impact/enforcement/mortar/Condensation.h>
#include <dolfinx_impact/enforcement/mortar/MortarContact.h>
#include <dolfinx_impact/kernels/KernelTable.h>
#include <dolfinx_impact/operators/Tangent.h>
#include <dolfinx_impact/surface/Surface.h>
#include <functional>
#include <numeric>
#include <spdlog/spdlog.h>

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
auto where(std::function<double(double, double)> f)
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
  auto V = std::make_shared<fem::FunctionSpace<double>>(fem::create_functionspace(mesh, element, {2}));
  const auto map = V->dofmap()->index_map;
  const std::size_t owned = 2 * map->size_local(), first = 2 * map->local_range()[0];
  std::vector<std::int32_t> cells(mesh->topology()->index_map(2)->size_local());
  std::iota(cells.begin(), cells.end(), 0);
  const auto kernel = kernels::find({"linear_elastic.tangent", "quadrilateral", 1, 1, "plane_strain"}).at(0);
  operators::Tangent bodies({V, V}, {{kernel, cells, {E, nu}}}, {});
  bodies.assemble();
  // The round surface is the slave.
  const auto facets = [&](auto f) { return mesh::locate_entities_boundary(*mesh, 1, where(f)); };
  const auto slave = surface::make_surface(*V, facets([](double x, double y) { return y - x * x / (2 * radius); }));
  const auto master = surface::make_surface(*V, facets([](double, double y) { return y; }));
  // Nothing moves below; the top is moved down.
  la::Vector<double> u(map, 2), du(map, 2), r(map, 2);
  u.set(0.0);
  std::vector<PetscInt> prescribed;
  std::vector<std::int8_t> fixed(u.array().size(), 0);
  for (double end : {-size, size})
    for (std::int32_t node : fem::locate_dofs_geometrical(*V, where([=](double, double y) { return y - end; })))
      for (int c = 0; c < 2; ++c)
      {
        fixed[2 * node + c] = 1;
        if (node < map->size_local())
          prescribed.push_back(PetscInt(first) + 2 * node + c);
        u.mutable_array()[2 * node + c] = c == 1 && end > 0.0 ? -down : 0.0;
      }
  u.scatter_fwd();
  enforcement::MortarContact contact(V, slave, master, {.name = "blocks"}, fixed);
  contact.begin_step(std::vector<double>(fixed.size(), 0.0), {});
  Vec U = la::petsc::create_vector_wrap(u), dU = la::petsc::create_vector_wrap(du);
  Vec R = la::petsc::create_vector_wrap(r);
  la::petsc::KrylovSolver solver(MPI_COMM_WORLD);
  PetscOptionsInsertString(nullptr, "-ksp_type preonly -pc_type lu -pc_factor_mat_solver_type mumps");
  solver.set_from_options();
  int changes = 1;
  double change = 1.0;
  for (int iteration = 0; iteration < 30 && (changes > 0 || change > 1e-10); ++iteration)
  {
    contact.update_gap(u.array());
    MatMult(bodies.matrix(), U, R);
    contact.update_multipliers(r.array().subspan(0, owned));
    changes = contact.update_active_set(iteration == 0);
    // T^T K T y = -T^T (R + K known), constrained and prescribed unknowns are zero.
    const enforcement::Condensation condensation(MPI_COMM_WORLD, owned, first, 2, {contact.constraints()});
    std::ranges::copy(condensation.known, du.mutable_array().begin());
    MatMultAdd(bodies.matrix(), dU, R, R);
    std::ranges::transform(condensation.residual(r.array().subspan(0, owned)), r.mutable_array().begin(),
                           std::negate());
    std::vector<PetscInt> zero = prescribed;
    for (std::size_t i = 0; i < owned; ++i)
      if (condensation.pinned()[i])
        zero.push_back(PetscInt(first + i));
    VecSet(dU, 0.0);
    Mat A = condensation.condense(bodies.matrix());
    MatZeroRowsColumns(A, PetscInt(zero.size()), zero.data(), E, dU, R);
    solver.set_operator(A);
    solver.solve(dU, R);
    MatDestroy(&A);
    std::ranges::copy(condensation.increment(dU), du.mutable_array().begin());
    VecNorm(dU, NORM_INFINITY, &change);
    VecAXPY(U, 1.0, dU);
    u.scatter_fwd();
  }
  contact.accept_step();
  const std::vector<double> nodal = contact.contact_forces(), p = contact.pressure();
  const double force = contact.totals().force[1]; // on the upper block
  double peak = p.empty() ? 0.0 : std::ranges::max(p), sum = std::accumulate(nodal.begin(), nodal.end(), 0.0);
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD); // on both bodies: zero
  MPI_Allreduce(MPI_IN_PLACE, &peak, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  for (Vec* v : {&U, &dU, &R})
    VecDestroy(v);
  const double exact = std::sqrt(force * E / (2.0 * (1.0 - nu * nu) * M_PI * radius)); // of both bodies together
  PetscPrintf(MPI_COMM_WORLD, "force %.6f\npeak pressure / Hertz = %.4f\n", force, peak / exact);
  return changes == 0 && change < 1e-10 && std::abs(peak / exact - 1.0) < 0.01 && std::abs(sum) < 1e-10 * force;
}
} // namespace

int main(int argc, char* argv[])
{
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  spdlog::set_level(spdlog::level::warn); // DOLFINx tells every step otherwise
  const bool passed = run();
  PetscFinalize();
  return passed ? 0 : 1;
}
