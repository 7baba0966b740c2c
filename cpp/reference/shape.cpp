// SPDX-License-Identifier: MIT
#include "shape.h"
#include <stdexcept>

namespace impact_reference
{
namespace
{
// One-dimensional Lagrange polynomial of the node at s = -1, 0 or +1, and its derivative.
std::array<double, 2> lagrange(int degree, double s, double x)
{
  if (degree == 1)
    return {0.5 * (1 + s * x), 0.5 * s};
  if (s == 0)
    return {(1 - x) * (1 + x), -2 * x};
  return {0.5 * x * (x + s), x + 0.5 * s};
}

void tensor(int degree, const Matrix& nodes, const Eigen::RowVectorXd& x, Eigen::Ref<Eigen::RowVectorXd> N, Matrix& dN)
{
  const int d = int(nodes.cols());
  for (int i = 0; i < nodes.rows(); ++i)
  {
    std::array<std::array<double, 2>, 3> l{};
    for (int k = 0; k < d; ++k)
      l[k] = lagrange(degree, nodes(i, k), x(k));
    N(i) = 1;
    for (int k = 0; k < d; ++k)
      N(i) *= l[k][0];
    for (int a = 0; a < d; ++a)
    {
      dN(i, a) = 1;
      for (int k = 0; k < d; ++k)
        dN(i, a) *= l[k][k == a];
    }
  }
}

void simplex(int degree, const std::vector<std::vector<int>>& nodes, const Eigen::RowVectorXd& x,
             Eigen::Ref<Eigen::RowVectorXd> N, Matrix& dN)
{
  const int d = int(x.size());
  // Barycentric coordinates L_0 = 1 - sum x, L_k = x_k, and their constant gradients.
  Vector L(d + 1);
  L << 1 - x.sum(), x.transpose();
  Matrix dL = Matrix::Zero(d + 1, d);
  dL.row(0).setConstant(-1);
  dL.bottomRows(d).setIdentity();
  for (std::size_t i = 0; i < nodes.size(); ++i)
  {
    const int a = nodes[i][0];
    if (degree == 1)
    {
      N(i) = L(a);
      dN.row(i) = dL.row(a);
    }
    else if (nodes[i].size() == 1)
    {
      N(i) = L(a) * (2 * L(a) - 1);
      dN.row(i) = (4 * L(a) - 1) * dL.row(a);
    }
    else
    {
      const int b = nodes[i][1];
      N(i) = 4 * L(a) * L(b);
      dN.row(i) = 4 * (L(a) * dL.row(b) + L(b) * dL.row(a));
    }
  }
}
} // namespace

Shapes shape_functions(CellType cell, int degree, const Matrix& points)
{
  const auto& nodes = node_vertices(cell, degree);
  if (points.cols() != tdim(cell))
    throw std::invalid_argument(std::string("points on a ") + to_string(cell) + " need " + std::to_string(tdim(cell)) +
                                " coordinates each, but " + std::to_string(points.cols()) + " were given");
  Shapes s{Matrix(points.rows(), nodes.size()), std::vector<Matrix>(points.rows(), Matrix(nodes.size(), tdim(cell)))};
  const Matrix coordinates = reference_nodes(cell, degree);
  for (int q = 0; q < points.rows(); ++q)
  {
    Eigen::RowVectorXd N(nodes.size());
    if (is_simplex(cell))
      simplex(degree, nodes, points.row(q), N, s.dN[q]);
    else
      tensor(degree, coordinates, points.row(q), N, s.dN[q]);
    s.N.row(q) = N;
  }
  return s;
}
} // namespace impact_reference
