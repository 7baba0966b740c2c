// SPDX-License-Identifier: MIT
#include "contact_surface.h"
#include <algorithm>
#include <cmath>
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

namespace
{
// What a parabola between two vertices is above its chord, at the middle.
Eigen::Vector3d crown(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& normal_a,
                      const Eigen::Vector3d& normal_b)
{
  const Eigen::Vector3d up = (normal_a + normal_b).normalized(), chord = b - a;
  // The angle that the curve climbs from the chord at a; at b it comes down by the same.
  const double climbs = std::atan2(0.5 * (normal_b - normal_a).dot(chord), normal_a.dot(up) * chord.norm());
  return 0.5 * chord.norm() * std::tan(0.5 * climbs) * up;
}
} // namespace

void smooth(Surface& s, const Cells& facets, const Matrix& normals)
{
  const int n = s.num_vertices();
  if (s.degree != 1 or s.geometry_degree != 1 or facets.cols() != n)
    throw std::invalid_argument("smooth surfaces are made of facets of degree 1, given by their vertices");
  if (normals.rows() != facets.size() or normals.cols() != s.gdim)
    throw std::invalid_argument("a smooth surface needs a normal at every vertex of every facet");
  const auto& nodes = node_vertices(s.type, 2);
  for (std::int64_t row = 0; row < facets.rows(); ++row)
  {
    Facet& facet = s.facets[row];
    std::vector<Vec<double>> corners(n);
    std::vector<Eigen::Vector3d> x(n, Eigen::Vector3d::Zero()), normal(x);
    for (int v = 0; v < n; ++v)
      for (int c = 0; c < s.gdim; ++c)
        corners[v][c] = x[v](c) = facet.X(v, c);
    const Vec<double> own = axes(s, corners)[2];
    for (int v = 0; v < n; ++v)
    {
      const auto given = facets.row(row);
      const auto at = std::find(given.begin(), given.end(), facet.vertices[v]) - given.begin();
      for (int c = 0; c < s.gdim; ++c)
        normal[v](c) = normals(row * n + at, c);
      if (not normal[v].allFinite())
        normal[v] = {own[0], own[1], own[2]};
      normal[v].normalize();
    }
    const auto frame = axes(s, corners);
    Eigen::Matrix3d A;
    for (int k = 0; k < 3; ++k)
      A.col(k) = Eigen::Vector3d(frame[k][0], frame[k][1], frame[k][2]);
    Matrix X = Matrix::Zero(std::int64_t(nodes.size()), s.gdim);
    Eigen::Vector3d crowns = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < nodes.size(); ++i)
    {
      Eigen::Vector3d place = Eigen::Vector3d::Zero(), above = place;
      for (int v : nodes[i])
        place += x[v] / double(nodes[i].size());
      if (nodes[i].size() == 2)
        above = crown(x[nodes[i][0]], x[nodes[i][1]], normal[nodes[i][0]], normal[nodes[i][1]]);
      else if (nodes[i].size() == 4) // the surface that its four edges span (Coons); this node is the last one
        above = 0.5 * crowns;
      crowns += above;
      X.row(i) = (place + above).head(s.gdim).transpose();
      facet.beyond.push_back(A.inverse() * above);
    }
    facet.X = X;
  }
  s.geometry_degree = 2;
  s.smooth = true;
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
