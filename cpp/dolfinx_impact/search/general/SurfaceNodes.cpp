// SPDX-License-Identifier: MIT
#include "SurfaceNodes.h"
#include "../../common/agree.h"
#include "../../common/dolfinx_api.h"
#include "../../operators/RigidBodyModes.h"
#include "../../surface/cell_heights.h"
#include <algorithm>
#include <dolfinx/la/Vector.h>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::search
{
namespace
{
/// Bits of a double's mantissa, in which groups are sent, are the named surfaces, two for each pair.
constexpr std::size_t most_named_pairs = 26;

/// Largest of the values that all ranks have for the nodes that this one owns, zero or more. Collective.
/// @param[in] values of owned and ghost nodes
std::vector<double> largest_of_ranks(const surface::FunctionSpace& V, const std::vector<double>& values)
{
  const auto map = V.dofmap()->index_map;
  dolfinx::la::Vector<double> all(map, 1);
  std::ranges::copy(values, common::array(all).begin());
  all.scatter_rev([](double a, double b) { return std::max(a, b); });
  return {all.array().begin(), all.array().begin() + map->size_local()};
}
} // namespace

SurfaceNodes::SurfaceNodes(const surface::FunctionSpace& V, const surface::Facets& facets,
                           std::span<const NamedPair> named)
    : num_named(named.size())
{
  common::agree(V.mesh()->comm(),
                [&]
                {
                  if (num_named > most_named_pairs)
                    throw std::invalid_argument("general contact beside " + std::to_string(num_named) +
                                                " pairs of surfaces: it can leave out " +
                                                std::to_string(most_named_pairs));
                });
  const auto map = V.dofmap()->index_map;
  const std::size_t owned = map->size_local(), all = owned + map->num_ghosts();
  const std::vector<double> heights = surface::cell_heights(V, facets);
  std::vector<double> reciprocals(all, 0.0);
  for (std::size_t f = 0; f < facets.size(); ++f)
    for (int i = 0; i < facets.displacement.num_nodes(); ++i)
    {
      double& at = reciprocals[facets.nodes_of(f)[i]];
      at = std::max(at, 1.0 / heights[f]);
    }
  height = largest_of_ranks(V, reciprocals);
  for (double& value : height)
    value = value > 0.0 ? 1.0 / value : 0.0;
  groups.assign(owned, 0);
  std::int64_t bit = 1;
  for (const NamedPair& pair : named)
    for (const surface::Facets* side : {&pair.slave, &pair.master})
    {
      std::vector<double> on(all, 0.0);
      for (const std::int32_t node : side->nodes)
        on[node] = 1.0;
      on = largest_of_ranks(V, on);
      for (std::size_t node = 0; node < owned; ++node)
        groups[node] |= on[node] > 0.0 ? bit : 0;
      bit <<= 1;
    }
  operators::Bodies bodies = operators::bodies(V);
  num_bodies = bodies.count;
  bodies.number.resize(owned);
  body = std::move(bodies.number);
}

bool SurfaceNodes::left_out(std::int64_t one, std::int64_t other) const
{
  for (std::size_t pair = 0; pair < num_named; ++pair)
  {
    const std::int64_t slave = std::int64_t(1) << (2 * pair), master = slave << 1;
    if (((one & slave) && (other & master)) || ((one & master) && (other & slave)))
      return true;
  }
  return false;
}
} // namespace dolfinx_impact::search
