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

InitialPenetration::InitialPenetration(std::string name, const surface::FunctionSpace& V, const surface::Facets& slave,
                                       const surface::Facets* master, std::span<const double> x,
                                       std::span<const double> gap, bool remove)
    : _name(std::move(name)), _remove(remove), _offset(gap.size(), 0.0)
{
  const MPI_Comm comm = V.mesh()->comm();
  const std::size_t gdim = slave.gdim;
  const double least = round_off * operators::body_size(*V.mesh());
  double shallowest = infinity;
  std::size_t deepest = 0;
  std::int64_t number = 0;
  for (std::size_t i = 0; i < gap.size(); ++i)
  {
    const double penetration = std::max(0.0, -gap[i]);
    number += penetration > least;
    if (std::isfinite(gap[i]))
      shallowest = std::min(shallowest, penetration);
    if (gap[i] < gap[deepest])
      deepest = i;
    if (remove && penetration > least)
      _offset[i] = penetration;
  }
  MPI_Allreduce(&number, &_num_points, 1, MPI_INT64_T, MPI_SUM, comm);
  MPI_Allreduce(MPI_IN_PLACE, &shallowest, 1, MPI_DOUBLE, MPI_MIN, comm);
  if (_num_points > 0)
  {
    struct
    {
      double depth = -1.0;
      int rank;
    } mine, most;
    MPI_Comm_rank(comm, &mine.rank);
    if (!gap.empty())
      mine.depth = std::max(0.0, -gap[deepest]);
    MPI_Allreduce(&mine, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, comm);
    _depth = most.depth;
    _where.resize(gdim);
    if (mine.rank == most.rank)
      std::copy_n(x.begin() + deepest * gdim, gdim, _where.begin());
    MPI_Bcast(_where.data(), int(gdim), MPI_DOUBLE, most.rank, comm);
  }
  if (_num_points == 0 || !std::isfinite(shallowest) || !(shallowest > 0.0))
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
  if (_where.empty())
    return "";
  std::vector<double> place = _where;
  for (double& value : place) // no -0, and no digits of round-off
    value = std::round(value * 1e12) / 1e12 + 0.0;
  return _name + ": " + std::to_string(_num_points) + " points penetrate before anything is loaded, by up to " +
         common::text("%.3e", _depth) + " at (" + common::components(place) + ")" +
         (_remove ? ": removed, gaps count from there" : "");
}
} // namespace dolfinx_impact::gap
