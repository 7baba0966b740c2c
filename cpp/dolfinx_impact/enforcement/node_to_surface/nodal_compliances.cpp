// SPDX-License-Identifier: MIT
#include "nodal_compliances.h"
#include "../../common/dolfinx_api.h"
#include "../../operators/nodal_sums.h"
#include "../../surface/nodal.h"
#include "../../surface/smooth.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <dolfinx/mesh/cell_types.h>
#include <stdexcept>
#include <unordered_map>

namespace dolfinx_impact::enforcement
{
namespace
{
using surface::FacetShape;

/// Part of the stiffness of the outermost cells in uniaxial strain. A surface node has half of the mass of a layer;
/// with half of its stiffness it moves no faster than the mesh, and the force of an impact rings least.
constexpr double layer_part = 0.5;
/// Part of what the cells around a node count in the bound of the highest squared frequency (Irons and Treharne): what
/// steps of 0.9 of the stable one leave to contact, 1/0.9^2 - 1.
constexpr double room = 0.19 / 0.81;

/// Cell of each facet, by its number on this rank.
std::vector<std::int32_t> cells_of(const dolfinx::mesh::Topology& topology, const surface::Facets& facets)
{
  const auto map = topology.index_map(topology.dim());
  // A submesh has no input: its cells count by their global numbers, as in Surface.
  const std::vector<std::int64_t> numbers =
      topology.original_cell_index.empty() ? map->global_indices() : topology.original_cell_index.front();
  std::unordered_map<std::int64_t, std::int32_t> found;
  for (const std::int64_t id : facets.id)
    found.try_emplace(id / 8, -1);
  for (std::size_t cell = 0; cell < numbers.size(); ++cell)
    if (const auto place = found.find(numbers[cell]); place != found.end())
      place->second = std::int32_t(cell);
  std::vector<std::int32_t> out;
  for (const std::int64_t id : facets.id)
    out.push_back(found.at(id / 8));
  return out;
}

/// A vector normal to a facet, of any length: that of the facet's edges (quadrilaterals: of its diagonals).
std::array<double, 3> normal_of(const surface::Facets& facets, std::size_t f)
{
  const double* X = facets.X_of(f);
  const auto between = [&](int from, int to)
  {
    std::array<double, 3> out{};
    for (int c = 0; c < facets.gdim; ++c)
      out[c] = X[to * facets.gdim + c] - X[from * facets.gdim + c];
    return out;
  };
  if (facets.gdim == 2)
  {
    const auto along = between(0, 1);
    return {along[1], -along[0], 0.0};
  }
  const bool triangle = facets.geometry.shape == FacetShape::triangle; // corners of others are those of a product
  const auto a = triangle ? between(0, 1) : between(0, 3), b = triangle ? between(0, 2) : between(1, 2);
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Stiffness per area of the layer of nodes behind each facet: modulus of uniaxial strain over height [F/L^3].
std::vector<double> layer_stiffness(const surface::FunctionSpace& V, const surface::Facets& facets,
                                    std::span<const double> moduli)
{
  const auto& mesh = *V.mesh();
  const auto& topology = *mesh.topology();
  const auto type = topology.cell_type();
  const int gdim = mesh.geometry().dim(), degree = V.element()->basix_element().degree();
  const int num_vertices = dolfinx::mesh::num_cell_vertices(type);
  const bool simplex = type == dolfinx::mesh::CellType::triangle || type == dolfinx::mesh::CellType::tetrahedron;
  const int num_corners = facets.geometry.shape == FacetShape::interval   ? 2
                          : facets.geometry.shape == FacetShape::triangle ? 3
                                                                          : 4;
  const auto dofs = common::geometry_dofmap(mesh);
  const std::span<const double> x = mesh.geometry().x();
  const std::vector<std::int32_t> cells = cells_of(topology, facets);
  std::vector<double> out;
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    const std::array<double, 3> normal = normal_of(facets, f);
    double distance = 0.0;
    for (int c = 0; c < gdim; ++c)
    {
      double cell_centre = 0.0, facet_centre = 0.0;
      for (int i = 0; i < num_vertices; ++i)
        cell_centre += x[3 * std::size_t(dofs(cells[f], i)) + c] / num_vertices;
      for (int i = 0; i < num_corners; ++i)
        facet_centre += facets.X_of(f)[i * gdim + c] / num_corners;
      distance += normal[c] * (cell_centre - facet_centre);
    }
    distance = std::abs(distance) / std::hypot(normal[0], normal[1], normal[2]);
    const double height = (simplex ? num_vertices : 2) * distance;
    out.push_back(moduli[cells[f]] * degree / height);
  }
  return out;
}
} // namespace

NodalCompliances nodal_compliances(const surface::FunctionSpace& V, const NodeToSurface& contact,
                                   std::optional<std::span<const double>> moduli,
                                   const FrequencyStiffness& frequency_stiffness)
{
  const auto map = V.dofmap()->index_map;
  const std::size_t owned = map->size_local(), num_nodes = owned + map->num_ghosts();
  std::vector<surface::Facets> sides{contact.candidates().slave()};
  if (!contact.obstacle())
    sides.push_back(surface::flat(contact.candidates().master()));
  std::vector<double> surface(num_nodes, 0.0);
  for (const surface::Facets& side : sides)
    for (const std::int32_t node : side.nodes)
      surface[node] = 1.0;
  surface = operators::sum_over_ranks(map, std::move(surface), 1);
  std::vector<std::int8_t> nodes(num_nodes);
  std::ranges::transform(surface, nodes.begin(), [](double count) { return std::int8_t(count > 0.0); });
  const std::vector<double> bound = frequency_stiffness(nodes);
  NodalCompliances out{std::vector<double>(owned, 0.0), std::vector<double>(owned, 0.0)};
  for (std::size_t k = 0; k < sides.size(); ++k)
  {
    std::vector<double> factors(sides[k].size(), 1.0), sums(num_nodes, 0.0);
    if (moduli)
    {
      factors = layer_stiffness(V, sides[k], *moduli);
      for (double& factor : factors)
        factor *= layer_part;
    }
    surface::add_nodal_areas(sides[k], contact.options().axisymmetric, sums, factors);
    sums = operators::sum_over_ranks(map, std::move(sums), 1);
    for (std::size_t node = 0; node < owned; ++node)
    {
      const double most = room * bound[node];
      const double stiffness = !(sums[node] > 0.0) ? 0.0 : moduli ? std::min(sums[node], most) : most;
      if (stiffness > 0.0)
        (k == 0 ? out.slave : out.master)[node] = 1.0 / stiffness;
    }
  }
  return out;
}
} // namespace dolfinx_impact::enforcement
