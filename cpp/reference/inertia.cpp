// SPDX-License-Identifier: MIT
#include "element.h"
#include <stdexcept>

namespace impact_reference
{
namespace
{
// Spreads a matrix between nodes over the components: m (x) I.
Matrix expand(const Matrix& m, int d)
{
  Matrix result = Matrix::Zero(d * m.rows(), d * m.cols());
  for (int i = 0; i < m.rows(); ++i)
    for (int j = 0; j < m.cols(); ++j)
      for (int a = 0; a < d; ++a)
        result(d * i + a, d * j + a) = m(i, j);
  return result;
}

Matrix nodal_mass(const Sampler& sampler, const Matrix& X, double density, std::int64_t cell)
{
  Matrix m = Matrix::Zero(sampler.num_nodes(), sampler.num_nodes());
  for (int q = 0; q < sampler.num_points(); ++q)
  {
    const Sample s = sampler.at(X, q, cell);
    m.noalias() += (density * s.weight) * s.N * s.N.transpose();
  }
  return m;
}

// Weights of the quadrature at the nodes: the integrals of the shape functions over the reference cell.
Rule nodal_rule(CellType cell, int degree)
{
  const Rule exact = quadrature(cell, "table:" + std::to_string(degree));
  return {reference_nodes(cell, degree),
          shape_functions(cell, degree, exact.points).N.transpose().lazyProduct(exact.weights)};
}

Vector velocity(const Vector& spin, const Vector& x)
{
  if (x.size() == 2)
    return Eigen::Vector2d(-spin(0) * x(1), spin(0) * x(0));
  return Eigen::Vector3d(spin).cross(Eigen::Vector3d(x));
}
} // namespace

Matrix mass(const Sampler& sampler, const Matrix& X, const Material& material, std::int64_t cell)
{
  check(material, true);
  return expand(nodal_mass(sampler, X, material.density, cell), sampler.gdim());
}

std::string lumping_scheme(const std::string& scheme, CellType cell, int degree, bool axisymmetric)
{
  if (scheme == "row_sum" or scheme == "hrz" or scheme == "nodal")
    return scheme;
  if (scheme != "auto")
    throw std::invalid_argument("unknown lumping scheme '" + scheme + "': use auto, row_sum, hrz or nodal");
  if (degree == 1)
    return "row_sum";
  return is_simplex(cell) or axisymmetric ? "hrz" : "nodal";
}

LumpedMass::LumpedMass(CellType cell, int degree, int geometry_degree, const Rule& rule, bool axisymmetric,
                       const std::string& scheme)
    : scheme_(lumping_scheme(scheme, cell, degree, axisymmetric)),
      sampler_(cell, degree, geometry_degree, rule, axisymmetric),
      nodal_(cell, degree, geometry_degree, nodal_rule(cell, degree), axisymmetric)
{
}

Vector LumpedMass::operator()(const Matrix& X, const Material& material, std::int64_t cell) const
{
  check(material, true);
  const Matrix m = nodal_mass(sampler_, X, material.density, cell);
  const double total = m.sum(); // the shape functions sum to one
  Vector lumped = m.rowwise().sum();
  if (scheme_ == "hrz")
    lumped = m.diagonal() * (total / m.trace());
  else if (scheme_ == "nodal")
  {
    for (int i = 0; i < nodal_.num_points(); ++i)
      lumped(i) = material.density * nodal_.at(X, i, cell).weight;
    lumped *= total / lumped.sum(); // differs from 1 only where the nodal rule does not integrate the Jacobian
  }
  const int d = sampler_.gdim();
  Vector result(d * lumped.size());
  for (int i = 0; i < lumped.size(); ++i)
    result.segment(d * i, d).setConstant(lumped(i));
  return result;
}

Ale ale(const Sampler& sampler, const Matrix& X, const Material& material, const Vector& spin, const Vector& centre,
        std::int64_t cell)
{
  check(material, true);
  const int d = sampler.gdim(), n = sampler.num_nodes();
  if (sampler.axisymmetric())
    throw std::invalid_argument("the rotating ALE frame is not for axisymmetric models: their points move along the "
                                "circumference only; use a plane or solid model");
  if (spin.size() != (d == 2 ? 1 : 3) or centre.size() != d)
    throw std::invalid_argument("in dimension " + std::to_string(d) + " spin needs " + (d == 2 ? "1" : "3") +
                                " component(s) and centre " + std::to_string(d) + "; found " +
                                std::to_string(spin.size()) + " and " + std::to_string(centre.size()));
  if (not spin.allFinite() or not centre.allFinite())
    throw std::invalid_argument("spin or centre holds a value that is NaN or infinite");
  Matrix G = Matrix::Zero(n, n), W = Matrix::Zero(n, n);
  Vector load = Vector::Zero(d * n);
  for (int q = 0; q < sampler.num_points(); ++q)
  {
    const Sample s = sampler.at(X, q, cell);
    const Vector w = velocity(spin, s.x - centre), A = s.dN.lazyProduct(w);
    const double rho = material.density * s.weight;
    G += rho * (s.N * A.transpose() - A * s.N.transpose());
    W += rho * A * A.transpose();
    for (int i = 0; i < n; ++i)
      load.segment(d * i, d) += rho * A(i) * w;
  }
  return {expand(G, d), expand(W, d), load};
}

Ale ale_translation(const Sampler& sampler, const Matrix& X, const Material& material, const Vector& velocity,
                    std::int64_t cell)
{
  check(material, true);
  const int d = sampler.gdim(), n = sampler.num_nodes();
  if (velocity.size() != d or not velocity.allFinite())
    throw std::invalid_argument("the velocity of a translation needs " + std::to_string(d) + " finite components");
  Matrix G = Matrix::Zero(n, n), W = Matrix::Zero(n, n);
  for (int q = 0; q < sampler.num_points(); ++q)
  {
    const Sample s = sampler.at(X, q, cell);
    const Vector A = s.dN.lazyProduct(velocity);
    const double rho = material.density * s.weight;
    G += rho * (s.N * A.transpose() - A * s.N.transpose());
    W += rho * A * A.transpose();
  }
  return {expand(G, d), expand(W, d), Vector::Zero(d * n)};
}
} // namespace impact_reference
