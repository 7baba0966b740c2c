// SPDX-License-Identifier: MIT
#include "CondensedFactors.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <utility>

using dolfinx_impact::operators::check;
using dolfinx_impact::operators::Entries;

namespace dolfinx_impact::solve
{
CondensedFactors::CondensedFactors(Mat factors, std::shared_ptr<enforcement::Condensation> condensation,
                                   std::vector<std::int8_t> pinned)
    : _factors(factors), _condensation(std::move(condensation)), _pinned(std::move(pinned))
{
  std::ranges::fill(_condensation->known, 0.0);
  check(MatCreateVecs(_condensation->right(), &_right, &_answer), "vectors are made");
}

CondensedFactors::~CondensedFactors()
{
  operators::let_go(PetscObject(_right));
  operators::let_go(PetscObject(_answer));
}

std::vector<double> CondensedFactors::solve(std::span<const double> forces) const
{
  {
    const std::vector<double> condensed = _condensation->residual(forces);
    Entries right(_right);
    for (std::size_t i = 0; i < condensed.size(); ++i)
      right[i] = _pinned[i] ? 0.0 : condensed[i];
  }
  check(MatSolve(_factors, _right, _answer), "a linear system is solved");
  return _condensation->increment(_answer);
}

void CondensedFactors::add_solutions(int num, std::span<const double> forces, std::span<double> increments) const
{
  const std::size_t owned = num_owned();
  Mat right = nullptr, answer = nullptr;
  check(MatCreateDense(PetscObjectComm(PetscObject(_right)), PetscInt(owned), PETSC_DECIDE, PETSC_DETERMINE, num,
                       nullptr, &right),
        "right sides are made");
  double* sides = nullptr;
  check(MatDenseGetArrayWrite(right, &sides), "right sides are written");
  for (int k = 0; k < num; ++k)
  {
    const std::vector<double> condensed = _condensation->residual(forces.subspan(std::size_t(k) * owned, owned));
    for (std::size_t i = 0; i < owned; ++i)
      sides[std::size_t(k) * owned + i] = _pinned[i] ? 0.0 : condensed[i];
  }
  check(MatDenseRestoreArrayWrite(right, &sides), "right sides are written");
  check(MatAssemblyBegin(right, MAT_FINAL_ASSEMBLY), "right sides are made");
  check(MatAssemblyEnd(right, MAT_FINAL_ASSEMBLY), "right sides are made");
  check(MatDuplicate(right, MAT_DO_NOT_COPY_VALUES, &answer), "solutions are made");
  check(MatMatSolve(_factors, right, answer), "several linear systems are solved");
  const double* solutions = nullptr;
  check(MatDenseGetArrayRead(answer, &solutions), "solutions are read");
  for (int k = 0; k < num; ++k)
  {
    {
      Entries unknowns(_answer);
      std::copy_n(solutions + std::size_t(k) * owned, owned, &unknowns[0]);
    }
    const std::vector<double> moved = _condensation->increment(_answer);
    for (std::size_t i = 0; i < owned; ++i)
      increments[std::size_t(k) * owned + i] += moved[i];
  }
  check(MatDenseRestoreArrayRead(answer, &solutions), "solutions are read");
  check(MatDestroy(&right), "right sides are destroyed");
  check(MatDestroy(&answer), "solutions are destroyed");
}
} // namespace dolfinx_impact::solve
