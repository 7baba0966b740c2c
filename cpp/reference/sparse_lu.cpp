// SPDX-License-Identifier: MIT
#include "solve.h"
#include <Eigen/SparseLU>

namespace impact_reference
{
std::optional<Vector> solve_lu(const Eigen::SparseMatrix<double>& matrix, const Vector& right)
{
  const Eigen::SparseLU<Eigen::SparseMatrix<double>> lu(matrix);
  if (lu.info() != Eigen::Success)
    return std::nullopt;
  Vector x = lu.solve(right);
  x += lu.solve(right - matrix * x); // one refinement: rows of forces and of gaps differ in size
  if (not x.allFinite())
    return std::nullopt;
  return x;
}
} // namespace impact_reference
