// SPDX-License-Identifier: MIT
#pragma once

namespace dolfinx_impact
{
/// Scalar product of vectors of n components.
inline double dot(const double* a, const double* b, int n)
{
  double sum = 0.0;
  for (int c = 0; c < n; ++c)
    sum += a[c] * b[c];
  return sum;
}
} // namespace dolfinx_impact
