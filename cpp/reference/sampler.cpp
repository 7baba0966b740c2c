// SPDX-License-Identifier: MIT
#include "Sampler.h"
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace impact_reference
{
namespace
{
template <typename... T>
[[noreturn]] void invalid(const T&... parts)
{
  std::ostringstream text;
  (text << ... << parts);
  throw std::invalid_argument(text.str());
}

void check_rule(CellType cell, const Rule& rule)
{
  if (rule.points.cols() != tdim(cell) or rule.points.rows() != rule.weights.size() or rule.weights.size() == 0)
    invalid("a rule for a ", to_string(cell), " needs points of shape (n, ", tdim(cell),
            ") and n weights with n > 0; found points (", rule.points.rows(), ", ", rule.points.cols(), ") and ",
            rule.weights.size(), " weights");
}

double size(const Matrix& X)
{
  return (X.colwise().maxCoeff() - X.colwise().minCoeff()).maxCoeff();
}

void check_nodes(CellType type, const Matrix& X, Eigen::Index expected, bool axisymmetric, std::int64_t cell)
{
  if (X.rows() != expected or X.cols() != tdim(type))
    invalid("a ", to_string(type), " of this geometry degree needs node coordinates of shape (", expected, ", ",
            tdim(type), "), but (", X.rows(), ", ", X.cols(), ") was given");
  if (not X.allFinite())
    invalid("cell ", cell, " has a node coordinate that is NaN or infinite");
  // Mesh generators put nodes on the axis only up to rounding.
  if (axisymmetric and X.col(0).minCoeff() < -1e-10 * size(X))
    invalid("cell ", cell, " has a node with r = ", X.col(0).minCoeff(),
            ": an axisymmetric mesh must have x = r >= 0 everywhere; move or mirror it");
}

// Determinant and inverse of a Jacobian: Eigen's closed forms for fixed sizes.
double determinant(const Matrix& J)
{
  if (J.rows() == 1)
    return J(0, 0);
  return J.rows() == 2 ? Eigen::Matrix2d(J).determinant() : Eigen::Matrix3d(J).determinant();
}

Matrix inverse(const Matrix& J)
{
  if (J.rows() == 1)
    return J.cwiseInverse();
  return J.rows() == 2 ? Matrix(Eigen::Matrix2d(J).inverse()) : Matrix(Eigen::Matrix3d(J).inverse());
}
} // namespace

Sampler::Sampler(CellType cell, int degree, int geometry_degree, const Rule& rule, bool axisymmetric)
    : cell_(cell), axisymmetric_(axisymmetric), weights_(rule.weights)
{
  check_rule(cell, rule);
  if (axisymmetric and tdim(cell) != 2)
    invalid("axisymmetric needs a triangle or quadrilateral, not a ", to_string(cell));
  field_ = shape_functions(cell, degree, rule.points);
  geometry_ = shape_functions(cell, geometry_degree, rule.points);
}

Sample Sampler::at(const Matrix& X, int q, std::int64_t cell) const
{
  check_nodes(cell_, X, geometry_.N.cols(), axisymmetric_, cell);
  const Matrix J = X.transpose().lazyProduct(geometry_.dN[q]); // J_ab = dx_a / dxi_b
  const double det = determinant(J), h = size(X);
  if (not(det > 1e-14 * std::pow(h, J.rows())))
    invalid("cell ", cell, " is inverted or has no volume: the determinant of its Jacobian is ", det, " at ",
            field_.N.rows() == 1 ? "its centre" : "an integration point",
            "; order its nodes counter-clockwise (first face seen from inside in 3D) and check their positions");
  Sample s;
  s.x = X.transpose().lazyProduct(geometry_.N.row(q).transpose());
  s.N = field_.N.row(q).transpose();
  s.dN = field_.dN[q].lazyProduct(inverse(J));
  s.radius = axisymmetric_ ? s.x(0) : 0;
  s.weight = weights_(q) * det * (axisymmetric_ ? 2 * std::numbers::pi * s.radius : 1);
  return s;
}

FacetSampler::FacetSampler(CellType cell, int degree, int geometry_degree, const Rule& rule, bool axisymmetric)
    : cell_(cell), degree_(degree), geometry_degree_(geometry_degree), axisymmetric_(axisymmetric),
      weights_(rule.weights)
{
  check_rule(facet_type(cell), rule);
  if (axisymmetric and tdim(cell) != 2)
    invalid("axisymmetric needs a triangle or quadrilateral, not a ", to_string(cell));
  field_ = shape_functions(facet_type(cell), degree, rule.points);
  geometry_ = shape_functions(facet_type(cell), geometry_degree, rule.points);
}

FacetSample FacetSampler::at(const Matrix& X, int facet, int q) const
{
  check_nodes(cell_, X, node_vertices(cell_, geometry_degree_).size(), axisymmetric_, 0);
  const std::vector<int> nodes = facet_nodes(cell_, geometry_degree_, facet);
  const Matrix Xf = X(nodes, Eigen::all);
  FacetSample s;
  s.weight = weights_(q);
  s.x = Xf.transpose().lazyProduct(geometry_.N.row(q).transpose());
  s.N = field_.N.row(q).transpose();
  s.dN = field_.dN[q];
  s.tangent = Xf.transpose().lazyProduct(geometry_.dN[q]);
  s.radius = axisymmetric_ ? s.x(0) : 0;
  return s;
}

Vector area_vector(const Matrix& t)
{
  if (t.rows() == 2)
    return Eigen::Vector2d(t(1, 0), -t(0, 0));
  return Eigen::Vector3d(t.col(0)).cross(Eigen::Vector3d(t.col(1)));
}
} // namespace impact_reference
