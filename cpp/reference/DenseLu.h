// SPDX-License-Identifier: MIT
#pragma once
#include "Cell.h"

namespace impact_reference
{
/// LU factors of a small matrix with full pivoting, by Eigen, whose templates are compiled here once.
class DenseLu
{
public:
  /// @param matrix square
  explicit DenseLu(const Matrix& matrix);

  bool invertible() const;
  Matrix solve(const Matrix& right) const;

private:
  Eigen::FullPivLU<Matrix> lu_;
};
} // namespace impact_reference
