// SPDX-License-Identifier: MIT
#include "SymmetricEigen.h"
#include "contact_explicit.h"
#include <set>

namespace impact_reference
{
namespace
{
Eigen::Vector3d mean(const Matrix& points, const std::vector<std::int64_t>& rows)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (auto row : rows)
    sum.head(points.cols()) += points.row(row).transpose();
  return sum / double(rows.size());
}

// Of the edge, of the triangle, or of the diagonals of a quadrilateral.
Eigen::Vector3d normal(const Surface& s, const Facet& facet)
{
  const auto between = [&](int a, int b)
  {
    Eigen::Vector3d d = Eigen::Vector3d::Zero();
    d.head(s.gdim) = (facet.X.row(b) - facet.X.row(a)).transpose();
    return d;
  };
  if (s.gdim == 2)
    return between(0, 1).cross(Eigen::Vector3d::UnitZ()).normalized();
  if (s.num_vertices() == 3)
    return between(0, 1).cross(between(0, 2)).normalized();
  return between(0, 2).cross(between(1, 3)).normalized(); // vertices go round
}

// Stress over strain in uniaxial strain.
double uniaxial_modulus(const Material& m, Hypothesis hypothesis)
{
  if (hypothesis == Hypothesis::plane_stress)
    return m.E / (1 - m.nu * m.nu);
  return m.E * (1 - m.nu) / ((1 + m.nu) * (1 - 2 * m.nu));
}
} // namespace

double height_behind(const Model& model, const Surface& s, const Facet& facet)
{
  const Geometry& g = model.geometry();
  const auto row = g.cells.row(facet.cell);
  const std::vector<std::int64_t> vertices(row.begin(), row.begin() + num_vertices(g.cell));
  const double apart = std::abs(normal(s, facet).dot(mean(g.points, vertices) - mean(g.points, facet.vertices)));
  // The centre of a simplex lies at a third or a quarter of its height, that of a box in the middle.
  return (is_simplex(g.cell) ? model.gdim() + 1 : 2) * apart;
}

NodalStiffness nodal_stiffness(const Model& model, const Surface& s,
                               const std::function<Matrix(std::int64_t)>& stiffness, const Rule& mass_rule,
                               const std::string& scheme)
{
  const Geometry& g = model.geometry();
  const bool axisymmetric = model.hypothesis() == Hypothesis::axisymmetric;
  // Half of what the outermost layer of nodes resists with in uniaxial strain.
  NodalStiffness layer;
  for (const Facet& facet : s.facets)
  {
    const double height = height_behind(model, s, facet);
    Surface one = s;
    one.facets = {facet};
    const double modulus = uniaxial_modulus(model.material(facet.cell), model.hypothesis());
    for (const auto& [node, area] : nodal_areas(one))
      layer[node] += 0.5 * modulus * s.degree / height * area;
  }
  // What a step of 0.9 of the stable one leaves of the cells' highest frequencies.
  const LumpedMass lump(g.cell, model.field().degree, g.degree, mass_rule, axisymmetric, scheme);
  NodalStiffness most;
  for (std::int64_t c = 0; c < model.num_cells(); ++c)
  {
    const auto nodes = model.cell_nodes(c);
    if (std::none_of(nodes.begin(), nodes.end(), [&](auto node) { return layer.contains(node); }))
      continue;
    const Vector m = lump(model.cell_points(c), model.material(c), c);
    const Vector root = m.cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd A = root.asDiagonal() * stiffness(c) * root.asDiagonal();
    const double squared = SymmetricEigen((A + A.transpose()) / 2, false).eigenvalues().maxCoeff();
    for (std::size_t k = 0; k < nodes.size(); ++k)
      most[nodes[k]] += (1 / (0.9 * 0.9) - 1) * m(Eigen::Index(model.gdim() * k)) * squared;
  }
  for (auto& [node, k] : layer)
    k = std::min(k, most.at(node));
  return layer;
}
} // namespace impact_reference
