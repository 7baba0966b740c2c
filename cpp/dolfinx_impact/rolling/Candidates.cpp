// SPDX-License-Identifier: MIT
#include "Candidates.h"
#include <algorithm>

namespace dolfinx_impact::rolling
{
namespace
{
std::vector<int> times(std::vector<int> values, int factor)
{
  for (int& value : values)
    value *= factor;
  return values;
}
} // namespace

Candidates::Candidates(MPI_Comm comm, const std::vector<std::vector<std::int8_t>>& chosen) : _comm(comm)
{
  int here = 0, size = 0;
  for (const std::vector<std::int8_t>& mask : chosen)
  {
    std::vector<std::int32_t>& nodes = _local.emplace_back();
    for (std::size_t i = 0; i < mask.size(); ++i)
      if (mask[i])
        nodes.push_back(std::int32_t(i));
    here += int(nodes.size());
  }
  MPI_Comm_rank(comm, &_rank);
  MPI_Comm_size(comm, &size);
  _counts.resize(size);
  MPI_Allgather(&here, 1, MPI_INT, _counts.data(), 1, MPI_INT, comm);
  for (int count : _counts)
  {
    _starts.push_back(_count);
    _count += count;
  }
}

std::vector<double> Candidates::gather(const ByContact& values, int width) const
{
  std::vector<double> mine, out;
  for (std::size_t k = 0; k < _local.size(); ++k)
    for (std::int32_t node : _local[k])
      mine.insert(mine.end(), &values[k][std::size_t(node) * width], &values[k][std::size_t(node) * width] + width);
  const std::vector<int> counts = times(_counts, width), starts = times(_starts, width);
  if (_rank == 0)
    out.resize(std::size_t(_count) * width);
  MPI_Gatherv(mine.data(), int(mine.size()), MPI_DOUBLE, out.data(), counts.data(), starts.data(), MPI_DOUBLE, 0,
              _comm);
  return out;
}

std::vector<double> Candidates::gather(const std::vector<std::vector<std::int8_t>>& values, int width) const
{
  ByContact numbers;
  for (const std::vector<std::int8_t>& mask : values)
    numbers.emplace_back(mask.begin(), mask.end());
  return gather(numbers, width);
}

Candidates::ByContact Candidates::scatter(const std::vector<double>& values, const std::vector<std::size_t>& sizes,
                                          int width) const
{
  const std::vector<int> counts = times(_counts, width), starts = times(_starts, width);
  std::vector<double> mine(counts[_rank]);
  MPI_Scatterv(values.data(), counts.data(), starts.data(), MPI_DOUBLE, mine.data(), int(mine.size()), MPI_DOUBLE, 0,
               _comm);
  ByContact out;
  auto next = mine.begin();
  for (std::size_t k = 0; k < _local.size(); ++k)
  {
    out.emplace_back(sizes[k] * width, 0.0);
    for (std::int32_t node : _local[k])
    {
      std::copy_n(next, width, &out[k][std::size_t(node) * width]);
      next += width;
    }
  }
  return out;
}
} // namespace dolfinx_impact::rolling
