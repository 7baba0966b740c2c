// SPDX-License-Identifier: MIT
#include "release_limit.h"
#include "../integrators/stable_step.h"
#include "failed_run.h"
#include <array>
#include <cmath>
#include <limits>
#include <mpi.h>

namespace dolfinx_impact::problems
{
double release_limit(const dolfinx::fem::FunctionSpace<double>& V, std::span<const double> stiffness)
{
  const auto& mesh = *V.mesh();
  const int gdim = mesh.geometry().dim();
  std::array<double, 3> sums{}; // of stiffnesses, squared sizes, cells
  for (const double k : stiffness)
    sums[0] += k;
  for (const double size : integrators::cell_sizes(mesh))
  {
    sums[1] += size * size;
    sums[2] += 1.0;
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 3, MPI_DOUBLE, MPI_SUM, mesh.comm());
  const bool displacement = V.element()->num_sub_elements() == gdim && V.dofmap()->bs() == gdim;
  if (!displacement || !(sums[0] > 0.0) || !std::isfinite(sums[0]))
    return std::numeric_limits<double>::infinity();
  return 0.5 * sums[0] / gdim * start_strain * start_strain * sums[1] / sums[2];
}
} // namespace dolfinx_impact::problems
