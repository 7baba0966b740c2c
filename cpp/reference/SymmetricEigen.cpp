// SPDX-License-Identifier: MIT
#include "SymmetricEigen.h"
#include <Eigen/Eigenvalues>

namespace impact_reference
{
SymmetricEigen::SymmetricEigen(const Eigen::MatrixXd& matrix, bool with_vectors)
{
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix, with_vectors ? Eigen::ComputeEigenvectors
                                                                                   : Eigen::EigenvaluesOnly);
  converged_ = solver.info() == Eigen::Success;
  values_ = solver.eigenvalues();
  if (with_vectors)
    vectors_ = solver.eigenvectors();
}
} // namespace impact_reference
