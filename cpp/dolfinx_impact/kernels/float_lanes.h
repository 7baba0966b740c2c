// SPDX-License-Identifier: MIT
#pragma once
#include "simd.h"

/// What generated kernels in float need of their type T, a vector of floats that holds one cell per lane: the names of
/// simd.h and functions.h, which are for double.
namespace dolfinx_impact::kernels::floats
{
template <int N>
struct Lanes
{
  typedef float type __attribute__((vector_size(N * sizeof(float))));
};
/// Integers of the size of the lanes. Sums of the bits of any number are to be defined, so they are unsigned.
template <typename T>
struct BitsOf
{
  typedef unsigned type __attribute__((vector_size(sizeof(T))));
  typedef int with_sign __attribute__((vector_size(sizeof(T))));
};

template <typename T>
inline T splat(float x)
{
  return x - T{}; // not a sum, which would lose the sign of -0
}
template <typename T>
inline T splat(T x)
{
  return x;
}

/// Numbers are converted as those of the type double of simd.h are.
template <typename T, typename Mask, typename U, typename V>
inline T select(Mask condition, U a, V b)
{
  return condition ? splat<T>(a) : splat<T>(b);
}

namespace math
{
template <typename T>
inline T abs(T x)
{
  return __builtin_bit_cast(T, __builtin_bit_cast(typename BitsOf<T>::type, x) & 0x7fffffffu);
}

/// Natural logarithm within two units in the last place (Cephes, logf: S. L. Moshier); not a number for x <= 0, of
/// cells that are turned inside out, and for what is not finite. Subnormal x count as not positive.
template <typename T>
inline T log(T x)
{
  typedef typename BitsOf<T>::type Integers;
  // x = 2^exponent m with m between sqrt(1/2) and sqrt(2)
  const Integers bits = __builtin_bit_cast(Integers, x) - 0x3f3504f3u;
  const T m = __builtin_bit_cast(T, (bits & 0x007fffffu) + 0x3f3504f3u);
  const T e = __builtin_convertvector(__builtin_bit_cast(typename BitsOf<T>::with_sign, bits) >> 23, T);
  const T f = m - 1.0f, z = f * f;
  T y = 7.0376836292e-2f * f - 1.1514610310e-1f;
  y = y * f + 1.1676998740e-1f;
  y = y * f - 1.2420140846e-1f;
  y = y * f + 1.4249322787e-1f;
  y = y * f - 1.6668057665e-1f;
  y = y * f + 2.0000714765e-1f;
  y = y * f - 2.4999993993e-1f;
  y = y * f + 3.3333331174e-1f;
  y = y * f * z - 2.12194440e-4f * e - 0.5f * z;
  const T value = f + y + 0.693359375f * e;
  return (x >= 0x1p-126f) & (x <= 0x1.fffffep127f) ? value : splat<T>(__builtin_nanf(""));
}
} // namespace math
} // namespace dolfinx_impact::kernels::floats
