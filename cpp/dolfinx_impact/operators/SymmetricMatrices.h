// SPDX-License-Identifier: MIT
#pragma once
#include "lanes.h"
#include <array>
#include <cstddef>

namespace dolfinx_impact::operators
{
/// Extreme eigenvalues of small symmetric matrices of one size, some at a time: a matrix per lane of the processor's
/// vectors. Householder's reflections make them tridiagonal, Sturm's sequences bisect for the ends of their spectra
/// (Golub & Van Loan, Matrix Computations, 8.3.1 and 8.4.1). The memory serves one set of matrices after the other.
class SymmetricMatrices
{
public:
  static constexpr int num = 4; ///< matrices at a time

  /// @param[in] n number of rows
  explicit SymmetricMatrices(int n);

  int size() const { return _n; }
  /// Entry of matrix `which` in row i and column j <= i; all of these are to be written.
  double& operator()(int which, int i, int j) { return _entries[(std::size_t(i) * (i + 1) / 2 + j) * num + which]; }

  /// Frobenius norms of a matrix's parts.
  struct Norms
  {
    double symmetric, skew;
  };
  /// Write the symmetric parts of D S D, D the diagonal matrix of d.
  /// @param[in] S matrices, entry (i, j) of matrix k at [num * (n * i + j) + k], aligned
  /// @param[in] d entry i of matrix k at [num * i + k], aligned
  /// @returns norms of both parts of D S D, for each matrix
  std::array<Norms, num> set_scaled(const double* S, const double* d);

  /// Smallest and largest eigenvalue of each matrix, right to some units of round-off of the largest absolute value.
  /// The matrices are overwritten.
  /// @pre all entries are finite
  std::array<std::array<double, 2>, num> extreme_eigenvalues();

private:
  int _n;
  AlignedVector _entries; ///< lower triangles, row by row, of all matrices
  AlignedVector _work;    ///< vectors of all matrices
};
} // namespace dolfinx_impact::operators
