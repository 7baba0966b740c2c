// SPDX-License-Identifier: MIT
// What releases of DOLFINx spell differently: the layer gives the same on each.
#include <array>
#include <basix/finite-element.h>
#include <catch2/catch_test_macros.hpp>
#include <cstdint>
#include <dolfinx/fem/Function.h>
#include <dolfinx/mesh/generation.h>
#include <dolfinx_impact/common/create_functionspace.h>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

namespace
{
namespace api = dolfinx_impact::common;

std::shared_ptr<dolfinx::mesh::Mesh<double>> square(dolfinx::mesh::CellType cell)
{
  return std::make_shared<dolfinx::mesh::Mesh<double>>(
      dolfinx::mesh::create_rectangle<double>(MPI_COMM_SELF, {{{0.0, 0.0}, {2.0, 1.0}}}, {2, 3}, cell));
}

std::shared_ptr<const dolfinx::fem::FunctionSpace<double>> space(std::shared_ptr<dolfinx::mesh::Mesh<double>> mesh,
                                                                 int degree, const std::vector<std::size_t>& shape)
{
  const auto element = basix::create_element<double>(
      basix::element::family::P, dolfinx::mesh::cell_type_to_basix_type(mesh->topology()->cell_type()), degree,
      basix::element::lagrange_variant::gll_warped, basix::element::dpc_variant::unset, false);
  return std::make_shared<dolfinx::fem::FunctionSpace<double>>(api::create_functionspace(mesh, element, shape));
}
} // namespace

TEST_CASE("arrays of vectors are views, whose values can be set")
{
  const auto V = space(square(dolfinx::mesh::CellType::triangle), 1, {2});
  dolfinx::fem::Function<double> u(V);
  dolfinx::la::Vector<double>& x = *u.x();
  const std::span<double> values = api::array(x);
  api::fill(x, 3.0);
  CHECK(values.size() == 2 * 12);
  CHECK(std::vector<double>(values.begin(), values.end()) == std::vector<double>(24, 3.0));
  values[5] = 7.0;
  const dolfinx::la::Vector<double>& read = x;
  CHECK(api::array(read)[5] == 7.0);
  CHECK(api::array(read).data() == values.data());
  static_assert(std::is_same_v<decltype(api::array(read)), std::span<const double>>);
}

TEST_CASE("elements and nodes of a mesh's geometry")
{
  for (auto cell : {dolfinx::mesh::CellType::triangle, dolfinx::mesh::CellType::quadrilateral})
  {
    const auto mesh = square(cell);
    CHECK(api::coordinate_element(*mesh).degree() == 1);
    CHECK(api::coordinate_element(*mesh).cell_shape() == cell);
    const auto nodes = api::geometry_dofmap(*mesh);
    const std::size_t num_cells = cell == dolfinx::mesh::CellType::triangle ? 12 : 6;
    CHECK(nodes.extent(0) == num_cells);
    CHECK(nodes.extent(1) == (cell == dolfinx::mesh::CellType::triangle ? 3 : 4));
    std::vector<int> cells_of(mesh->geometry().x().size() / 3, 0); // each node belongs to a cell
    for (std::size_t c = 0; c < nodes.extent(0); ++c)
      for (std::size_t i = 0; i < nodes.extent(1); ++i)
        ++cells_of.at(nodes(c, i));
    for (int number : cells_of)
      CHECK(number > 0);
  }
}

TEST_CASE("shapes of values, and components as spaces of their own")
{
  const auto mesh = square(dolfinx::mesh::CellType::triangle);
  CHECK(api::value_shape(*space(mesh, 2, {2})) == std::vector<std::size_t>{2});
  CHECK(api::value_shape(*space(mesh, 1, {})).empty());
  const auto V = space(mesh, 1, {2});
  for (int component : {0, 1})
  {
    const auto [field, dofs] = api::collapse(V->sub({component}));
    CHECK(api::value_shape(field).empty());
    CHECK(dofs.size() == 12);
    std::vector<int> seen(24, 0);
    for (std::int32_t dof : dofs)
      ++seen.at(dof);
    for (int i = 0; i < 24; ++i)
      CHECK(seen[i] == (i % 2 == component));
  }
}

TEST_CASE("patterns of cells, conditions and types of numbers")
{
  const auto mesh = square(dolfinx::mesh::CellType::quadrilateral);
  const auto V = space(mesh, 1, {});
  const auto& map = *V->dofmap();
  dolfinx::la::SparsityPattern pattern(MPI_COMM_SELF, {map.index_map, map.index_map}, {1, 1});
  const std::vector<std::int32_t> cells{0};
  api::insert_cells(pattern, cells, map, map);
  pattern.finalize();
  CHECK(pattern.num_nonzeros() == 16); // four nodes with each other
  const std::vector<std::int32_t> fixed{0, 1};
  const auto zero = std::make_shared<dolfinx::fem::Constant<double>>(0.0);
  const std::vector conditions{std::make_shared<const dolfinx::fem::DirichletBC<double>>(zero, fixed, V)};
  CHECK(api::boundary_conditions(conditions).size() == 1);
  int size = 0;
  MPI_Type_size(api::mpi_type<double>(), &size);
  CHECK(size == 8);
  MPI_Type_size(api::mpi_type<std::int32_t>(), &size);
  CHECK(size == 4);
}
