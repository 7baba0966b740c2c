// SPDX-License-Identifier: MIT
#include "agree.h"
#include "OnAllRanks.h"
#include <stdexcept>
#include <string>

namespace dolfinx_impact::common
{
void agree(MPI_Comm comm, const std::function<void()>& act)
{
  int size = 0, rank = 0;
  MPI_Comm_size(comm, &size);
  MPI_Comm_rank(comm, &rank);
  if (size == 1)
  {
    act();
    return;
  }
  std::string text;
  int failed = size, bad_value = 0;
  try
  {
    act();
  }
  catch (const std::logic_error& e) // std::invalid_argument among them
  {
    text = e.what(), failed = rank, bad_value = 1;
  }
  catch (const std::exception& e)
  {
    text = e.what(), failed = rank;
  }
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MIN, comm);
  if (failed == size)
    return;
  int told[2] = {bad_value, int(text.size())};
  MPI_Bcast(told, 2, MPI_INT, failed, comm);
  text.resize(told[1]);
  MPI_Bcast(text.data(), told[1], MPI_CHAR, failed, comm);
  text = "rank " + std::to_string(failed) + ": " + text;
  if (told[0])
    throw BadValue(text);
  throw Failure(text);
}
} // namespace dolfinx_impact::common
