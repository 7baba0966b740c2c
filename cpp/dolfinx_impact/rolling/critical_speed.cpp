// SPDX-License-Identifier: MIT
#include "critical_speed.h"
#include "../common/OnAllRanks.h"
#include "../operators/petsc_check.h"
#include "../solve/eigenvalues.h"
#include <cmath>
#include <limits>

namespace dolfinx_impact::rolling
{
namespace
{
using operators::check;
using operators::OwnedMatrix;
using operators::OwnedVector;

constexpr double factor_tolerance = 1e-10; ///< relative, of the eigenvalue that gives the critical speed
} // namespace

operators::OwnedMatrix held_tangent(const solve::EquilibriumProblem& problem)
{
  Mat copy = nullptr;
  check(MatDuplicate(problem.body->tangent(), MAT_COPY_VALUES, &copy), "a matrix is copied");
  OwnedMatrix K(copy);
  for (const auto& contact : problem.contacts)
    if (!contact->has_multipliers())
    {
      contact->update_gap(problem.u->x()->array());
      if (Mat tangent = contact->tangent())
        check(MatAXPY(copy, 1.0, tangent, DIFFERENT_NONZERO_PATTERN), "matrices are added");
    }
  PetscInt first = 0;
  check(MatGetOwnershipRange(copy, &first, nullptr), "a matrix is asked for its rows");
  std::vector<PetscInt> rows;
  for (std::size_t i = 0; i < problem.num_owned(); ++i)
    if (problem.fixed[i])
      rows.push_back(first + PetscInt(i));
  check(MatSetOption(copy, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE), "a matrix is set up");
  check(MatZeroRowsColumns(copy, PetscInt(rows.size()), rows.data(), 1.0, nullptr, nullptr), "rows are set to zero");
  return K;
}

int negative_directions(const solve::EquilibriumProblem& problem)
{
  const OwnedMatrix K = held_tangent(problem);
  return solve::num_negative_eigenvalues(K.get());
}

double critical_factor(const solve::EquilibriumProblem& problem, Mat W)
{
  PetscReal size = 0.0;
  check(MatNorm(W, NORM_FROBENIUS, &size), "a norm is taken");
  if (size == 0.0)
    return std::numeric_limits<double>::infinity();
  const OwnedMatrix K = held_tangent(problem);
  check(MatAXPY(K.get(), 1.0, W, DIFFERENT_NONZERO_PATTERN), "matrices are added");
  solve::EigenOptions options;
  options.tolerance = factor_tolerance;
  options.inner = solve::InnerSolver::cholesky;
  const auto found = solve::largest_eigenvalue(W, K.get(), options);
  const OwnedVector vector(found ? found->second : nullptr);
  if (!found || !(found->first > 0.0))
    throw common::Failure("the eigensolver did not find the critical speed");
  return 1.0 / std::sqrt(found->first);
}
} // namespace dolfinx_impact::rolling
