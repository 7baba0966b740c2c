// SPDX-License-Identifier: MIT
#include "Surface.h"
#include "../common/dolfinx_api.h"
#include "normals.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/mesh/Mesh.h>
#include <stdexcept>

namespace dolfinx_impact::surface
{
namespace
{
using dolfinx::mesh::CellType;

FacetShape facet_shape(CellType cell)
{
  switch (cell)
  {
  case CellType::triangle:
  case CellType::quadrilateral:
    return FacetShape::interval;
  case CellType::tetrahedron:
    return FacetShape::triangle;
  case CellType::hexahedron:
    return FacetShape::quadrilateral;
  default:
    throw std::invalid_argument("contact needs triangles, quadrilaterals, tetrahedra or hexahedra");
  }
}

/// Reference coordinates in the cell of the nodes of a facet element, for one local facet.
std::vector<double> cell_points(const FacetElement& element, CellType cell, int facet)
{
  const auto [vertices, shape] =
      basix::cell::sub_entity_geometry<double>(dolfinx::mesh::cell_type_to_basix_type(cell), element.tdim(), facet);
  const int tdim = int(shape[1]);
  const FacetElement linear{element.shape, 1};
  std::vector<double> points(element.num_nodes() * tdim, 0.0);
  for (int i = 0; i < element.num_nodes(); ++i)
  {
    double phi[FacetElement::max_nodes];
    linear.values(element.node(i).data(), phi);
    for (int v = 0; v < linear.num_nodes(); ++v)
      for (int c = 0; c < tdim; ++c)
        points[i * tdim + c] += phi[v] * vertices[v * tdim + c];
  }
  return points;
}

/// Which dofs of the cell are the nodes of its facets: dofs[facet][i].
std::vector<std::vector<int>> facet_dofs(const FunctionSpace& V, const FacetElement& element, CellType cell,
                                         int num_facets)
{
  const auto& [nodes, shape] = V.element()->basix_element().points();
  const int tdim = int(shape[1]);
  std::vector<std::vector<int>> dofs(num_facets);
  for (int f = 0; f < num_facets; ++f)
  {
    const std::vector<double> points = cell_points(element, cell, f);
    for (int i = 0; i < element.num_nodes(); ++i)
      for (std::size_t d = 0; d < shape[0]; ++d)
      {
        double distance = 0.0;
        for (int c = 0; c < tdim; ++c)
          distance += std::abs(nodes[d * tdim + c] - points[i * tdim + c]);
        if (distance < 1e-10)
          dofs[f].push_back(int(d));
      }
    if (int(dofs[f].size()) != element.num_nodes())
      throw std::invalid_argument("contact needs a space whose degrees of freedom are nodal values on the facets");
  }
  return dofs;
}

void check(const FunctionSpace& V)
{
  const auto& element = *V.element();
  const int gdim = V.mesh()->geometry().dim(), tdim = V.mesh()->topology()->dim();
  if (gdim != tdim)
    throw std::invalid_argument("contact needs a mesh whose cells have the dimension of space");
  const bool blocked = element.block_size() == gdim && common::value_shape(V).size() == 1;
  if (!blocked || element.basix_element().family() != basix::element::family::P ||
      element.basix_element().discontinuous())
    throw std::invalid_argument("contact needs displacements in a Lagrange space with one component per dimension");
  if (const int degree = element.basix_element().degree(); degree > 2)
    throw std::invalid_argument("contact knows displacements of degree 1 and 2, this space has degree " +
                                std::to_string(degree));
  if (common::coordinate_element(*V.mesh()).degree() > 2)
    throw std::invalid_argument("contact knows meshes of geometry degree 1 and 2");
}
} // namespace

Facets make_surface(const FunctionSpace& V, std::span<const std::int32_t> facets)
{
  check(V);
  const auto& mesh = *V.mesh();
  const auto& geometry = mesh.geometry();
  const auto& cmap = common::coordinate_element(mesh);
  auto topology = mesh.topology();
  const int tdim = topology->dim(), gdim = geometry.dim();
  const CellType cell = topology->cell_type();
  const int degree = V.element()->basix_element().degree();
  Facets out;
  out.gdim = gdim;
  out.displacement = {facet_shape(cell), degree};
  out.geometry = {facet_shape(cell), std::max(degree, cmap.degree())};
  const int num_facets = dolfinx::mesh::cell_num_entities(cell, tdim - 1);
  // A submesh has no input: its cells count by their global numbers.
  const std::vector<std::int64_t> cell_numbers = topology->original_cell_index.empty()
                                                     ? topology->index_map(tdim)->global_indices()
                                                     : topology->original_cell_index.front();
  const auto dofs = facet_dofs(V, out.displacement, cell, num_facets);

  // Geometry shape functions at the facets' nodes, one table per local facet.
  const int n = out.geometry.num_nodes(), num_points = int(cmap.dim());
  std::vector<std::vector<double>> tables;
  for (int f = 0; f < num_facets; ++f)
  {
    const auto shape = cmap.tabulate_shape(0, n);
    std::vector<double> table(shape[0] * shape[1] * shape[2] * shape[3]);
    cmap.tabulate(0, cell_points(out.geometry, cell, f), {std::size_t(n), std::size_t(tdim)}, table);
    tables.push_back(table);
  }

  auto facet_to_cell = topology->connectivity(tdim - 1, tdim);
  auto cell_to_facet = topology->connectivity(tdim, tdim - 1);
  if (!facet_to_cell || !cell_to_facet)
    throw std::invalid_argument("the mesh lacks the connectivity between facets and cells");
  const auto cell_map = topology->index_map(tdim);
  for (const std::int32_t facet : facets)
  {
    const auto cells = facet_to_cell->links(facet);
    if (cells.size() != 1)
      throw std::invalid_argument("a facet of the contact surface lies inside the body");
    const std::int32_t c = cells[0];
    if (c >= cell_map->size_local())
      continue;
    const auto siblings = cell_to_facet->links(c);
    const int local = int(std::find(siblings.begin(), siblings.end(), facet) - siblings.begin());
    const auto blocks = V.dofmap()->cell_dofs(c);
    for (int d : dofs[local])
      out.nodes.push_back(blocks[d]);
    const auto points = common::geometry_dofmap(mesh);
    const auto coordinates = geometry.x();
    double centre[3] = {0.0, 0.0, 0.0};
    for (int p = 0; p < num_points; ++p)
      for (int k = 0; k < gdim; ++k)
        centre[k] += coordinates[3 * points(c, p) + k] / num_points;
    const std::size_t first = out.X.size();
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < gdim; ++k)
      {
        double x = 0.0;
        for (int p = 0; p < num_points; ++p)
          x += tables[local][i * num_points + p] * coordinates[3 * points(c, p) + k];
        out.X.push_back(x);
      }
    out.orientation.push_back(orientation(out.geometry, gdim, out.X.data() + first, centre));
    out.id.push_back(8 * cell_numbers[c] + local);
  }
  out.x = out.X;
  return out;
}
} // namespace dolfinx_impact::surface
