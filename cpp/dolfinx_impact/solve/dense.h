// SPDX-License-Identifier: MIT
#pragma once
#include <optional>
#include <vector>

namespace dolfinx_impact::solve
{
struct SymmetricEigen
{
  std::vector<double> values;  ///< in ascending order
  std::vector<double> vectors; ///< orthonormal; vector k is [k*n, (k + 1)*n)
};

/// Eigenvalues and eigenvectors of a small symmetric matrix, by LAPACK.
/// @param[in] A entries [i*n + j]
/// @throws std::runtime_error if LAPACK fails
SymmetricEigen symmetric_eigen(std::vector<double> A, int n);

/// Solve a small dense linear system, by LAPACK.
/// @param[in] A entries column after column, [j*n + i]
/// @param[in] b right side, n entries
/// @returns the solution; nothing if the matrix is singular
std::optional<std::vector<double>> solve_dense(std::vector<double> A, std::vector<double> b);

/// Largest absolute eigenvalue of a small dense matrix, by LAPACK.
/// @param[in] A entries [i*n + j]
/// @throws std::runtime_error if LAPACK fails
double spectral_radius(std::vector<double> A, int n);
} // namespace dolfinx_impact::solve
