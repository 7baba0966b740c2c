// SPDX-License-Identifier: MIT
// Forces from arrays with four entries per node, in one sweep, are those from DOLFINx's arrays.
#include <basix/finite-element.h>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <dolfinx_impact/common/dolfinx_api.h>
#include <dolfinx_impact/kernels/KernelTable.h>
#include <dolfinx_impact/operators/InternalForce.h>
#include <dolfinx_impact/operators/NodePositions.h>
#include <dolfinx_impact/operators/gather.h>
#include <dolfinx_impact/operators/lanes.h>
#include <numeric>

using Catch::Approx;
using namespace dolfinx_impact;
using namespace dolfinx_impact::operators;

namespace
{
/// A cube of 3 x 3 x 3 boxes, or six tetrahedra each: the last batch has lanes that are left over.
struct PaddedCube
{
  PaddedCube(dolfinx::mesh::CellType cell, int degree)
      : mesh(std::make_shared<Mesh>(dolfinx::mesh::create_box<double>(
            MPI_COMM_SELF, {{{0.0, 0.0, 0.0}, {1.0, 2.0, 1.5}}}, {3, 3, 3}, cell))),
        V(space(degree)), u(std::make_shared<Function>(V))
  {
    const std::vector<double> x = V->tabulate_dof_coordinates(false);
    const std::span<double> values = dolfinx_impact::common::array(*u->x());
    for (std::size_t i = 0; i < x.size(); ++i)
      values[i] = 1e-3 * std::sin(3.0 * x[i] + double(i % 3));
  }

  std::shared_ptr<const FunctionSpace> space(int degree) const
  {
    const auto cell = dolfinx::mesh::cell_type_to_basix_type(mesh->topology()->cell_type());
    const auto element = basix::create_element<double>(basix::element::family::P, cell, degree,
                                                       basix::element::lagrange_variant::gll_warped,
                                                       basix::element::dpc_variant::unset, false);
    return std::make_shared<FunctionSpace>(dolfinx_impact::common::create_functionspace(mesh, element, {3}));
  }

  InternalForce force(int degree, int width) const
  {
    const std::string cell = dolfinx::mesh::to_string(mesh->topology()->cell_type());
    const impact_kernel* kernel =
        kernels::find({.name = "linear_elastic.force", .cell = cell, .degree = degree, .hypothesis = "3d"}).at(0);
    std::vector<std::int32_t> cells(mesh->topology()->index_map(3)->size_local());
    std::iota(cells.begin(), cells.end(), 0);
    return {mesh, V, {{kernel, cells, {3.0, 0.3}}}, {{"u", u}}, width};
  }

  std::shared_ptr<Mesh> mesh;
  std::shared_ptr<const FunctionSpace> V;
  std::shared_ptr<Function> u;
};
} // namespace

TEST_CASE("forces from padded arrays")
{
  using dolfinx::mesh::CellType;
  const auto [cell, degree] =
      GENERATE(std::pair{CellType::hexahedron, 1}, std::pair{CellType::tetrahedron, 1},
               std::pair{CellType::tetrahedron, 2}, std::pair{CellType::hexahedron, 2});
  const int width = GENERATE(1, 0);
  const bool by_space = GENERATE(true, false);
  PaddedCube cube(cell, degree);
  InternalForce force = cube.force(degree, width);
  const std::span<const double> u = dolfinx_impact::common::array(*cube.u->x());
  std::vector<double> expected(u.size(), 1.0);
  force.assemble(expected);

  AlignedVector padded(u.size() / 3 * 4, 0.0), found(padded.size(), 0.0);
  for (std::size_t i = 0; i < u.size(); ++i)
  {
    padded[i / 3 * 4 + i % 3] = u[i];
    found[i / 3 * 4 + i % 3] = 1.0;
  }
  NodePositions positions(by_space ? cube.V : cube.space(degree));
  CHECK(positions.space() != nullptr);
  force.read_positions(&positions);
  force.read("u", padded.data(), 4);
  force.assemble_padded(found);
  double largest = 0.0;
  for (double f : expected)
    largest = std::max(largest, std::abs(f - 1.0));
  REQUIRE(largest > 1e-4);
  for (std::size_t i = 0; i < u.size(); ++i)
    REQUIRE(found[i / 3 * 4 + i % 3] == Approx(expected[i]).margin(1e-13 * largest).epsilon(1e-13));
  for (std::size_t i = 3; i < found.size(); i += 4)
    REQUIRE(found[i] == 0.0);

  // From the functions again.
  force.read("u", nullptr);
  force.read_positions(nullptr);
  std::vector<double> again(u.size(), 1.0);
  force.assemble(again);
  CHECK(again == expected);
}

