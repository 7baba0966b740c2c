// SPDX-License-Identifier: MIT
#include "CholeskyFactors.h"
#include "PetscErrorText.h"
#include "petsc_check.h"
#include <stdexcept>

namespace dolfinx_impact::operators
{
CholeskyFactors::CholeskyFactors(Mat A)
{
  PetscInt size = 0;
  check(MatGetSize(A, &size, nullptr), "a matrix is asked for its size");
  IS order = nullptr, other = nullptr;
  MatFactorInfo info;
  check(MatFactorInfoInitialize(&info), "factors are made");
  {
    const PetscErrorText error;
    PetscErrorCode code = MatGetFactor(A, MATSOLVERPETSC, MAT_FACTOR_CHOLESKY, &_factors);
    if (!code)
      code = MatGetOrdering(A, MATORDERINGND, &order, &other);
    if (!code)
      code = MatCholeskyFactorSymbolic(_factors, A, order, &info);
    if (!code)
      code = MatCholeskyFactorNumeric(_factors, A, &info);
    MatFactorError fault = MAT_FACTOR_NOERROR;
    if (!code)
      code = MatFactorGetError(_factors, &fault);
    ISDestroy(&order);
    ISDestroy(&other);
    if (code || fault != MAT_FACTOR_NOERROR)
    {
      MatDestroy(&_factors);
      throw std::runtime_error("the matrix is not positive definite" + (code ? " (" + error.text() + ")" : ""));
    }
  }
  _b.assign(std::size_t(size), 0.0);
  _x.assign(std::size_t(size), 0.0);
  check(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, size, _b.data(), &_right), "a vector is made");
  check(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, size, _x.data(), &_solution), "a vector is made");
}

CholeskyFactors::~CholeskyFactors()
{
  VecDestroy(&_right);
  VecDestroy(&_solution);
  MatDestroy(&_factors);
}

void CholeskyFactors::solve(std::span<const PetscInt> places, std::span<const double> b, std::span<double> x)
{
  for (std::size_t k = 0; k < places.size(); ++k)
    _b[k] = b[std::size_t(places[k])];
  check(MatSolve(_factors, _right, _solution), "a system with Cholesky factors is solved");
  for (std::size_t k = 0; k < places.size(); ++k)
    x[std::size_t(places[k])] = _x[k];
}
} // namespace dolfinx_impact::operators
