// SPDX-License-Identifier: MIT
#include "adjust_tie.h"
#include "../../common/agree.h"
#include "../../common/dolfinx_api.h"
#include "../../common/gather.h"
#include "../../operators/nodal_sums.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
double adjust_tie(dolfinx::mesh::Mesh<double>& mesh, const TieConditions& conditions)
{
  const surface::FunctionSpace& V = conditions.space();
  const auto map = V.dofmap()->index_map;
  const std::size_t g = conditions.gdim();
  const std::vector<double> apart = conditions.traction(conditions.offset()); // along the directions of the conditions
  std::vector<double> motion((map->size_local() + map->num_ghosts()) * g, 0.0);
  double largest = 0.0;
  for (std::size_t i = 0; i < conditions.num_nodes(); ++i)
  {
    double squared = 0.0;
    for (std::size_t c = 0; c < g; ++c)
    {
      motion[std::size_t(conditions.nodes()[i]) * g + c] = -apart[i * g + c];
      squared += apart[i * g + c] * apart[i * g + c];
    }
    largest = std::max(largest, std::sqrt(squared));
  }
  motion = operators::from_owners(map, std::move(motion), int(g));
  const auto nodes = V.dofmap()->map(), points = common::geometry_dofmap(mesh);
  const std::span<double> x = mesh.geometry().x();
  const std::vector<double> own = V.tabulate_dof_coordinates(false);
  common::agree(conditions.comm(),
                [&]
                {
                  bool same = nodes.extent(1) == points.extent(1);
                  for (std::size_t cell = 0; same && cell < nodes.extent(0); ++cell)
                    for (std::size_t i = 0; i < nodes.extent(1); ++i)
                      for (int c = 0; c < 3; ++c)
                        same = same && std::abs(own[3 * nodes(cell, i) + c] - x[3 * points(cell, i) + c]) <=
                                           1e-12 * conditions.size();
                  if (!same)
                    throw std::invalid_argument(
                        conditions.options().name +
                        ": adjust moves nodes of the mesh, which must be those of the displacements: take a space of "
                        "the degree of the geometry");
                });
  std::vector<std::int8_t> done(x.size() / 3, 0);
  for (std::size_t cell = 0; cell < nodes.extent(0); ++cell)
    for (std::size_t i = 0; i < nodes.extent(1); ++i)
    {
      const std::size_t point = points(cell, i), node = nodes(cell, i);
      for (std::size_t c = 0; c < g && !done[point]; ++c)
        x[3 * point + c] += motion[node * g + c];
      done[point] = 1;
    }
  return common::largest(conditions.comm(), largest);
}
} // namespace dolfinx_impact::enforcement
