// SPDX-License-Identifier: MIT
#include "NodePositions.h"
#include "../common/dolfinx_api.h"
#include <algorithm>
#include <atomic>
#include <dolfinx/fem/DofMap.h>
#include <dolfinx/mesh/Mesh.h>

namespace dolfinx_impact::operators
{
namespace
{
/// The mesh's node that each node of the space is in all cells; -1 for a node that is none. Empty if a node is another
/// one in another cell, or cells have more nodes than the space.
std::vector<std::int32_t> common_nodes(const dolfinx::fem::FunctionSpace<double>& V)
{
  const auto& map = *V.dofmap();
  const auto x_dofmap = common::geometry_dofmap(*V.mesh());
  const std::size_t per_cell = x_dofmap.extent(1);
  const auto& nodes = *map.index_map;
  std::vector<std::int32_t> out(nodes.size_local() + nodes.num_ghosts(), -1);
  if (map.bs() != map.index_map_bs())
    return {};
  for (std::size_t cell = 0; cell < x_dofmap.extent(0); ++cell)
  {
    const auto dofs = map.cell_dofs(std::int32_t(cell));
    if (dofs.size() < per_cell)
      return {};
    for (std::size_t j = 0; j < per_cell; ++j)
    {
      std::int32_t& known = out[dofs[j]];
      if (known >= 0 && known != x_dofmap(cell, j))
        return {};
      known = x_dofmap(cell, j);
    }
  }
  return out;
}
} // namespace

NodePositions::NodePositions(std::shared_ptr<const FunctionSpace> V) : _V(std::move(V)), _nodes(common_nodes(*_V))
{
  update();
}

void NodePositions::update()
{
  const std::span<const double> x = _V->mesh()->geometry().x();
  _values.resize(4 * (_nodes.empty() ? x.size() / 3 : _nodes.size()), 0.0);
  bool same = _version > 0;
  for (std::size_t i = 0; i < _values.size() / 4; ++i)
    if (const std::int64_t node = _nodes.empty() ? std::int64_t(i) : _nodes[i]; node >= 0)
    {
      const double *from = x.data() + 3 * node, *to = _values.data() + 4 * i;
      same = same && std::equal(from, from + 3, to);
      std::copy_n(from, 3, _values.data() + 4 * i);
    }
  static std::atomic<std::uint64_t> last = 0;
  if (!same)
    _version = ++last;
}
} // namespace dolfinx_impact::operators
