// SPDX-License-Identifier: MIT
#pragma once
#include <optional>
#include <span>
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

/// Largest singular value of a small dense matrix, by LAPACK.
/// @param[in] A entries [i*n + j]
/// @throws std::runtime_error if LAPACK fails
double spectral_norm(std::vector<double> A, int n);

/// Non-negative x with the least |A^T x - b|, by the active set method of Lawson and Hanson, Solving least squares
/// problems (1974), chapter 23.
/// @param[in] rows of A, each as long as b
/// @returns an entry per row
std::vector<double> nonnegative_least_squares(const std::vector<std::vector<double>>& rows,
                                              const std::vector<double>& b);

/// Inverse of a small dense matrix, by LAPACK.
/// @param[in] A entries [i*n + j]
/// @returns entries of the inverse; nothing if the matrix is singular
std::optional<std::vector<double>> inverse(std::vector<double> A, int n);

/// y = A x of a dense matrix, by BLAS.
/// @param[in] A entries [i*x.size() + j]
/// @param[in] rows number of its rows
std::vector<double> dense_product(std::span<const double> A, std::span<const double> x, int rows);

/// A^T A of a dense matrix with n rows and columns, by BLAS.
/// @param[in] A entries [i*n + j]
std::vector<double> normal_matrix(std::span<const double> A, int n);
} // namespace dolfinx_impact::solve
