// SPDX-License-Identifier: MIT
#include "nodes.h"
#include "../common/dolfinx_api.h"
#include <algorithm>
#include <dolfinx/la/Vector.h>
#include <functional>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::files
{
namespace
{
/// Nodes of this rank's owned cells.
std::span<const std::int32_t> local_cell_nodes(const dolfinx::fem::FunctionSpace<double>& V)
{
  const auto& topology = *V.mesh()->topology();
  const auto cells = V.dofmap()->map();
  return {cells.data_handle(), topology.index_map(topology.dim())->size_local() * cells.extent(1)};
}
} // namespace

std::vector<double> places(const dolfinx::fem::FunctionSpace<double>& V)
{
  const std::size_t gdim = V.mesh()->geometry().dim(), num = V.dofmap()->index_map->size_local();
  std::vector<double> out(num * gdim);
  const auto set = [&](std::size_t node, const double* x)
  {
    if (node < num)
      std::copy_n(x, gdim, out.begin() + std::ptrdiff_t(node * gdim));
  };
  if (!V.element()->is_mixed())
  {
    const std::vector<double> x = V.tabulate_dof_coordinates(false);
    for (std::size_t node = 0; node < num; ++node)
      set(node, x.data() + 3 * node);
    return out;
  }
  // Each degree of freedom of a mixed space is a node: that of a component lies where the point of its field does.
  for (int i = 0; i < V.element()->num_sub_elements(); ++i)
  {
    const auto [field, dofs] = common::collapse(V.sub({i}));
    const std::vector<double> x = field.tabulate_dof_coordinates(false);
    const std::size_t bs = field.dofmap()->index_map_bs();
    for (std::size_t k = 0; k < dofs.size(); ++k)
      set(dofs[k], x.data() + 3 * (k / bs));
  }
  return out;
}

std::vector<std::int64_t> input_cells(const dolfinx::mesh::Mesh<double>& mesh)
{
  const auto& topology = *mesh.topology();
  const std::size_t num = topology.index_map(topology.dim())->size_local();
  if (num == 0)
    return {};
  if (topology.original_cell_index.empty() || topology.original_cell_index[0].size() < num)
    throw std::runtime_error("a checkpoint tells cells by their numbers in the mesh's input, which a submesh does not "
                             "have: make the mesh with create_mesh, or read it from a file");
  const std::vector<std::int64_t>& all = topology.original_cell_index[0];
  return {all.begin(), all.begin() + std::ptrdiff_t(num)};
}

void set_input_numbers(dolfinx::mesh::Mesh<double>& mesh, std::span<const std::int64_t> cells,
                       std::span<const std::int64_t> nodes)
{
  const auto topology = mesh.topology();
  const auto map = topology->index_map(topology->dim());
  // DOLFINx has no call that changes the nodes' numbers; the mesh, to which they belong, is not const.
  auto& numbers = const_cast<std::vector<std::int64_t>&>(mesh.geometry().input_global_indices());
  if (cells.size() != std::size_t(map->size_local() + map->num_ghosts()) || nodes.size() != numbers.size())
    throw std::invalid_argument("numbers in the mesh's input are given for " + std::to_string(cells.size()) +
                                " cells and " + std::to_string(nodes.size()) + " nodes, found " +
                                std::to_string(map->size_local() + map->num_ghosts()) + " and " +
                                std::to_string(numbers.size()) + " on this rank");
  topology->original_cell_index = {{cells.begin(), cells.end()}};
  numbers.assign(nodes.begin(), nodes.end());
}

std::vector<std::int64_t> cell_nodes(const dolfinx::fem::FunctionSpace<double>& V)
{
  const std::span<const std::int32_t> local = local_cell_nodes(V);
  std::vector<std::int64_t> out(local.size());
  V.dofmap()->index_map->local_to_global(local, out);
  return out;
}

NodesThen nodes_then(const dolfinx::fem::FunctionSpace<double>& V, const std::vector<std::int64_t>& nodes)
{
  const auto map = V.dofmap()->index_map;
  const std::size_t num = map->size_local();
  const std::span<const std::int32_t> local = local_cell_nodes(V);
  std::vector<std::int64_t> then(num + map->num_ghosts(), -1);
  for (std::size_t i = 0; i < local.size(); ++i)
    then[local[i]] = nodes[i];
  dolfinx::la::Vector<std::int64_t> number(map, 1), count(map, 1);
  for (std::size_t i = 0; i < then.size(); ++i)
  {
    common::array(number)[i] = std::max(then[i], std::int64_t(0));
    common::array(count)[i] = then[i] >= 0;
  }
  number.scatter_rev(std::plus<std::int64_t>());
  count.scatter_rev(std::plus<std::int64_t>());
  NodesThen out;
  for (std::size_t i = 0; i < num; ++i)
  {
    out.agreed = out.agreed && count.array()[i] > 0;
    common::array(number)[i] /= std::max(count.array()[i], std::int64_t(1));
  }
  number.scatter_fwd();
  for (std::size_t i = 0; i < then.size(); ++i)
    out.agreed = out.agreed && (then[i] < 0 || then[i] == number.array()[i]);
  out.numbers.assign(number.array().begin(), number.array().begin() + std::ptrdiff_t(num));
  return out;
}
} // namespace dolfinx_impact::files
