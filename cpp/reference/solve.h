// SPDX-License-Identifier: MIT
#pragma once
#include "Model.h"
#include <Eigen/Sparse>
#include <optional>

namespace impact_reference
{
/// Result of a static analysis.
struct StaticSolution
{
  Vector u;                      ///< [L]
  Vector reactions;              ///< internal force minus load on fixed degrees of freedom, zero elsewhere [F]
  std::vector<int> iterations;   ///< Newton iterations of every load step
  std::vector<double> residuals; ///< relative residual at the end of every load step
};

/// Options of the Newton iteration.
struct NewtonOptions
{
  int steps = 1;            ///< equal load steps; a step that fails is halved, up to ten times
  double tolerance = 1e-10; ///< on |residual| / (|internal force| + |load|)
  int max_iterations = 25;
};

/// Solves internal_force(u) = load with u = values on the fixed degrees of freedom: one sparse LDL^T solution for
/// linear materials, Newton's method with load steps otherwise (Bathe ch. 8.4; Bonet & Wood ch. 9.6).
/// @throws std::invalid_argument for wrong sizes, dofs out of range or NaN
/// @throws std::runtime_error if the system is singular (naming the rigid motions left free) or Newton's method fails
StaticSolution solve_static(const Model& model, const Rule& rule, const std::vector<std::int64_t>& fixed_dofs,
                            const Vector& values, const Vector& load, const NewtonOptions& options);

/// Lowest natural frequencies and modes.
struct Frequencies
{
  Vector omega; ///< angular frequencies, increasing; 0 for rigid modes up to rounding [1/T]
  Matrix modes; ///< (num_dofs, n), mass-orthonormal, zero on fixed degrees of freedom
};

/// Lowest n eigenpairs of K x = omega^2 M x by subspace iteration on the inverse with a small negative shift, so that
/// free bodies are fine (Bathe ch. 11.6).
/// @param M consistent mass, or nullptr to use `lumped`
/// @throws std::invalid_argument if n is not between 1 and the number of free degrees of freedom
/// @throws std::runtime_error if the iteration does not converge or a mass is not positive
Frequencies frequencies(const Model& model, const Csr& K, const Csr* M, const Vector& lumped, int n,
                        const std::vector<std::int64_t>& fixed_dofs);

/// Solution of a system whose matrix need not be symmetric, by sparse LU with one step of refinement. Nothing if the
/// matrix is singular or the solution is not finite.
std::optional<Vector> solve_lu(const Eigen::SparseMatrix<double>& matrix, const Vector& right);

/// Rows and columns of the free degrees of freedom.
Eigen::SparseMatrix<double> reduce(const Csr& matrix, const std::vector<std::int64_t>& numbers);
} // namespace impact_reference
