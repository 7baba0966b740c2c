// SPDX-License-Identifier: MIT
#include "FieldResiduals.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <cmath>
#include <limits>

using dolfinx_impact::operators::check;

namespace dolfinx_impact::solve
{
FieldResiduals::FieldResiduals(MPI_Comm comm, std::vector<std::vector<std::int32_t>> dofs,
                               std::span<const std::int8_t> fixed)
    : _comm(comm), _dofs(std::move(dofs))
{
  for (const std::vector<std::int32_t>& field : _dofs)
  {
    _free.emplace_back();
    std::ranges::copy_if(field, std::back_inserter(_free.back()), [fixed](std::int32_t d) { return !fixed[d]; });
  }
  begin();
}

void FieldResiduals::begin()
{
  _first.clear();
  _scales.assign(_dofs.size(), 0.0);
  _noises.assign(_dofs.size(), 0.0);
}

void FieldResiduals::measure(Mat K, std::span<const double> moved, std::span<const double> residual)
{
  Vec x = nullptr, y = nullptr;
  check(MatCreateVecs(K, &x, &y), "vectors are made");
  {
    operators::Entries values(x);
    for (std::size_t i = 0; i < moved.size(); ++i)
      values[i] = std::abs(moved[i]);
  }
  Mat absolute = nullptr;
  check(MatDuplicate(K, MAT_COPY_VALUES, &absolute), "a matrix is copied");
  // Entry by entry: PETSc has no call for a whole matrix.
  PetscInt low = 0, high = 0;
  check(MatGetOwnershipRange(K, &low, &high), "a matrix is asked for its rows");
  std::vector<double> row_values;
  for (PetscInt row = low; row < high; ++row)
  {
    PetscInt num = 0;
    const PetscInt* columns = nullptr;
    const double* values = nullptr;
    check(MatGetRow(K, row, &num, &columns, &values), "a row is read");
    row_values.assign(values, values + num);
    for (double& v : row_values)
      v = std::abs(v);
    check(MatSetValues(absolute, 1, &row, num, columns, row_values.data(), INSERT_VALUES), "a row is written");
    check(MatRestoreRow(K, row, &num, &columns, &values), "a row is read");
  }
  check(MatAssemblyBegin(absolute, MAT_FINAL_ASSEMBLY), "a matrix is assembled");
  check(MatAssemblyEnd(absolute, MAT_FINAL_ASSEMBLY), "a matrix is assembled");
  check(MatMult(absolute, x, y), "a matrix is multiplied");
  std::vector<double> size;
  {
    operators::Entries terms(y);
    size = norms({&terms[0], terms.size()}, _free);
  }
  check(MatDestroy(&absolute), "a matrix is destroyed");
  check(VecDestroy(&x), "a vector is destroyed");
  check(VecDestroy(&y), "a vector is destroyed");
  const std::vector<double> forces = norms(residual, _dofs);
  for (std::size_t i = 0; i < size.size(); ++i)
  {
    _noises[i] = 4 * std::numeric_limits<double>::epsilon() * size[i];
    _scales[i] = std::max(size[i], forces[i]);
  }
  if (_first.empty())
    _first = _scales;
  for (std::size_t i = 0; i < size.size(); ++i)
    _scales[i] = std::max(_scales[i], _first[i]);
}

bool FieldResiduals::small(std::span<const double> residual, double rtol, double atol) const
{
  const std::vector<double> left = norms(residual, _free);
  for (std::size_t i = 0; i < left.size(); ++i)
    if (!(left[i] <= std::max({atol, _noises[i], rtol * _scales[i]})))
      return false;
  return true;
}

std::vector<double> FieldResiduals::norms(std::span<const double> values,
                                          const std::vector<std::vector<std::int32_t>>& dofs) const
{
  std::vector<double> out;
  for (const std::vector<std::int32_t>& field : dofs)
  {
    double sum = 0.0;
    for (std::int32_t d : field)
      sum += values[d] * values[d];
    out.push_back(sum);
  }
  MPI_Allreduce(MPI_IN_PLACE, out.data(), int(out.size()), MPI_DOUBLE, MPI_SUM, _comm);
  for (double& v : out)
    v = std::sqrt(v);
  return out;
}
} // namespace dolfinx_impact::solve
