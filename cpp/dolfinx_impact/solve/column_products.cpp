// SPDX-License-Identifier: MIT
#include "column_products.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <functional>

using dolfinx_impact::operators::check;

namespace dolfinx_impact::solve
{
std::vector<double> column_products(std::span<const Mat> matrices, int num, std::vector<double> columns)
{
  std::vector<double> out(columns.size(), 0.0);
  PetscInt owned = 0;
  check(MatGetLocalSize(matrices.front(), &owned, nullptr), "a matrix is asked for its size");
  Mat given = nullptr;
  check(MatCreateDense(PetscObjectComm(PetscObject(matrices.front())), owned, PETSC_DECIDE, PETSC_DETERMINE, num,
                       columns.data(), &given),
        "columns are given");
  for (Mat matrix : matrices)
  {
    Mat product = nullptr;
    const double* values = nullptr;
    check(MatMatMult(matrix, given, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &product), "matrices are multiplied");
    check(MatDenseGetArrayRead(product, &values), "a product is read");
    std::ranges::transform(out, std::span(values, out.size()), out.begin(), std::plus{});
    check(MatDenseRestoreArrayRead(product, &values), "a product is read");
    check(MatDestroy(&product), "a product is destroyed");
  }
  check(MatDestroy(&given), "columns are given back");
  return out;
}
} // namespace dolfinx_impact::solve
