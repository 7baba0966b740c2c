// SPDX-License-Identifier: MIT
#include "cell_ghosts.h"
#include <dolfinx/fem/DofMap.h>
#include <dolfinx/mesh/Mesh.h>

namespace dolfinx_impact::operators
{
std::vector<std::int8_t> cell_ghosts(const dolfinx::fem::FunctionSpace<double>& V)
{
  const auto& dofmap = *V.dofmap();
  const auto& topology = *V.mesh()->topology();
  const std::int32_t owned = dofmap.index_map->size_local(), cells = topology.index_map(topology.dim())->size_local();
  const int bs = dofmap.bs(), map_bs = dofmap.index_map_bs();
  std::vector<std::int8_t> out(dofmap.index_map->num_ghosts(), 0);
  for (std::int32_t cell = 0; cell < cells; ++cell)
    for (const std::int32_t dof : dofmap.cell_dofs(cell))
      for (int k = 0; k < bs; ++k)
        if (const std::int32_t node = (dof * bs + k) / map_bs; node >= owned)
          out[node - owned] = 1;
  return out;
}
} // namespace dolfinx_impact::operators
