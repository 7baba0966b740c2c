// SPDX-License-Identifier: MIT
#pragma once
#include <algorithm>
#include <cmath>
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

/// Vector product of vectors of three components; `out` is another vector.
/// @tparam T double, or a vector of doubles
template <typename T>
inline void cross(const T* a, const T* b, T* out)
{
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

namespace common
{
template <typename T>
std::vector<T> copy_of(std::span<const T> values)
{
  return {values.begin(), values.end()};
}

/// Largest modulus of some numbers; zero without any, nan if one is nan.
inline double largest_modulus(std::span<const double> values)
{
  double out = 0.0;
  for (double value : values)
  {
    if (std::isnan(value))
      return value;
    out = std::max(out, std::abs(value));
  }
  return out;
}
} // namespace common
} // namespace dolfinx_impact
