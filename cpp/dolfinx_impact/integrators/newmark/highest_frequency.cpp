// SPDX-License-Identifier: MIT
#include "highest_frequency.h"
#include "../../common/OnAllRanks.h"
#include "../../operators/petsc_check.h"
#include "../../solve/eigenvalues.h"
#include <algorithm>
#include <cmath>
#include <vector>

using dolfinx_impact::operators::check;

namespace dolfinx_impact::integrators
{
double highest_frequency(Mat stiffness, Mat mass, std::span<const std::int8_t> held)
{
  Mat K = nullptr, M = nullptr;
  check(MatDuplicate(stiffness, MAT_COPY_VALUES, &K), "a stiffness is copied");
  check(MatDuplicate(mass, MAT_COPY_VALUES, &M), "a mass matrix is copied");
  PetscInt first = 0;
  check(MatGetOwnershipRange(M, &first, nullptr), "a mass matrix is asked for its rows");
  std::vector<PetscInt> rows;
  for (std::size_t i = 0; i < held.size(); ++i)
    if (held[i])
      rows.push_back(first + PetscInt(i));
  check(MatZeroRowsColumns(K, PetscInt(rows.size()), rows.data(), 0.0, nullptr, nullptr), "rows are held");
  check(MatZeroRowsColumns(M, PetscInt(rows.size()), rows.data(), 1.0, nullptr, nullptr), "rows are held");
  auto found = solve::largest_eigenvalue(K, M, {.tolerance = 1e-6});
  MatDestroy(&K);
  MatDestroy(&M);
  if (!found)
    throw common::Failure("the highest frequency was not found: take beta >= gamma/2, which is stable with any step");
  VecDestroy(&found->second);
  return std::sqrt(std::max(found->first, 0.0));
}
} // namespace dolfinx_impact::integrators
