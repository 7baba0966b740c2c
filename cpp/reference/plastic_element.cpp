// SPDX-License-Identifier: MIT
#include "plastic_element.h"
#include "DenseLu.h"
#include "element.h"
#include <cmath>
#include <stdexcept>

namespace impact_reference
{
namespace
{
// Gradient of displacements, grad u = G u: row 3 i + j is du_i / dx_j, and row 8 is u_r / r in axisymmetric problems.
Matrix gradient_matrix(Hypothesis h, const Sample& s)
{
  const int n = int(s.N.size()), d = int(s.dN.cols());
  Matrix G = Matrix::Zero(9, d * n);
  for (int a = 0; a < n; ++a)
    for (int i = 0; i < d; ++i)
      for (int j = 0; j < d; ++j)
        G(3 * i + j, d * a + i) = s.dN(a, j);
  if (h == Hypothesis::axisymmetric)
  {
    if (not(s.radius > 0))
      throw std::invalid_argument("an integration point lies on the axis, where u_r / r is not defined: use a rule "
                                  "with interior points");
    for (int a = 0; a < n; ++a)
      G(8, d * a) = s.N(a) / s.radius;
  }
  return G;
}

Tensor tensor(const Components& c)
{
  Tensor a;
  a << c(0), c(1), c(2), c(3), c(4), c(5), c(6), c(7), c(8);
  return a;
}

// Matrix of tr(A dF1 A dF2) for displacements, A = F^-1.
Matrix trace_of_products(const Tensor& A, const Matrix& G)
{
  Matrix M = Matrix::Zero(9, G.cols()), T(9, G.cols());
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        M.row(3 * i + j) += A(i, k) * G.row(3 * k + j);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      T.row(3 * i + j) = M.row(3 * j + i);
  return M.transpose().lazyProduct(T);
}

void check(const Sampler& sampler, const PlasticKinematics& k, const Vector& u, std::span<const J2History> committed)
{
  if ((k.hypothesis == Hypothesis::solid) != (sampler.gdim() == 3) or
      (k.hypothesis == Hypothesis::axisymmetric) != sampler.axisymmetric())
    throw std::invalid_argument("the hypothesis does not go with the cell: solid cells need 3d, plane cells "
                                "plane_strain, plane_stress or axisymmetric");
  if (k.hypothesis == Hypothesis::plane_stress and k.dilatation != Dilatation::pointwise)
    throw std::invalid_argument("plane stress goes without mean dilatation: it does not lock");
  if (u.size() != sampler.gdim() * sampler.num_nodes() or not u.allFinite())
    throw std::invalid_argument("the element needs " + std::to_string(sampler.gdim() * sampler.num_nodes()) +
                                " finite displacements, found " + std::to_string(u.size()) + " values");
  if (std::int64_t(committed.size()) != sampler.num_points())
    throw std::invalid_argument("the rule has " + std::to_string(sampler.num_points()) + " points, but there are " +
                                std::to_string(committed.size()) + " histories: they belong to another rule");
}

void add(PlasticInternal& result, double weight, const J2Answer& answer)
{
  result.energy += weight * answer.energy;
  result.work += weight * answer.history.work;
  result.dissipation += weight * answer.dissipation;
  result.history.push_back(answer.history);
  result.answers.push_back(answer);
}

struct Point
{
  double weight;
  Matrix G;
};

// Matrix that makes of values at the points the values there of their mean or of their linear fit (least squares).
Matrix fit(const std::vector<Point>& points, const Matrix& x, Dilatation dilatation)
{
  const Eigen::Index n = x.rows(), columns = dilatation == Dilatation::linear ? 1 + x.cols() : 1;
  Matrix basis = Matrix::Ones(n, columns), weighted(columns, n);
  if (dilatation == Dilatation::linear)
    basis.rightCols(x.cols()) = x.rowwise() - x.row(0); // from the first point: digits of places far away are kept
  for (Eigen::Index q = 0; q < n; ++q)
    weighted.col(q) = points[std::size_t(q)].weight * basis.row(q).transpose();
  const DenseLu normal(weighted.lazyProduct(basis)); // the normal equations
  if (not normal.invertible())
    throw std::invalid_argument("a linear dilatation needs more points than the cell has, not in one plane");
  return basis.lazyProduct(normal.solve(weighted));
}
} // namespace

Dilatation dilatation(const std::string& name)
{
  if (name == "pointwise")
    return Dilatation::pointwise;
  if (name == "mean")
    return Dilatation::mean;
  if (name == "linear")
    return Dilatation::linear;
  throw std::invalid_argument("dilatation '" + name + "' is unknown: use pointwise, mean or linear");
}

PlasticInternal plastic_internal(const Sampler& sampler, const Matrix& X, const J2& law, const PlasticKinematics& k,
                                 const Vector& u, std::span<const J2History> committed, bool with_tangent,
                                 std::int64_t cell)
{
  check(sampler, k, u, committed);
  const Eigen::Index n = u.size();
  std::vector<Point> points;
  Matrix x(sampler.num_points(), sampler.gdim());
  for (int q = 0; q < sampler.num_points(); ++q)
  {
    const Sample s = sampler.at(X, q, cell);
    points.push_back({s.weight, gradient_matrix(k.hypothesis, s)});
    x.row(q) = s.x.transpose();
  }
  const bool replaced = k.dilatation != Dilatation::pointwise;
  const Matrix P = replaced ? fit(points, x, k.dilatation) : Matrix();
  PlasticInternal result{0, 0, 0, Vector::Zero(n), with_tangent ? Matrix(Matrix::Zero(n, n)) : Matrix(), {}, {}};

  if (k.strain == PlasticStrain::small)
  {
    const Components identity = components(Tensor::Identity());
    if (replaced)
    {
      Matrix trace(x.rows(), n); // tr eps = trace . u at the points
      for (Eigen::Index q = 0; q < x.rows(); ++q)
        trace.row(q) = identity.transpose().lazyProduct(points[std::size_t(q)].G);
      const Matrix change = (P.lazyProduct(trace) - trace) / 3;
      for (Eigen::Index q = 0; q < x.rows(); ++q)
        points[std::size_t(q)].G += identity * change.row(q);
    }
    for (std::size_t q = 0; q < points.size(); ++q)
    {
      const auto& [weight, G] = points[q];
      const Tensor H = tensor(G.lazyProduct(u));
      const Tensor strain = 0.5 * (H + H.transpose());
      const J2Answer answer = law.answer(k.strain, k.hypothesis, strain, committed[q], with_tangent);
      add(result, weight, answer);
      result.force += weight * G.transpose().lazyProduct(components(answer.stress));
      if (with_tangent)
        add_BtCB(result.tangent, weight, G, answer.tangent);
    }
    return result;
  }

  // <J>, and with m its variation over <J>: d<J> = <J> m . du, dJ = J t . du with t = F^-T : G, at each point.
  std::vector<Tensor> F;
  Vector dilatations(x.rows());
  Matrix t(x.rows(), n);
  for (const Point& p : points)
  {
    F.push_back(Tensor::Identity() + tensor(p.G.lazyProduct(u)));
    const double J = F.back().determinant();
    if (not(J > 0))
      throw std::domain_error("the deformation turns cell " + std::to_string(cell) + " inside out: det F is " +
                              std::to_string(J));
    const Eigen::Index q = Eigen::Index(F.size()) - 1;
    t.row(q) = components(F.back().inverse().transpose()).transpose().lazyProduct(p.G);
    dilatations(q) = J;
  }
  Vector mean = dilatations;
  Matrix m = t;
  std::vector<Matrix> second_J; // second derivatives of J
  if (replaced)
  {
    mean = P.lazyProduct(dilatations);
    m = Matrix(mean.cwiseInverse().asDiagonal() * P * dilatations.asDiagonal()).lazyProduct(t);
    if (not(mean.minCoeff() > 0))
      throw std::domain_error("the deformation turns cell " + std::to_string(cell) +
                              " inside out: the fit of det F is " + std::to_string(mean.minCoeff()));
    for (std::size_t r = 0; r < points.size() and with_tangent; ++r)
    {
      const Eigen::RowVectorXd tr = t.row(Eigen::Index(r));
      second_J.push_back(dilatations(Eigen::Index(r)) *
                         (tr.transpose() * tr - trace_of_products(F[r].inverse(), points[r].G)));
    }
  }
  for (std::size_t q = 0; q < points.size(); ++q)
  {
    const auto& [weight, G] = points[q];
    const Eigen::Index row = Eigen::Index(q);
    // F_bar = alpha F, d alpha = alpha change . du
    const double alpha = replaced ? std::cbrt(mean(row) / dilatations(row)) : 1;
    const Eigen::RowVectorXd change = (m.row(row) - t.row(row)) / 3;
    const Matrix B = alpha * (G + components(F[q]) * change);
    const J2Answer answer = law.answer(k.strain, k.hypothesis, alpha * F[q], committed[q], with_tangent);
    add(result, weight, answer);
    const Components stress = components(answer.stress);
    result.force += weight * B.transpose().lazyProduct(stress);
    if (not with_tangent)
      continue;
    add_BtCB(result.tangent, weight, B, answer.tangent);
    if (replaced) // stress : d2 F_bar
    {
      Matrix dm = -m.row(row).transpose() * m.row(row); // derivative of m
      for (std::size_t r = 0; r < points.size(); ++r)
        dm += P(row, Eigen::Index(r)) / mean(row) * second_J[r];
      const Eigen::RowVectorXd work = stress.transpose().lazyProduct(G);
      const Matrix second = change.transpose() * change + (dm + trace_of_products(F[q].inverse(), G)) / 3;
      result.tangent += weight * alpha *
                        (change.transpose() * work + work.transpose() * change + stress.dot(components(F[q])) * second);
    }
  }
  return result;
}
} // namespace impact_reference
