// SPDX-License-Identifier: MIT
#include "quadrature.h"
#include "SymmetricEigen.h"
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace impact_reference
{
namespace
{
// Roots of the Legendre polynomial by Newton's method from the Chebyshev guess (Press et al., Numerical Recipes 4.5).
std::array<Vector, 2> gauss_legendre(int m)
{
  Vector x(m), w(m);
  for (int i = 0; i < m; ++i)
  {
    double z = -std::cos(std::numbers::pi * (i + 0.75) / (m + 0.5)), slope = 0;
    for (int iteration = 0; iteration < 12; ++iteration) // quadratic; a fixed count also settles the slope
    {
      double p = 1, before = 0;
      for (int k = 1; k <= m; ++k)
      {
        const double next = ((2 * k - 1) * z * p - (k - 1) * before) / k;
        before = p;
        p = next;
      }
      slope = m * (z * p - before) / (z * z - 1);
      z -= p / slope;
    }
    x(i) = z;
    w(i) = 2 / ((1 - z * z) * slope * slope);
  }
  return {x, w};
}

// Product of one-dimensional rules; the first direction runs fastest.
Rule product(const std::vector<std::array<Vector, 2>>& rules)
{
  int n = 1;
  for (const auto& rule : rules)
    n *= int(rule[0].size());
  Rule result{Matrix(n, rules.size()), Vector::Ones(n)};
  for (int q = 0; q < n; ++q)
  {
    int rest = q;
    for (std::size_t k = 0; k < rules.size(); ++k)
    {
      const int i = rest % int(rules[k][0].size());
      rest /= int(rules[k][0].size());
      result.points(q, k) = rules[k][0](i);
      result.weights(q) *= rules[k][1](i);
    }
  }
  return result;
}

// Collapsed coordinates (Duffy): the factors (1 - t) and (1 - r)^2 of the Jacobian sit in the Gauss-Jacobi weights.
Rule collapsed(CellType cell, int m)
{
  if (cell == CellType::triangle)
  {
    Rule rule = product({gauss_jacobi(m, 0), gauss_jacobi(m, 1)});
    for (int q = 0; q < rule.points.rows(); ++q)
    {
      const double s = rule.points(q, 0), t = rule.points(q, 1);
      rule.points.row(q) << (1 + s) * (1 - t) / 4, (1 + t) / 2;
    }
    rule.weights /= 8;
    return rule;
  }
  Rule rule = product({gauss_jacobi(m, 0), gauss_jacobi(m, 1), gauss_jacobi(m, 2)});
  for (int q = 0; q < rule.points.rows(); ++q)
  {
    const double s = rule.points(q, 0), t = rule.points(q, 1), r = rule.points(q, 2);
    rule.points.row(q) << (1 + s) * (1 - t) * (1 - r) / 8, (1 + t) * (1 - r) / 4, (1 + r) / 2;
  }
  rule.weights /= 64;
  return rule;
}
} // namespace

std::array<Vector, 2> gauss_jacobi(int m, int alpha)
{
  // The recurrence coefficients of the Jacobi polynomials P^(alpha, 0) make a symmetric tridiagonal matrix; its
  // eigenvalues are the nodes, the first components of its eigenvectors give the weights.
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(m, m);
  const double a = alpha;
  for (int k = 0; k < m; ++k)
  {
    T(k, k) = k == 0 ? -a / (a + 2) : -a * a / ((2 * k + a) * (2 * k + a + 2));
    if (k > 0)
    {
      const double c = 2 * k + a;
      T(k, k - 1) = T(k - 1, k) = 2 * k * (k + a) / (c * std::sqrt((c + 1) * (c - 1)));
    }
  }
  const SymmetricEigen solver(T);
  const double total = std::pow(2.0, alpha + 1) / (alpha + 1);
  return {solver.eigenvalues(), total * solver.eigenvectors().row(0).transpose().array().square().matrix()};
}

Rule quadrature(CellType cell, const std::string& rule)
{
  const auto colon = rule.find(':');
  const std::string name = rule.substr(0, colon), number = colon == std::string::npos ? "" : rule.substr(colon + 1);
  if ((name != "table" and name != "gauss_jacobi") or number.empty() or number.size() > 3 or
      number.find_first_not_of("0123456789") != std::string::npos)
    throw std::invalid_argument("unknown quadrature rule '" + rule +
                                "': use \"table:D\" or \"gauss_jacobi:D\" with the degree D, for example \"table:4\"");
  const int degree = std::stoi(number), m = (degree + 2) / 2;
  if (m > 50)
    throw std::invalid_argument("quadrature degree " + number + " is beyond 98, where these rules stop");
  if (is_simplex(cell))
    return name == "table" ? simplex_table(cell, degree) : collapsed(cell, m);
  const auto line = name == "table" ? gauss_legendre(m) : gauss_jacobi(m, 0);
  return product(std::vector(tdim(cell), line));
}

std::string default_rule(Purpose purpose, CellType cell, int degree, int geometry_degree, bool axisymmetric)
{
  const int p = degree, g = geometry_degree, d = tdim(cell), radius = axisymmetric ? g : 0;
  int n = 0;
  switch (purpose)
  {
  case Purpose::facet:
    n = 3 * std::max(p, g) - 1 + (axisymmetric ? std::max(p, g) : 0);
    break;
  case Purpose::stiffness:
    n = is_simplex(cell) ? 2 * (p - 1) + 2 * (g - 1) + (axisymmetric ? 3 : 0) : 2 * std::max(p, g) + 1;
    break;
  case Purpose::finite_strain: // quartic in the displacement gradient
    n = is_simplex(cell) ? 4 * (p - 1) + 2 * (g - 1) + (axisymmetric ? 3 : 0) : 2 * std::max(p, g) + 1;
    break;
  default: // the Jacobian determinant has degree d (g - 1) on a simplex, d g - 1 per direction on a tensor cell
    n = (purpose == Purpose::mass ? 2 * p : p) + (is_simplex(cell) ? d * (g - 1) : d * g - 1) + radius;
  }
  n = std::max(n, 1);
  return (n <= table_limit(cell) ? "table:" : "gauss_jacobi:") + std::to_string(n);
}

Purpose purpose(const std::string& name)
{
  static const std::vector<std::string> names{"stiffness", "finite_strain", "mass", "load", "facet"};
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name)
      return static_cast<Purpose>(i);
  throw std::invalid_argument("unknown purpose '" + name + "': use stiffness, finite_strain, mass, load or facet");
}
} // namespace impact_reference
