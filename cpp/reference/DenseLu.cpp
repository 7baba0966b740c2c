// SPDX-License-Identifier: MIT
#include "DenseLu.h"

namespace impact_reference
{
DenseLu::DenseLu(const Matrix& matrix) : lu_(matrix) {}

bool DenseLu::invertible() const
{
  return lu_.isInvertible();
}

Matrix DenseLu::solve(const Matrix& right) const
{
  return lu_.solve(right);
}
} // namespace impact_reference