TEST_CASE("forces in float from padded arrays, whose positions are kept until the mesh is moved")
{
  using dolfinx::mesh::CellType;
  const auto [cell, degree] = GENERATE(std::pair{CellType::hexahedron, 1}, std::pair{CellType::tetrahedron, 1},
                                       std::pair{CellType::tetrahedron, 2});
  PaddedCube cube(cell, degree);
  InternalForce force = cube.force(degree, 0);
  force.set_mixed();
  const std::span<const double> u = dolfinx_impact::common::array(*cube.u->x());
  AlignedVector padded(u.size() / 3 * 4, 0.0);
  for (std::size_t i = 0; i < u.size(); ++i)
    padded[i / 3 * 4 + i % 3] = u[i];
  NodePositions positions(cube.V);
  const auto version = positions.version();
  positions.update();
  CHECK(positions.version() == version);
  CHECK(NodePositions(cube.V).version() != version);
  force.read_positions(&positions);
  force.read("u", padded.data(), 4);
  for (const double stretch : {1.0, 1.0, 1.5})
  {
    for (double& x : cube.mesh->geometry().x())
      x *= stretch;
    positions.update();
    AlignedVector found(padded.size(), 0.0);
    force.assemble_padded(found);
    InternalForce alone = cube.force(degree, 0);
    alone.set_mixed();
    std::vector<double> expected(u.size(), 0.0);
    alone.assemble(expected);
    double largest = 0.0;
    for (const double f : expected)
      largest = std::max(largest, std::abs(f));
    REQUIRE(largest > 1e-4);
    for (std::size_t i = 0; i < u.size(); ++i)
      REQUIRE(found[i / 3 * 4 + i % 3] == Approx(expected[i]).margin(1e-13 * largest)); // sums in another order
  }
  CHECK(positions.version() != version);
}

// Arrays are read by the vectors of a kernel's sweep, and by the calls that it stands for.
TEST_CASE("a kernel's own sweep gives the same as its calls")
{
  int swept = 0;
  for (const impact_kernel* kernel : kernels::table())
    for (const int width : {4, 8})
    {
      const impact_sweep sweep = kernels::sweep(*kernel, width);
      // Those that overwrite internal variables are compared in whole steps: tests/unit/inelastic/test_in_place.py.
      if (!sweep || kernel->num_outputs > 0 || width > kernels::processor_width())
        continue;
      ++swept;
      const impact_element& element = kernel->arguments[0];
      const int bs = element.block_size, nodes = element.num_dofs / bs, stride = padded_stride(bs);
      // Two batches of cells that are not flat, whose lanes share nodes.
      const int batches = 2, num_nodes = nodes + batches * width;
      std::vector<std::int32_t> dofs(std::size_t(batches) * nodes * width);
      for (int batch = 0; batch < batches; ++batch)
        for (int node = 0; node < nodes; ++node)
          for (int lane = 0; lane < width; ++lane)
            dofs[(batch * nodes + node) * width + lane] = batch * width + lane + node;
      AlignedVector x(4 * num_nodes), values(stride * num_nodes), found(values.size(), 0.0), expected(found);
      for (int i = 0; i < num_nodes; ++i)
      {
        for (int c = 0; c < bs; ++c)
        {
          x[4 * i + c] = 2.0 + std::sin(1.0 + i * (1.3 + 0.7 * c)) + 0.1 * i * (c + 1);
          values[stride * i + c] = 1e-3 * std::cos(0.3 + i * (2.1 + c));
        }
      }
      std::vector<double> constants(kernel->size_c, 0.3);
      REQUIRE(kernel->num_coefficients == 1); // kernels with a scalar, too, are compiled at run time
      const double* scalars = nullptr;
      const impact_cells cells{batches,      dofs.data(), constants.data(), x.data(), values.data(),
                               found.data(), scalars,     nullptr,          nullptr,  nullptr,
                               nullptr,      nullptr};
      sweep(&cells);
      AlignedVector A(element.num_dofs * width, 0.0), w(A.size()), positions(3 * nodes * width);
      for (int batch = 0; batch < batches; ++batch)
      {
        const std::int32_t* own = dofs.data() + batch * nodes * width;
        gather(width, 3, 4)(x.data(), own, nodes, positions.data());
        gather(width, bs, stride)(values.data(), own, nodes, w.data());
        kernels::tabulate (*kernel, width)(A.data(), w.data(), constants.data(), positions.data(), 0);
        scatter(width, bs, stride)(A.data(), own, nodes, width, expected.data());
      }
      INFO(kernel->name << " on " << kernel->cell << ", " << kernel->hypothesis << ", " << width << " cells at once");
      // The compiler may fuse other products and sums in one of them, so that some of the hundred terms of a force are
      // rounded once more.
      double largest = 0.0;
      for (const double f : expected)
        largest = std::max(largest, std::abs(f));
      CHECK(largest > 0.0);
      for (std::size_t i = 0; i < found.size(); ++i)
        CHECK(std::abs(found[i] - expected[i]) <= 100 * 1.1e-16 * largest);
    }
#if defined(__x86_64__) && defined(__GNUC__)
  CHECK((swept > 0) == (kernels::processor_width() >= 4));
#endif
}

TEST_CASE("arrays begin with a cache line, large ones with a large page, and keep their values as they grow")
{
  const auto begins_at = [](const AlignedVector& values, std::size_t bytes)
  { return reinterpret_cast<std::uintptr_t>(values.data()) % bytes == 0; };
  constexpr std::size_t large_page = std::size_t(1) << 21;
  AlignedVector values;
  for (const std::size_t size : {std::size_t(1), std::size_t(1000), large_page / 4, large_page})
  {
    const std::size_t before = values.size();
    values.resize(size, double(size));
    CHECK(begins_at(values, alignment));
    CHECK(begins_at(values, size * sizeof(double) >= 2 * large_page ? large_page : alignment));
    CHECK(values.back() == double(size));
    CHECK((before == 0 || values[before - 1] == double(before)));
  }
  values.shrink_to_fit();
  const AlignedVector copy = values;
  CHECK(copy == values);
}
