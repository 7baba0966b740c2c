// SPDX-License-Identifier: MIT
#pragma once
#include <petscmat.h>
#include <span>
#include <vector>

namespace dolfinx_impact::operators
{
/// Cholesky factors of a sparse matrix of this process, in the order of nested dissection.
class CholeskyFactors
{
public:
  /// @param[in] A symmetric and positive definite
  /// @throws std::runtime_error if it is not: PETSc's message
  explicit CholeskyFactors(Mat A);
  ~CholeskyFactors();
  CholeskyFactors(const CholeskyFactors&) = delete;
  CholeskyFactors& operator=(const CholeskyFactors&) = delete;

  /// Solve A x = b for some entries of longer vectors. No allocation.
  /// @param[in] places of the entries in `b` and `x`
  void solve(std::span<const PetscInt> places, std::span<const double> b, std::span<double> x);

private:
  Mat _factors = nullptr;
  std::vector<double> _b, _x;
  Vec _right = nullptr, _solution = nullptr; ///< views of `_b` and `_x`
};
} // namespace dolfinx_impact::operators
