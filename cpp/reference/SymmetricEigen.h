// SPDX-License-Identifier: MIT
#pragma once
#include "Cell.h"

namespace impact_reference
{
/// Eigenvalues and eigenvectors of a symmetric matrix, by Eigen's solver, which is compiled here once.
class SymmetricEigen
{
public:
  /// @param matrix symmetric; its lower triangle is read
  /// @param with_vectors false: eigenvalues alone
  explicit SymmetricEigen(const Eigen::MatrixXd& matrix, bool with_vectors = true);

  bool converged() const { return converged_; }
  const Vector& eigenvalues() const { return values_; }            ///< ascending
  const Eigen::MatrixXd& eigenvectors() const { return vectors_; } ///< in columns, of length 1

private:
  Vector values_;
  Eigen::MatrixXd vectors_;
  bool converged_;
};
} // namespace impact_reference
