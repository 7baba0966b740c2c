// SPDX-License-Identifier: MIT
#include "body_size.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mpi.h>

namespace dolfinx_impact::operators
{
double body_size(const dolfinx::mesh::Mesh<double>& mesh)
{
  std::array<double, 6> box; // largest -x and largest x
  box.fill(-std::numeric_limits<double>::infinity());
  const auto x = mesh.geometry().x();
  for (std::size_t i = 0; i < x.size(); ++i)
  {
    box[i % 3] = std::max(box[i % 3], -x[i]);
    box[3 + i % 3] = std::max(box[3 + i % 3], x[i]);
  }
  MPI_Allreduce(MPI_IN_PLACE, box.data(), 6, MPI_DOUBLE, MPI_MAX, mesh.comm());
  return std::hypot(box[0] + box[3], box[1] + box[4], box[2] + box[5]);
}
} // namespace dolfinx_impact::operators
