// SPDX-License-Identifier: MIT
#include "contact_surface.h"
#include <algorithm>
#include <set>
#include <stdexcept>

namespace impact_reference
{
Surface surface(const Model& model, const Cells& facets, const std::string& name)
{
  const Geometry& g = model.geometry();
  const Field& field = model.field();
  if (facets.rows() == 0)
    throw std::invalid_argument("the " + name + " has no facets");
  const FacetIndex index(g);
  Surface s{
      facet_type(g.cell), field.degree, g.degree, model.gdim(), model.hypothesis() == Hypothesis::axisymmetric, {}};
  std::set<std::pair<std::int64_t, int>> known;
  for (std::int64_t row = 0; row < facets.rows(); ++row)
  {
    const FacetPlace place = index.find({facets.row(row).begin(), facets.row(row).end()});
    const std::string which = "facet " + std::to_string(row) + " of the " + name;
    if (place.num_cells > 1)
      throw std::invalid_argument(which + " lies between two cells: contact needs facets on the boundary");
    if (not known.emplace(place.cell, place.facet).second)
      throw std::invalid_argument(which + " is given twice");
    Facet facet{place.cell, {}, {}, {}};
    for (int i : facet_nodes(g.cell, field.degree, place.facet))
      facet.nodes.push_back(field.cells(place.cell, i));
    std::vector<std::int64_t> geometry;
    for (int i : facet_nodes(g.cell, g.degree, place.facet))
      geometry.push_back(g.cells(place.cell, i));
    facet.X = g.points(geometry, Eigen::all);
    facet.vertices.assign(geometry.begin(), geometry.begin() + s.num_vertices());
    s.facets.push_back(facet);
  }
  return s;
}

Local facet_centre(CellType type)
{
  return type == CellType::triangle ? Local{1.0 / 3, 1.0 / 3} : Local{0, 0};
}

Local facet_vertex(CellType type, int vertex)
{
  static constexpr Local interval[]{{-1, 0}, {1, 0}}, triangle[]{{0, 0}, {1, 0}, {0, 1}},
      quadrilateral[]{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  return (type == CellType::interval ? interval : type == CellType::triangle ? triangle : quadrilateral)[vertex];
}

std::vector<Vec<double>> gather(const Surface& surface, const Facet& facet, const Vector& u)
{
  std::vector<Vec<double>> result(facet.nodes.size());
  for (std::size_t k = 0; k < facet.nodes.size(); ++k)
    for (int c = 0; c < surface.gdim; ++c)
      result[k][c] = u(surface.gdim * facet.nodes[k] + c);
  return result;
}
} // namespace impact_reference
