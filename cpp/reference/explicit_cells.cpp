// SPDX-License-Identifier: MIT
#include "Model.h"
#include "SymmetricEigen.h"
#include <numbers>
#include <stdexcept>

namespace impact_reference
{
namespace
{
// Dilatational, seed (3.80), whatever the hypothesis.
double wave_speed(const Material& m)
{
  return std::sqrt(m.E * (1 - m.nu) / (m.density * (1 + m.nu) * (1 - 2 * m.nu)));
}

// Inverse of C = F^T F as a stress-like column (components as the strains, no factor on shears).
Vector inverse_metric(Hypothesis h, const Eigen::Matrix3d& F)
{
  const Eigen::Matrix3d C = (F.transpose() * F).inverse();
  if (h == Hypothesis::solid)
    return (Vector(6) << C(0, 0), C(1, 1), C(2, 2), C(0, 1), C(1, 2), C(0, 2)).finished();
  if (h == Hypothesis::axisymmetric)
    return (Vector(4) << C(0, 0), C(1, 1), C(2, 2), C(0, 1)).finished();
  return (Vector(3) << C(0, 0), C(1, 1), C(0, 1)).finished();
}
} // namespace

Vector Model::viscous_force(const Rule& rule, const Vector& u, const Vector& v, double b1, double b2,
                            bool deformed) const
{
  const Sampler s = sampler(rule);
  const int d = gdim();
  Vector result = Vector::Zero(num_dofs());
  for (std::int64_t c = 0; c < geometry_.cells.rows(); ++c)
  {
    const Material& m = material(c);
    const Matrix X = cell_points(c);
    const Vector ue = gather(u, c), ve = gather(v, c);
    const bool linear = m.law == "linear_elastic" and not deformed;
    Vector force = Vector::Zero(ue.size());
    for (int q = 0; q < s.num_points(); ++q)
    {
      const Sample p = s.at(X, q, c);
      // The own tensor cells fill [-1, 1]^d: their Jacobian is that of the unit cell over 2^d.
      double det = p.weight / rule.weights(q) * (is_simplex(geometry_.cell) ? 1 : std::pow(2, d));
      if (hypothesis_ == Hypothesis::axisymmetric)
        det /= 2 * std::numbers::pi * p.radius;
      const double length = std::pow(det, 1.0 / d);
      // Of the deformed body if the law knows finite strain, q J C^-1 as a 2nd Piola-Kirchhoff stress; else at rest.
      Eigen::Matrix3d F = linear ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : deformation_gradient(p, ue);
      const Matrix B = linear ? strain_matrix(hypothesis_, p) : green_strain_matrix(hypothesis_, p, F);
      const Vector metric = inverse_metric(hypothesis_, F);
      const double rate = metric.dot(B.lazyProduct(ve)); // div v: B makes engineering shears
      const double pressure = b1 * m.density * wave_speed(m) * length * rate +
                              b2 * b2 * m.density * length * length * std::abs(rate) * std::min(0.0, rate);
      force += (p.weight * pressure * F.determinant()) * B.transpose().lazyProduct(metric);
    }
    scatter(result, d, c, force);
  }
  return result;
}

double Model::cell_frequency(const Rule& rule, const Rule& mass_rule, const std::string& scheme) const
{
  const Sampler s = sampler(rule);
  const LumpedMass lump(geometry_.cell, field_.degree, geometry_.degree, mass_rule,
                        hypothesis_ == Hypothesis::axisymmetric, scheme);
  double highest = 0;
  for (std::int64_t c = 0; c < geometry_.cells.rows(); ++c)
  {
    const Vector m = lump(cell_points(c), material(c), c);
    if (not(m.minCoeff() > 0))
      throw std::invalid_argument("cell " + std::to_string(c) +
                                  " has a nodal mass that is not positive: choose the lumping scheme hrz or auto");
    const Vector root = m.cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd A =
        root.asDiagonal() * impact_reference::stiffness(s, cell_points(c), material(c), c) * root.asDiagonal();
    highest = std::max(highest, SymmetricEigen(A, false).eigenvalues().maxCoeff());
  }
  return std::sqrt(highest);
}

double Model::passage() const
{
  double shortest = std::numeric_limits<double>::infinity();
  for (std::int64_t c = 0; c < geometry_.cells.rows(); ++c)
  {
    const Matrix X = cell_points(c);
    check(material(c), true);
    for (const auto& edge : node_vertices(geometry_.cell, 2))
      if (edge.size() == 2)
        shortest = std::min(shortest, (X.row(edge[0]) - X.row(edge[1])).norm() / wave_speed(material(c)));
  }
  return shortest / field_.degree;
}
} // namespace impact_reference
