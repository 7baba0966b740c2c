// SPDX-License-Identifier: MIT
#include "obstacle_side.h"
#include "../operators/nodal_sums.h"
#include "mortar.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace dolfinx_impact::gap
{
namespace
{
/// Longest side of the boxes around this rank's facets [L].
double longest_side(const surface::Facets& facets)
{
  const int n = facets.geometry.num_nodes(), gdim = facets.gdim;
  double longest = 0.0;
  for (std::size_t f = 0; f < facets.size(); ++f)
    for (int c = 0; c < gdim; ++c)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          longest = std::max(longest, facets.X_of(f)[i * gdim + c] - facets.X_of(f)[j * gdim + c]);
  return longest;
}
} // namespace

void check_side(const std::string& name, const surface::FunctionSpace& V, const surface::Facets& slave,
                const Rigid& obstacle)
{
  const MPI_Comm comm = V.mesh()->comm();
  const auto map = V.dofmap()->index_map;
  const int gdim = slave.gdim;
  const std::size_t num_nodes = map->size_local() + map->num_ghosts();
  std::vector<double> inward(num_nodes * gdim, 0.0), marks(num_nodes, 0.0);
  add_normals(slave, inward);
  for (std::int32_t node : slave.nodes)
    marks[node] = 1.0;
  // Sums over the facets of all ranks; every node is counted by its owner only.
  inward = operators::sum_over_ranks(map, std::move(inward), gdim);
  marks = operators::sum_over_ranks(map, std::move(marks), 1);
  const std::vector<double> x = V.tabulate_dof_coordinates(false);
  std::vector<double> gap, cosine; // of obstacle and slave at this rank's nodes
  for (std::int32_t node = 0; node < map->size_local(); ++node)
  {
    if (marks[node] == 0.0)
      continue;
    const RigidPoint p = evaluate(obstacle, std::span(x.data() + 3 * std::size_t(node), gdim));
    double product = 0.0, square = 0.0;
    for (int c = 0; c < gdim; ++c)
    {
      const double n = inward[std::size_t(node) * gdim + c];
      product += n * p.normal[c];
      square += n * n;
    }
    gap.push_back(p.gap);
    cosine.push_back(product / std::max(std::sqrt(square), 1e-300));
  }
  std::array<double, 3> least{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
                              -longest_side(slave)}; // distance, gap, minus the size of a facet
  for (double g : gap)
  {
    least[0] = std::min(least[0], std::abs(g));
    least[1] = std::min(least[1], g);
  }
  MPI_Allreduce(MPI_IN_PLACE, least.data(), 3, MPI_DOUBLE, MPI_MIN, comm);
  const double nearest = least[0], lowest = least[1], facet = -least[2];
  std::array<double, 2> sums{}; // of the cosines, and their number
  for (std::size_t i = 0; i < gap.size(); ++i)
    if (std::abs(gap[i]) <= nearest + facet)
    {
      sums[0] += cosine[i];
      sums[1] += 1.0;
    }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_DOUBLE, MPI_SUM, comm);
  // The mean is +1 for opposite normals, -1 for equal ones. Values between come from edges and from both sides of thin
  // bodies; they are accepted.
  if (sums[0] < -0.5 * sums[1] && lowest <= facet)
    throw std::invalid_argument(
        name + ": the slave's normals point away from the obstacle where it is nearest: " + obstacle.orientation_hint);
}
} // namespace dolfinx_impact::gap
