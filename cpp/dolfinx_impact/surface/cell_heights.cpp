// SPDX-License-Identifier: MIT
#include "cell_heights.h"
#include "../common/dolfinx_api.h"
#include <array>
#include <cmath>
#include <dolfinx/mesh/cell_types.h>
#include <unordered_map>

namespace dolfinx_impact::surface
{
namespace
{
/// A vector normal to a facet, of any length: that of the facet's edges (quadrilaterals: of its diagonals).
std::array<double, 3> normal_of(const Facets& facets, std::size_t f)
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
} // namespace

std::vector<std::int32_t> cells_behind(const FunctionSpace& V, const Facets& facets)
{
  const auto& topology = *V.mesh()->topology();
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

std::vector<double> cell_heights(const FunctionSpace& V, const Facets& facets)
{
  const auto& mesh = *V.mesh();
  const auto type = mesh.topology()->cell_type();
  const int gdim = mesh.geometry().dim();
  const int num_vertices = dolfinx::mesh::num_cell_vertices(type);
  const bool simplex = type == dolfinx::mesh::CellType::triangle || type == dolfinx::mesh::CellType::tetrahedron;
  const int num_corners = facets.geometry.num_corners();
  const auto dofs = common::geometry_dofmap(mesh);
  const std::span<const double> x = mesh.geometry().x();
  const std::vector<std::int32_t> cells = cells_behind(V, facets);
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
    out.push_back((simplex ? num_vertices : 2) * distance);
  }
  return out;
}
} // namespace dolfinx_impact::surface
