// SPDX-License-Identifier: MIT
#include "InitialPenetration.h"
#include "../common/text.h"
#include "../operators/RigidBodyModes.h"
#include "../operators/body_size.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace dolfinx_impact::gap
{
namespace
{
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Penetrations below this part of the bodies' size are round-off of coordinates that come from files or from gmsh.
constexpr double round_off = 1e-10;

/// Shortest side of the boxes around the bodies that have nodes of the surfaces [L]. Collective.
double thinner_body(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master)
{
  const operators::Bodies bodies = operators::bodies(V);
  const int gdim = slave.gdim, columns = 2 * gdim + 1;
  const std::vector<double> x = V.tabulate_dof_coordinates(false);
  // Of each body: largest x and -x of its nodes, and whether it has nodes of the surfaces.
  std::vector<double> boxes(std::size_t(bodies.count) * columns, -infinity);
  const auto box = [&](std::int32_t node) { return boxes.data() + std::size_t(bodies.number[node]) * columns; };
  for (std::int32_t node = 0; node < V.dofmap()->index_map->size_local(); ++node)
    for (int c = 0; c < gdim; ++c)
    {
      const double value = x[3 * std::size_t(node) + c];
      box(node)[c] = std::max(box(node)[c], value);
      box(node)[gdim + c] = std::max(box(node)[gdim + c], -value);
    }
  for (const surface::Facets* facets : {&slave, master})
    if (facets)
      for (std::int32_t node : facets->nodes)
        box(node)[2 * gdim] = 1.0;
  MPI_Allreduce(MPI_IN_PLACE, boxes.data(), int(boxes.size()), MPI_DOUBLE, MPI_MAX, V.mesh()->comm());
  double thinner = infinity;
  for (int b = 0; b < bodies.count; ++b)
    if (const double* sides = boxes.data() + std::size_t(b) * columns; sides[2 * gdim] > 0.0)
      for (int c = 0; c < gdim; ++c)
        thinner = std::min(thinner, sides[c] + sides[gdim + c]);
  return thinner;
}
} // namespace

InitialPenetration::Largest InitialPenetration::largest(MPI_Comm comm, int gdim, std::span<const double> x,
                                                        std::span<const double> values, double least)
{
  Largest out;
  const std::int64_t number = std::ranges::count_if(values, [least](double value) { return value > least; });
  MPI_Allreduce(&number, &out.num_points, 1, MPI_INT64_T, MPI_SUM, comm);
  if (out.num_points == 0)
    return out;
  struct
  {
    double size = -1.0;
    int rank;
  } mine, most;
  MPI_Comm_rank(comm, &mine.rank);
  const auto farthest = std::ranges::max_element(values);
  if (farthest != values.end())
    mine.size = *farthest;
  MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, comm);
  out.size = most.size;
  out.where.resize(gdim);
  if (mine.rank == most.rank)
    std::copy_n(x.begin() + (farthest - values.begin()) * gdim, gdim, out.where.begin());
  MPI_Bcast(out.where.data(), gdim, MPI_DOUBLE, most.rank, comm);
  return out;
}

InitialPenetration::InitialPenetration(std::string name, const surface::FunctionSpace& V, const surface::Facets& slave,
                                       const surface::Facets* master, std::span<const double> x,
                                       std::span<const double> gap, const GapAdjustment& adjustment)
    : _name(std::move(name)), _adjustment(adjustment), _offset(gap.size(), -adjustment.offset)
{
  const MPI_Comm comm = V.mesh()->comm();
  const double least = round_off * operators::body_size(*V.mesh()), target = adjustment.clearance.value_or(0.0);
  // Gaps up to the limit are adjusted; overlaps within round-off of it count as gaps of its size.
  const double limit = adjustment.adjust ? *adjustment.adjust + least : infinity;
  double shallowest = infinity;
  std::vector<double> depths(gap.size()), moved(gap.size(), 0.0);
  for (std::size_t i = 0; i < gap.size(); ++i)
  {
    const double own = gap[i] - adjustment.offset;
    depths[i] = std::max(0.0, -own);
    if (!std::isfinite(gap[i]))
      continue;
    shallowest = std::min(shallowest, std::max(0.0, -gap[i]));
    if (!adjustment.adjusts() || own > limit || !(std::abs(target - own) > least))
      continue;
    if (adjustment.adjust == 0.0 && !(own < -least)) // touching points, which only overlaps are to become
      continue;
    moved[i] = std::abs(target - own);
    _offset[i] = target - gap[i];
  }
  _deepest = largest(comm, slave.gdim, x, depths, least);
  _farthest = largest(comm, slave.gdim, x, moved, least);
  MPI_Allreduce(MPI_IN_PLACE, &shallowest, 1, MPI_DOUBLE, MPI_MIN, comm);
  if (!std::isfinite(shallowest) || !(shallowest > least))
    return;
  if (const double thinner = thinner_body(V, slave, master); shallowest > 0.5 * thinner)
    throw std::invalid_argument(_name + ": every slave point lies at least " + common::text("%.3e", shallowest) +
                                " inside the master before anything is loaded, more than half of the thinner body (" +
                                common::text("%.3e", thinner) +
                                "): move the bodies apart, or correct the tags, the normal of a plane or the sign of a "
                                "radius");
}

std::string InitialPenetration::warning() const
{
  const auto at = [](std::vector<double> place)
  {
    for (double& value : place) // no -0, and no digits of round-off
      value = std::round(value * 1e12) / 1e12 + 0.0;
    return " at (" + common::components(place) + ")";
  };
  std::vector<std::string> texts;
  const bool removed = _adjustment.removes_penetration();
  if (!_deepest.where.empty())
    texts.push_back(std::to_string(_deepest.num_points) + " points penetrate before anything is loaded, by up to " +
                    common::text("%.3e", _deepest.size) + at(_deepest.where) +
                    (removed ? ": removed, gaps count from there" : ""));
  if (!removed && !_farthest.where.empty())
    texts.push_back("the gaps of " + std::to_string(_farthest.num_points) + " points are adjusted to " +
                    common::text("%.4g", _adjustment.clearance.value_or(0.0)) +
                    " before anything is loaded, by up to " + common::text("%.3e", _farthest.size) +
                    at(_farthest.where));
  return texts.empty() ? "" : _name + ": " + common::joined(texts);
}
} // namespace dolfinx_impact::gap
