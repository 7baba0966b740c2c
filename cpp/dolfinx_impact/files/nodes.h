// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <dolfinx/fem/FunctionSpace.h>
#include <span>
#include <vector>

/// Nodes and cells as files know them: nodes by the global numbers that they have when the file is written, cells by
/// their number in the mesh's input, which does not depend on the ranks.
namespace dolfinx_impact::files
{
/// Undeformed coordinates of this rank's owned nodes, which are the blocks of the degrees of freedom,
/// [i*gdim + c] [L].
std::vector<double> places(const dolfinx::fem::FunctionSpace<double>& V);

/// Numbers of this rank's owned cells in the mesh's input.
/// @throws std::runtime_error for a submesh, which has no input: its cells cannot be identified on other ranks
std::vector<std::int64_t> input_cells(const dolfinx::mesh::Mesh<double>& mesh);

/// Give cells and geometry nodes of a mesh other numbers in its input: of a mesh that was made from another one, those
/// that they have in the input of that one.
/// @param[in] cells for each cell of this rank, ghosts included
/// @param[in] nodes for each geometry node of this rank, ghosts included
/// @throws std::invalid_argument if there are more numbers or fewer
void set_input_numbers(dolfinx::mesh::Mesh<double>& mesh, std::span<const std::int64_t> cells,
                       std::span<const std::int64_t> nodes);

/// Global numbers of the nodes of this rank's owned cells, [cell*nodes + i].
std::vector<std::int64_t> cell_nodes(const dolfinx::fem::FunctionSpace<double>& V);

/// Numbers that this rank's owned nodes have in a file.
struct NodesThen
{
  std::vector<std::int64_t> numbers;
  bool agreed = true; ///< whether cells that share a node agree on its number, on this rank
};

/// Exchange the numbers of nodes whose cells belong to other ranks. Collective.
/// @param[in] nodes numbers that the nodes of this rank's owned cells have in the file, [cell*nodes + i]
NodesThen nodes_then(const dolfinx::fem::FunctionSpace<double>& V, const std::vector<std::int64_t>& nodes);
} // namespace dolfinx_impact::files
