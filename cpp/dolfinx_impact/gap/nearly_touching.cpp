// SPDX-License-Identifier: MIT
#include "nearly_touching.h"
#include <algorithm>
#include <cmath>
#include <limits>

namespace dolfinx_impact::gap
{
namespace
{
/// Bodies nearly touch if the gap is less than this part of a facet. On a round body of radius R the distance between a
/// facet of size h and its arc is h^2/(8 R), a hundredth of h on meshes with 70 facets around.
constexpr double nearly = 0.01;
} // namespace

std::optional<double> nearly_touching(MPI_Comm comm, std::span<const double> gap, std::span<const double> size)
{
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double largest = -infinity;
  for (std::size_t i = 0; i < gap.size(); ++i)
    if (gap[i] < nearly * size[i])
      largest = std::max(largest, gap[i]);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm);
  if (!std::isfinite(largest))
    return {};
  return std::nextafter(largest, infinity);
}
} // namespace dolfinx_impact::gap
