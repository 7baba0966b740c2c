// SPDX-License-Identifier: MIT
#include "crossing.h"
#include "../common/text.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::gap
{
namespace
{
/// A path through an obstacle is followed in steps of the distance from it, which cannot miss it, but of no less than
/// this part of the path where the distance is small.
constexpr double least_step = 1.0 / 1024;
/// States between start and end of an increment at which gaps against a deformable master are evaluated.
constexpr int samples = 8;
/// Depth, in slave facets, from which on a point that loses its master has passed through it: points that slide off the
/// master's edge lie less deep, as contact holds them at its surface.
constexpr double deep = 0.25;

/// Does the path of a point that is open at its end lead through the obstacle?
bool passes(const Rigid& obstacle, const double* start, const double* end, double offset, double tolerance)
{
  const int gdim = obstacle.gdim;
  double way[3], x[3], length = 0.0;
  for (int c = 0; c < gdim; ++c)
  {
    way[c] = end[c] - start[c];
    length += way[c] * way[c];
  }
  length = std::sqrt(length);
  const RigidPoint last = evaluate(obstacle, {end, std::size_t(gdim)});
  // A distance changes by no more than the way: most points cannot have touched the obstacle on it.
  if (!(last.gap + offset > tolerance && length > last.gap))
    return false;
  const RigidPoint first = evaluate(obstacle, {start, std::size_t(gdim)});
  double facing = 0.0;
  for (int c = 0; c < gdim; ++c)
    facing += first.normal[c] * last.normal[c];
  if (!(facing < 0.0))
    return false;
  for (double place = 0.0; place < 1.0;)
  {
    for (int c = 0; c < gdim; ++c)
      x[c] = start[c] + place * way[c];
    const RigidPoint here = evaluate(obstacle, {x, std::size_t(gdim)});
    double along = 0.0;
    for (int c = 0; c < gdim; ++c)
      along += here.normal[c] * way[c];
    if (here.gap + offset < (along < 0.0 ? tolerance : -tolerance))
      return true;
    place += std::max(here.gap / length, least_step);
  }
  return false;
}
} // namespace

std::vector<std::int8_t> through_obstacle(const Rigid& obstacle, std::span<const double> start,
                                          std::span<const double> end, std::span<const double> offset, double tolerance)
{
  std::vector<std::int8_t> passed(offset.size());
  for (std::size_t i = 0; i < passed.size(); ++i)
    passed[i] =
        passes(obstacle, start.data() + i * obstacle.gdim, end.data() + i * obstacle.gdim, offset[i], tolerance);
  return passed;
}

std::vector<std::int8_t> through_master(MPI_Comm comm, std::span<const std::int8_t> suspects,
                                        std::span<const double> sizes,
                                        const std::function<std::vector<double>(double)>& gap_at)
{
  std::vector<std::int8_t> passed(suspects.size(), 0);
  int any = std::ranges::any_of(suspects, [](std::int8_t s) { return s != 0; });
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, comm);
  if (!any)
    return passed;
  std::vector<double> last(suspects.size(), 0.0); // the last gap that a point has on its way
  for (int k = 1; k < samples; ++k)
  {
    const std::vector<double> gap = gap_at(double(k) / samples);
    for (std::size_t i = 0; i < last.size(); ++i)
      if (std::isfinite(gap[i]))
        last[i] = gap[i];
  }
  for (std::size_t i = 0; i < passed.size(); ++i)
    passed[i] = suspects[i] && last[i] < -deep * sizes[i];
  return passed;
}

std::string describe_crossing(const std::string& name, MPI_Comm comm, int gdim, std::span<const double> x,
                              std::span<const std::int8_t> passed)
{
  const std::size_t first = std::ranges::find_if(passed, [](std::int8_t p) { return p != 0; }) - passed.begin();
  std::int64_t number = std::ranges::count_if(passed, [](std::int8_t p) { return p != 0; });
  int rank = 0, size = 0;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  int lowest = number > 0 ? rank : size;
  MPI_Allreduce(MPI_IN_PLACE, &number, 1, MPI_INT64_T, MPI_SUM, comm);
  MPI_Allreduce(MPI_IN_PLACE, &lowest, 1, MPI_INT, MPI_MIN, comm);
  if (number == 0)
    return "";
  double place[3] = {};
  if (rank == lowest)
    std::copy_n(x.data() + first * gdim, gdim, place);
  MPI_Bcast(place, gdim, MPI_DOUBLE, lowest, comm);
  return name + ": " + std::to_string(number) +
         " points have passed through the master in this increment and are open on its far side, one is at (" +
         common::components({place, std::size_t(gdim)}) + ")";
}
} // namespace dolfinx_impact::gap
