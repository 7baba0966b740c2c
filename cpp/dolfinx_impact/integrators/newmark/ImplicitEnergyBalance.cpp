// SPDX-License-Identifier: MIT
#include "ImplicitEnergyBalance.h"

namespace dolfinx_impact::integrators
{
void ImplicitEnergyBalance::add_step(MPI_Comm comm, Forces forces, std::span<const double> before,
                                     std::span<const double> after, std::span<const std::array<double, 3>> from,
                                     std::span<const std::array<double, 3>> to,
                                     std::span<const std::array<double, 3>> turned)
{
  std::array<double, 3> sums{};
  for (std::size_t i = 0; i < before.size(); ++i)
  {
    const double moved = 0.5 * (after[i] - before[i]);
    sums[0] += (_forces.internal[i] + forces.internal[i]) * moved;
    sums[1] += (_forces.external[i] + forces.external[i] + _forces.support[i] + forces.support[i]) * moved;
    sums[2] += (_forces.damping[i] + forces.damping[i]) * moved;
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 3, MPI_DOUBLE, MPI_SUM, comm);
  // Forces of obstacles are sums over all ranks already.
  for (std::size_t k = 0; k < from.size(); ++k)
    for (int c = 0; c < 3; ++c)
    {
      sums[1] += 0.5 * (_forces.obstacles[k][c] + forces.obstacles[k][c]) * (to[k][c] - from[k][c]);
      sums[1] -= 0.5 * (_forces.torques[k][c] + forces.torques[k][c]) * turned[k][c];
    }
  _works.internal += sums[0];
  _works.external += sums[1];
  _works.damping += sums[2];
  _forces = std::move(forces);
}
} // namespace dolfinx_impact::integrators
