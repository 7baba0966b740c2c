// SPDX-License-Identifier: MIT
#include "resultant.h"
#include "../common/agree.h"
#include <algorithm>
#include <mpi.h>
#include <stdexcept>
#include <vector>

namespace dolfinx_impact::operators
{
Resultant resultant(const dolfinx::fem::FunctionSpace<double>& V, std::span<const double> u,
                    std::span<const double> forces, std::span<const std::int32_t> dofs,
                    const std::array<double, 3>& point)
{
  const auto& map = *V.dofmap()->index_map;
  const int bs = V.dofmap()->index_map_bs();
  const std::int32_t owned = map.size_local() * bs, known = owned + std::int32_t(map.num_ghosts()) * bs;
  const std::vector<double> x = V.tabulate_dof_coordinates(false);
  std::array<double, 6> sums{};
  common::agree(V.mesh()->comm(),
                [&]
                {
                  if (std::ssize(u) < owned || std::ssize(forces) < owned)
                    throw std::invalid_argument("displacements and forces need a value for each degree of freedom");
                  std::vector<std::int32_t> sorted(dofs.begin(), dofs.end());
                  std::ranges::sort(sorted);
                  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
                  for (const std::int32_t dof : sorted)
                  {
                    if (dof < 0 || dof >= known)
                      throw std::invalid_argument("degree of freedom " + std::to_string(dof) +
                                                  " is none of this rank's");
                    if (dof >= owned)
                      continue;
                    const std::int32_t node = dof / bs;
                    std::array<double, 3> arm{}, force{};
                    for (int c = 0; c < 3; ++c)
                      arm[c] = x[3 * node + c] + (c < bs ? u[node * bs + c] : 0.0) - point[c];
                    force[dof % bs] = forces[dof];
                    for (int c = 0; c < 3; ++c)
                    {
                      const int a = (c + 1) % 3, b = (c + 2) % 3;
                      sums[c] += force[c];
                      sums[3 + c] += arm[a] * force[b] - arm[b] * force[a];
                    }
                  }
                });
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 6, MPI_DOUBLE, MPI_SUM, V.mesh()->comm());
  return {{sums[0], sums[1], sums[2]}, {sums[3], sums[4], sums[5]}};
}
} // namespace dolfinx_impact::operators
