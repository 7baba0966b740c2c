// SPDX-License-Identifier: MIT
// Tangent with a coefficient and boundary conditions, energies, and refusals, through the C++ interface alone.
#include <array>
#include <basix/finite-element.h>
#include <cmath>
#include <cstdio>
#include <dolfinx/fem/DirichletBC.h>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/common/dolfinx_api.h>
#include <dolfinx_impact/kernels/KernelTable.h>
#include <dolfinx_impact/operators/InternalForce.h>
#include <dolfinx_impact/operators/KernelTangent.h>
#include <functional>
#include <spdlog/spdlog.h>
#include <string>

using namespace dolfinx;
using namespace dolfinx_impact;
using Function = fem::Function<double>;

namespace
{
int failures = 0;

void expect(bool condition, const char* what)
{
  if (!condition)
    std::fprintf(stderr, "failed: %s\n", what), ++failures;
}

/// Does `action` throw an error whose message holds `words`?
void expect_error(const std::function<void()>& action, const std::string& words)
{
  try
  {
    action();
  }
  catch (const std::exception& e)
  {
    if (std::string(e.what()).find(words) == std::string::npos)
      std::fprintf(stderr, "other error: %s\n", e.what()), ++failures;
    return;
  }
  expect(false, ("no error: " + words).c_str());
}

const std::vector<double> rubber{2.0, 0.3};

/// Integrals of a neo-Hookean form in two pieces, even and odd cells.
std::vector<operators::Integral> pieces(const std::string& name, const mesh::Mesh<double>& mesh)
{
  std::array<std::vector<std::int32_t>, 2> cells;
  for (std::int32_t c = 0; c < mesh.topology()->index_map(3)->size_local(); ++c)
    cells[c % 2].push_back(c);
  const impact_kernel* kernel = kernels::find({.name = name, .cell = "hexahedron"}).at(0);
  return {{kernel, cells[0], rubber}, {kernel, cells[1], rubber}};
}

/// u = amplitude times smooth functions of position, by node.
void set(Function& u, double amplitude, double phase)
{
  u.interpolate(
      [=](auto x) -> std::pair<std::vector<double>, std::vector<std::size_t>>
      {
        const std::size_t n = x.extent(1);
        std::vector<double> v(3 * n);
        for (std::size_t p = 0; p < n; ++p)
          for (int i = 0; i < 3; ++i)
            v[i * n + p] = amplitude * std::sin(phase + 2 * x(i, p) + x((i + 1) % 3, p));
        return {v, {3, n}};
      });
  u.x()->scatter_fwd();
}

void checks()
{
  auto mesh = std::make_shared<mesh::Mesh<double>>(mesh::create_box<double>(
      MPI_COMM_WORLD, {{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}}}, {3, 2, 2}, mesh::CellType::hexahedron));
  const auto element = basix::create_element<double>(basix::element::family::P, basix::cell::type::hexahedron, 1,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, false);
  auto V =
      std::make_shared<fem::FunctionSpace<double>>(dolfinx_impact::common::create_functionspace(mesh, element, {3}));
  auto u = std::make_shared<Function>(V), d = std::make_shared<Function>(V), start = std::make_shared<Function>(V);
  set(*start, 0.03, 0.0), set(*d, 1.0, 1.0);
  const auto map = V->dofmap()->index_map;
  const std::size_t size = 3 * map->size_local();

