// SPDX-License-Identifier: MIT
#pragma once
#include "dolfinx_api.h"
#include <dolfinx/common/MPI.h>
#include <mpi.h>
#include <vector>

namespace dolfinx_impact::common
{
/// Numbers of all ranks one after the other, in the order of the ranks. Collective.
template <typename T>
std::vector<T> gather(MPI_Comm comm, const std::vector<T>& here)
{
  const MPI_Datatype type = common::mpi_type<T>();
  int size = 0, mine = int(here.size());
  MPI_Comm_size(comm, &size);
  std::vector<int> counts(size), starts(size + 1, 0);
  MPI_Allgather(&mine, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  for (int r = 0; r < size; ++r)
    starts[r + 1] = starts[r] + counts[r];
  std::vector<T> out(starts[size]);
  MPI_Allgatherv(here.data(), mine, type, out.data(), counts.data(), starts.data(), type, comm);
  return out;
}

inline double largest(MPI_Comm comm, double here)
{
  MPI_Allreduce(MPI_IN_PLACE, &here, 1, MPI_DOUBLE, MPI_MAX, comm);
  return here;
}

inline double sum(MPI_Comm comm, double here)
{
  MPI_Allreduce(MPI_IN_PLACE, &here, 1, MPI_DOUBLE, MPI_SUM, comm);
  return here;
}

inline long long sum(MPI_Comm comm, long long here)
{
  MPI_Allreduce(MPI_IN_PLACE, &here, 1, MPI_LONG_LONG, MPI_SUM, comm);
  return here;
}
} // namespace dolfinx_impact::common
