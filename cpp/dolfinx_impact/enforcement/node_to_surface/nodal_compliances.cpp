// SPDX-License-Identifier: MIT
#include "nodal_compliances.h"
#include "../../operators/nodal_sums.h"
#include "../../surface/cell_heights.h"
#include "../../surface/nodal.h"
#include "../../surface/smooth.h"
#include <algorithm>
#include <memory>
#include <utility>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Part of the stiffness of the outermost cells in uniaxial strain. A surface node has half of the mass of a layer;
/// with half of its stiffness it moves no faster than the mesh, and the force of an impact rings least.
constexpr double layer_part = 0.5;
/// Part of what the cells around a node count in the bound of the highest squared frequency (Irons and Treharne): what
/// steps of 0.9 of the stable one leave to contact, 1/0.9^2 - 1.
constexpr double room = 0.19 / 0.81;

/// Stiffness per area of the layer of nodes behind each facet: modulus of uniaxial strain over height [F/L^3].
std::vector<double> layer_stiffness(const surface::FunctionSpace& V, const surface::Facets& facets,
                                    std::span<const double> moduli)
{
  const int degree = V.element()->basix_element().degree();
  const std::vector<std::int32_t> cells = surface::cells_behind(V, facets);
  const std::vector<double> heights = surface::cell_heights(V, facets);
  std::vector<double> out;
  for (std::size_t f = 0; f < facets.size(); ++f)
    out.push_back(moduli[cells[f]] * degree / heights[f]);
  return out;
}

/// Which nodes, owned and ghosts, some facets of any rank have. Collective.
std::vector<std::int8_t> nodes_of(const std::shared_ptr<const dolfinx::common::IndexMap>& map,
                                  std::span<const surface::Facets> sides)
{
  std::vector<double> counts(map->size_local() + map->num_ghosts(), 0.0);
  for (const surface::Facets& side : sides)
    for (const std::int32_t node : side.nodes)
      counts[node] = 1.0;
  counts = operators::sum_over_ranks(map, std::move(counts), 1);
  std::vector<std::int8_t> out(counts.size());
  std::ranges::transform(counts, out.begin(), [](double count) { return std::int8_t(count > 0.0); });
  return out;
}

/// Compliances of the nodes of one surface. Collective.
/// @param[in] bound FrequencyStiffness of the nodes
std::vector<double> compliances_of(const surface::FunctionSpace& V, const surface::Facets& side, bool axisymmetric,
                                   std::optional<std::span<const double>> moduli, std::span<const double> bound)
{
  const auto map = V.dofmap()->index_map;
  std::vector<double> factors(side.size(), 1.0), sums(map->size_local() + map->num_ghosts(), 0.0);
  if (moduli)
  {
    factors = layer_stiffness(V, side, *moduli);
    for (double& factor : factors)
      factor *= layer_part;
  }
  surface::add_nodal_areas(side, axisymmetric, sums, factors);
  sums = operators::sum_over_ranks(map, std::move(sums), 1);
  std::vector<double> out(map->size_local(), 0.0);
  for (std::size_t node = 0; node < out.size(); ++node)
  {
    const double most = room * bound[node];
    const double stiffness = !(sums[node] > 0.0) ? 0.0 : moduli ? std::min(sums[node], most) : most;
    if (stiffness > 0.0)
      out[node] = 1.0 / stiffness;
  }
  return out;
}
} // namespace

NodalCompliances nodal_compliances(const surface::FunctionSpace& V, const NodeToSurface& contact,
                                   std::optional<std::span<const double>> moduli,
                                   const FrequencyStiffness& frequency_stiffness)
{
  std::vector<surface::Facets> sides{contact.candidates().slave()};
  if (!contact.obstacle())
    sides.push_back(surface::flat(contact.candidates().master()));
  const std::vector<double> bound = frequency_stiffness(nodes_of(V.dofmap()->index_map, sides));
  const bool axisymmetric = contact.options().axisymmetric;
  NodalCompliances out;
  out.slave = compliances_of(V, sides[0], axisymmetric, moduli, bound);
  out.master = sides.size() == 1 ? std::vector<double>(out.slave.size(), 0.0)
                                 : compliances_of(V, sides[1], axisymmetric, moduli, bound);
  return out;
}

std::vector<double> nodal_compliances(const surface::FunctionSpace& V, const surface::Facets& facets,
                                      std::optional<std::span<const double>> moduli,
                                      const FrequencyStiffness& frequency_stiffness, bool axisymmetric)
{
  const std::vector<double> bound = frequency_stiffness(nodes_of(V.dofmap()->index_map, std::span(&facets, 1)));
  return compliances_of(V, facets, axisymmetric, moduli, bound);
}
} // namespace dolfinx_impact::enforcement
