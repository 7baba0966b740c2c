// SPDX-License-Identifier: MIT
#pragma once
#include <span>
#include <vector>

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

namespace common
{
template <typename T>
std::vector<T> copy_of(std::span<const T> values)
{
  return {values.begin(), values.end()};
}
} // namespace common
} // namespace dolfinx_impact
