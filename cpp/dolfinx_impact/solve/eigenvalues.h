// SPDX-License-Identifier: MIT
#pragma once
#include <complex>
#include <optional>
#include <petscmat.h>
#include <petscvec.h>
#include <utility>
#include <vector>

namespace dolfinx_impact::solve
{
/// How systems with the matrix on the right are solved in an eigenproblem.
enum class InnerSolver
{
  conjugate_gradients, ///< with Jacobi's preconditioner, to 1e-10
  cholesky             ///< factors by MUMPS
};

struct EigenOptions
{
  double tolerance = 1e-8;   ///< relative, of an eigenvalue
  int max_iterations = 1000; ///< restarts of Krylov and Schur's method
  InnerSolver inner = InnerSolver::conjugate_gradients;
};

/// Largest eigenvalue lambda of A x = lambda B x with symmetric matrices, B positive definite, by SLEPc's Krylov-Schur
/// method. Collective.
/// @param[in] B null: the identity
/// @returns eigenvalue, and eigenvector of norm one in the norm of B, the caller's to destroy; nothing if the method
/// does not converge
/// @throws std::runtime_error DOLFINx was built without SLEPc
std::optional<std::pair<double, Vec>> largest_eigenvalue(Mat A, Mat B = nullptr, EigenOptions options = {});

/// Eigenvalues of A x = lambda B x with symmetric matrices nearest to a number below all of them, by shift and invert,
/// ascending. Collective.
/// @param[in] count number of eigenvalues
/// @param[in] shift the number
/// @throws std::runtime_error fewer were found, or DOLFINx was built without SLEPc
std::vector<double> lowest_eigenvalues(Mat A, Mat B, int count, double shift, EigenOptions options = {});

/// A solution of (s^2 M + s G + K) x = 0.
struct QuadraticEigenpair
{
  std::complex<double> value;
  Vec real, imaginary; ///< parts of the vector, the caller's to destroy
};

/// Solutions of (s^2 M + s G + K) x = 0 whose s are nearest to a number, by the two-level orthogonal Arnoldi method
/// with shift and invert; as many as converged. Collective.
/// @param[in] count number that is wanted
/// @param[in] shift the number
/// @throws std::runtime_error DOLFINx was built without SLEPc
std::vector<QuadraticEigenpair> quadratic_eigenpairs(Mat K, Mat G, Mat M, int count, double shift,
                                                     EigenOptions options = {});

/// Number of negative eigenvalues of a symmetric matrix, by the inertia of its factors (Sylvester's law). Collective.
int num_negative_eigenvalues(Mat A);
} // namespace dolfinx_impact::solve
