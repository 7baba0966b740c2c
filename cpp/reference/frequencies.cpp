// SPDX-License-Identifier: MIT
#include "SymmetricEigen.h"
#include "solve.h"
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace impact_reference
{
namespace
{
using Sparse = Eigen::SparseMatrix<double>;
using Dense = Eigen::MatrixXd;

// Deterministic start vectors without structure: a linear congruential sequence.
Dense start_vectors(Eigen::Index rows, int columns)
{
  Dense X(rows, columns);
  std::uint64_t state = 88172645463325252ull;
  for (int j = 0; j < columns; ++j)
    for (Eigen::Index i = 0; i < rows; ++i)
    {
      state = state * 6364136223846793005ull + 1442695040888963407ull;
      X(i, j) = double(state >> 11) / double(1ull << 53) - 0.5;
    }
  return X;
}

// Makes the columns of X mass-orthonormal, by Gram and Schmidt's process done twice: rigid modes dominate a column by
// many orders of magnitude after a solution, and one pass would leave their rounding in it (Parlett, "twice is
// enough").
void orthonormalise(Dense& X, const Sparse& m)
{
  for (Eigen::Index j = 0; j < X.cols(); ++j)
  {
    Vector x = X.col(j) / X.col(j).norm();
    for (int pass = 0; pass < 2; ++pass)
    {
      const Vector y = m * x;
      x -= X.leftCols(j) * (X.leftCols(j).transpose() * y).eval();
      const double size = x.dot(m * x);
      if (not(size > 0))
        throw std::runtime_error(
            "subspace iteration broke down: the vectors became dependent; ask for fewer frequencies");
      x /= std::sqrt(size);
    }
    X.col(j) = x;
  }
}
} // namespace

Frequencies frequencies(const Model& model, const Csr& K, const Csr* M, const Vector& lumped, int n,
                        const std::vector<std::int64_t>& fixed_dofs)
{
  const std::vector<std::int64_t> numbers = free_numbers(model.elimination_order(), model.gdim(), fixed_dofs);
  const Sparse k = reduce(K, numbers);
  if (n < 1 or n > k.rows())
    throw std::invalid_argument(std::to_string(n) + " frequencies were asked for, but the model has " +
                                std::to_string(k.rows()) + " free degrees of freedom");
  Sparse m;
  if (M)
    m = reduce(*M, numbers);
  else
  {
    Vector diagonal(k.rows());
    for (std::int64_t i = 0; i < K.size; ++i)
      if (numbers[i] >= 0)
        diagonal(numbers[i]) = lumped(i);
    m = Sparse(diagonal.asDiagonal());
  }
  const Vector masses = m.diagonal();
  if (not(masses.minCoeff() > 0))
    throw std::runtime_error("a nodal mass is not positive: choose the lumping scheme hrz or auto");

  // The shift sits far below the lowest elastic eigenvalue of any sensible mesh, yet K + shift M is safely regular.
  const double shift = 1e-7 * (k.diagonal().array() / masses.array()).maxCoeff();
  Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> solver(Sparse(k + shift * m));
  if (solver.info() != Eigen::Success)
    throw std::runtime_error("the shifted stiffness could not be factorised: check the mesh for degenerate cells");

  const int q = int(std::min<std::int64_t>(k.rows(), std::max(2 * n, n + 8)));
  Dense X = start_vectors(k.rows(), q);
  Vector values = Vector::Zero(q), before = Vector::Constant(q, -1);
  for (int iteration = 0; iteration < 500; ++iteration)
  {
    X = solver.solve(Dense(m * X));
    orthonormalise(X, m);
    const Dense a = X.transpose() * (k * X);
    const SymmetricEigen small(0.5 * (a + a.transpose()));
    if (not small.converged())
      throw std::runtime_error("the projected eigenvalue problem could not be solved: check the material data");
    values = small.eigenvalues();
    X = X * small.eigenvectors();
    const Vector change = (values - before).cwiseAbs();
    before = values;
    // Rigid modes carry rounding of about machine epsilon times the largest eigenvalue, 1e-9 of the shift.
    bool done = iteration > 2;
    for (int i = 0; i < n; ++i)
      done = done and change(i) <= 1e-12 * std::abs(values(i)) + 1e-8 * shift;
    if (not done)
      continue;
    if (values(0) < -1e-3 * shift)
      throw std::runtime_error("the stiffness has a negative eigenvalue, " + std::to_string(values(0)) +
                               ": check the material data");
    Frequencies result{values.head(n).cwiseMax(0).cwiseSqrt(), Matrix::Zero(K.size, n)};
    for (std::int64_t i = 0; i < K.size; ++i)
      if (numbers[i] >= 0)
        result.modes.row(i) = X.row(numbers[i]).head(n);
    return result;
  }
  throw std::runtime_error("subspace iteration did not converge in 500 iterations: ask for a few more frequencies");
}
} // namespace impact_reference