  // Central differences of energy and force along d. Step 1e-5: error 1e-10 times third derivatives of order ten, and
  // round-off 1e-16 / 1e-5 times values of order one.
  const operators::InternalForce force(mesh, V, pieces("neo_hookean.force", *mesh), {{"u", u}});
  const operators::InternalForce energy(mesh, nullptr, pieces("neo_hookean.energy", *mesh), {{"u", u}});
  la::Vector<double> f(map, 3), f_plus(map, 3), f_minus(map, 3);
  const double h = 1e-5;
  auto at = [&](double s)
  {
    for (std::size_t i = 0; i < u->x()->array().size(); ++i)
      dolfinx_impact::common::array(*u->x())[i] = start->x()->array()[i] + s * d->x()->array()[i];
  };
  auto total = [](double x)
  {
    double sum = 0.0;
    MPI_Allreduce(&x, &sum, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    return sum;
  };
  at(h);
  const double plus = total(energy.value());
  force.apply(f_plus);
  at(-h);
  const double minus = total(energy.value());
  force.apply(f_minus);
  at(0);
  force.apply(f);
  double work = 0.0;
  for (std::size_t i = 0; i < size; ++i)
    work += f.array()[i] * d->x()->array()[i];
  expect(std::abs((plus - minus) / (2 * h) - total(work)) < 1e-8, "energy and force");

  operators::KernelTangent tangent({V, V}, pieces("neo_hookean.tangent", *mesh), {{"u", u}});
  tangent.assemble();
  Vec x, y;
  VecCreateMPIWithArray(PETSC_COMM_WORLD, 1, size, PETSC_DETERMINE, d->x()->array().data(), &x);
  VecDuplicate(x, &y);
  MatMult(tangent.matrix(), x, y);
  const PetscScalar* product = nullptr;
  VecGetArrayRead(y, &product);
  double error = 0.0;
  for (std::size_t i = 0; i < size; ++i)
    error = std::max(error, std::abs(product[i] - (f_plus.array()[i] - f_minus.array()[i]) / (2 * h)));
  VecRestoreArrayRead(y, &product);
  expect(error < 1e-8, "force and tangent");

  // Constrained: one on the diagonal, nothing beside it; and assembling again gives the same matrix.
  const std::vector<std::int32_t> nodes = fem::locate_dofs_geometrical(*V,
                                                                       [](auto x)
                                                                       {
                                                                         std::vector<std::int8_t> marked(x.extent(1));
                                                                         for (std::size_t p = 0; p < marked.size(); ++p)
                                                                           marked[p] = std::abs(x(0, p)) < 1e-12;
                                                                         return marked;
                                                                       });
  auto zero = std::make_shared<Function>(V);
  const std::vector<std::shared_ptr<const fem::DirichletBC<double>>> bcs{
      std::make_shared<fem::DirichletBC<double>>(zero, nodes)};
  tangent.assemble(bcs);
  tangent.assemble(bcs);
  MatMult(tangent.matrix(), x, y);
  VecGetArrayRead(y, &product);
  for (std::int32_t node : nodes)
    for (std::size_t i = 3 * std::size_t(node); i < 3 * std::size_t(node) + 3 && i < size; ++i)
      expect(std::abs(product[i] - d->x()->array()[i]) < 1e-14, "constrained rows");
  VecRestoreArrayRead(y, &product);
  VecDestroy(&x), VecDestroy(&y);

  auto tangents = pieces("neo_hookean.tangent", *mesh), forces = pieces("neo_hookean.force", *mesh);
  expect_error([&] { operators::KernelTangent({V, V}, tangents, {}); }, "needs a coefficient named 'u'");
  expect_error([&] { operators::KernelTangent({V, V}, forces, {{"u", u}}); }, "rank 1, not 2");
  expect_error([&] { operators::InternalForce(mesh, V, tangents, {{"u", u}}); }, "rank 2");
  expect_error([&] { operators::InternalForce(mesh, V, forces, {}); }, "needs a coefficient named 'u'");
  expect_error([&] { operators::InternalForce(mesh, nullptr, forces, {{"u", u}}); }, "needs a test space");
  expect_error([&] { operators::InternalForce(mesh, V, forces, {{"u", u}}, 3); }, "width is 3");
  forces[0].constants = {1.0};
  expect_error([&] { operators::InternalForce(mesh, V, forces, {{"u", u}}); }, "takes 2 values of constants");
  forces[0] = {forces[1].kernel, {1000000}, rubber};
  expect_error([&] { operators::InternalForce(mesh, V, forces, {{"u", u}}); }, "not on this rank");
  expect_error([] { kernels::find({.name = "rubber.force", .cell = "hexahedron"}); }, "the name is unknown");
  expect_error([] { kernels::find({.name = "mass", .cell = "hexahedron", .degree = 3}); }, "there are: ");
  expect_error([] { kernels::find({.name = "linear_elastic.force", .cell = "triangle"}); }, "several hypotheses");
  expect_error([] { kernels::load("/nonexistent.so", {"kernel"}); }, "cannot be loaded");
}
} // namespace

int main(int argc, char* argv[])
{
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  spdlog::set_level(spdlog::level::warn);
  checks();
  PetscFinalize();
  if (failures == 0)
    std::puts("passed");
  return failures ? 1 : 0;
}
