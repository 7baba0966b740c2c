// SPDX-License-Identifier: MIT
#pragma once

/// What generated kernels need of their scalar type T: double, or a vector of doubles that holds one cell per lane.
/// The vectors are the compiler's own (GCC and Clang vector extensions): arithmetic and comparison work as on double.
/// So are the mathematical functions (__builtin_sqrt is sqrt): hundreds of small sources include this file, and most of
/// their compilation would be that of the header cmath.
namespace dolfinx_impact::kernels
{
template <typename T>
inline constexpr bool is_double = false;
template <>
inline constexpr bool is_double<double> = true;

template <int N>
struct Lanes
{
  typedef double type __attribute__((vector_size(N * sizeof(double))));
};
template <>
struct Lanes<1>
{
  typedef double type;
};

/// Unsigned integers of the size of the lanes, for the bits of numbers. Unsigned, as shifts and sums of the bits of any
/// number are to be defined: also of those lanes whose result is replaced afterwards.
template <typename T>
struct BitsOf
{
  typedef unsigned long long type __attribute__((vector_size(sizeof(T))));
};
template <>
struct BitsOf<double>
{
  using type = unsigned long long;
};
template <typename T>
inline typename BitsOf<T>::type bits_of(T x)
{
  return __builtin_bit_cast(typename BitsOf<T>::type, x);
}
template <typename T>
inline T from_bits(typename BitsOf<T>::type bits)
{
  return __builtin_bit_cast(T, bits);
}

template <typename T>
inline T splat(double x)
{
  return x - T{}; // not a sum, which would lose the sign of -0
}
template <>
inline double splat<double>(double x)
{
  return x;
}
template <typename T>
inline T splat(T x)
  requires(!is_double<T>)
{
  return x;
}

/// Zeroes an array of T, of any rank. Compilers make a call of memset out of a loop of zeros, with narrow stores that
/// what follows waits for; so they are not told that it is zero.
template <typename T, typename Array>
inline void clear(Array& array)
{
  T zero{};
#if defined(__x86_64__) && defined(__GNUC__)
  __asm__("" : "+x"(zero));
#endif
  T* entries = reinterpret_cast<T*>(&array);
#pragma GCC unroll 16
  for (unsigned i = 0; i < sizeof(Array) / sizeof(T); ++i)
    entries[i] = zero;
}

template <typename T>
inline double select(bool condition, double a, double b)
  requires(is_double<T>)
{
  return condition ? a : b;
}
template <typename T, typename Mask, typename U, typename V>
inline T select(Mask condition, U a, V b)
  requires(!is_double<T>)
{
  return condition ? splat<T>(a) : splat<T>(b);
}

/// Does a condition hold in any lane? The compiler's own reduction of a comparison is a chain of shuffles.
inline bool any_lane(bool condition)
{
  return condition;
}
template <typename Mask>
inline bool any_lane(Mask condition)
{
#if defined(__GNUC__) && !defined(__clang__) && defined(__AVX512DQ__)
  if constexpr (sizeof(Mask) == 64)
  {
    typedef long long Integers __attribute__((vector_size(64)));
    return __builtin_ia32_cvtq2mask512(__builtin_bit_cast(Integers, condition)) != 0;
  }
#endif
#if defined(__GNUC__) && !defined(__clang__) && defined(__AVX__)
  if constexpr (sizeof(Mask) == 32)
    return __builtin_ia32_movmskpd256(__builtin_bit_cast(Lanes<4>::type, condition)) != 0;
#endif
  bool found = false;
  for (unsigned i = 0; i < sizeof(Mask) / sizeof(condition[0]); ++i)
    found |= condition[i] != 0;
  return found;
}

namespace math
{
#define IMPACT_SCALAR(name)                                                                                            \
  inline double name(double x)                                                                                         \
  {                                                                                                                    \
    return __builtin_##name(x);                                                                                        \
  }
IMPACT_SCALAR(acos)
IMPACT_SCALAR(acosh)
IMPACT_SCALAR(asin)
IMPACT_SCALAR(asinh)
IMPACT_SCALAR(atan)
IMPACT_SCALAR(atanh)
IMPACT_SCALAR(cos)
IMPACT_SCALAR(cosh)
IMPACT_SCALAR(erf)
IMPACT_SCALAR(exp)
IMPACT_SCALAR(log)
IMPACT_SCALAR(sin)
IMPACT_SCALAR(sinh)
IMPACT_SCALAR(sqrt)
IMPACT_SCALAR(tan)
IMPACT_SCALAR(tanh)
#undef IMPACT_SCALAR
inline double atan2(double y, double x)
{
  return __builtin_atan2(y, x);
}
inline double pow(double x, double p)
{
  return __builtin_pow(x, p);
}
inline double abs(double x)
{
  return __builtin_fabs(x);
}
inline double min(double a, double b)
{
  return __builtin_fmin(a, b);
}
inline double max(double a, double b)
{
  return __builtin_fmax(a, b);
}

template <typename T>
concept Vector = !is_double<T> && requires(T x) { x[0]; };

/// One call per lane: for functions without a vector instruction or library routine.
template <Vector T, typename F>
inline T each(T x, F f)
{
  T y = x; // all lanes are replaced
  for (unsigned i = 0; i < sizeof(T) / sizeof(double); ++i)
    y[i] = f(x[i]);
  return y;
}
template <Vector T, typename F>
inline T each(T x, T y, F f)
{
  T z = x;
  for (unsigned i = 0; i < sizeof(T) / sizeof(double); ++i)
    z[i] = f(x[i], y[i]);
  return z;
}
#define IMPACT_EACH(name)                                                                                              \
  template <Vector T>                                                                                                  \
  inline T name(T x)                                                                                                   \
  {                                                                                                                    \
    return each(x, [](double a) { return __builtin_##name(a); });                                                      \
  }
IMPACT_EACH(sqrt)
IMPACT_EACH(sin)
IMPACT_EACH(cos)
IMPACT_EACH(tan)
IMPACT_EACH(acos)
IMPACT_EACH(asin)
IMPACT_EACH(atan)
IMPACT_EACH(cosh)
IMPACT_EACH(sinh)
IMPACT_EACH(tanh)
IMPACT_EACH(acosh)
IMPACT_EACH(asinh)
IMPACT_EACH(atanh)
IMPACT_EACH(erf)
#undef IMPACT_EACH

// The C library's vector logarithm (libmvec, at most 4 units in the last place off).
#if defined(__GLIBC__) && defined(__AVX2__)
extern "C" Lanes<4>::type _ZGVdN4v_log(Lanes<4>::type);
inline Lanes<4>::type log(Lanes<4>::type x)
{
  return _ZGVdN4v_log(x);
}
#endif
#if defined(__GLIBC__) && defined(__AVX512F__)
extern "C" Lanes<8>::type _ZGVeN8v_log(Lanes<8>::type);
inline Lanes<8>::type log(Lanes<8>::type x)
{
  return _ZGVeN8v_log(x);
}
#endif
template <Vector T>
inline T log(T x)
{
  return each(x, [](double a) { return __builtin_log(a); });
}

/// Exponential to two units in the last place, without a call: one would save and load all that registers hold.
/// exp(x) = 2^n exp(r) with |r| <= ln(2)/2. Beyond 700, lanes take the C library's function.
template <Vector T>
inline T exp(T x)
{
  constexpr double shift = 6755399441055744.0; // 1.5 2^52: its last bits count ones
  constexpr double ln2_high = 0x1.62e42fee00000p-1, ln2_low = 0x1.a39ef35793c76p-33;
  const T shifted = x * 1.4426950408889634 + shift, n = shifted - shift;
  const T r = (x - n * ln2_high) - n * ln2_low;
  // Taylor's polynomial of degree 13: the next term is below 5e-18. In pairs (Estrin), which do not wait for each
  // other.
  const T r2 = r * r, r4 = r2 * r2;
  const T a = (0.5 + r * (1.0 / 6.0)) + r2 * (1.0 / 24.0 + r * (1.0 / 120.0));
  const T b = (1.0 / 720.0 + r * (1.0 / 5040.0)) + r2 * (1.0 / 40320.0 + r * (1.0 / 362880.0));
  const T c = (1.0 / 3628800.0 + r * (1.0 / 39916800.0)) + r2 * (1.0 / 479001600.0 + r * (1.0 / 6227020800.0));
  const T p = 1.0 + (r + r2 * (a + r4 * (b + r4 * c)));
  T y = p * from_bits<T>((bits_of(shifted) << 52) + 0x3ff0000000000000u);
  const auto regular = (x > -700.0) & (x < 700.0);
  if (any_lane(~regular)) [[unlikely]]
    for (unsigned i = 0; i < sizeof(T) / sizeof(double); ++i)
      if (regular[i] == 0)
        y[i] = __builtin_exp(x[i]);
  return y;
}
template <Vector T>
inline T pow(T x, double p)
{
  return each(x, [p](double a) { return __builtin_pow(a, p); });
}
template <Vector T>
inline T pow(T x, T p)
{
  return each(x, p, [](double a, double b) { return __builtin_pow(a, b); });
}
template <Vector T>
inline T atan2(T y, T x)
{
  return each(y, x, [](double a, double b) { return __builtin_atan2(a, b); });
}
template <Vector T>
inline T abs(T x)
{
  return from_bits<T>(bits_of(x) & 0x7fffffffffffffffu); // without its sign; also of -0 and of what is not a number
}
// As fmin and fmax: if one argument is not a number, the result is the other one.
template <Vector T>
inline T min(T a, T b)
{
  return (a < b) | (b != b) ? a : b;
}
template <Vector T>
inline T max(T a, T b)
{
  return (a > b) | (b != b) ? a : b;
}

/// x^(-1/3) of 1e-290 < x < 1e290, to two units in the last place; without division or branch, the same in all widths.
template <typename T>
inline T inverse_cube_root(T x)
{
  // A first value, 4 % off, from the bits of x, whose exponent is divided by -3. Vector units have no division of
  // integers: the upper 52 bits are divided as a number, which is an integer when 2^52 is added.
  constexpr double two52 = 4503599627370496.0;
  constexpr unsigned long long two52_bits = 0x4330000000000000u;
  const T upper = from_bits<T>((bits_of(x) >> 12) | two52_bits) - two52;
  const T thirds = 1499660000000000.0 - upper * (1.0 / 3.0);
  T z = from_bits<T>((bits_of(T(thirds + two52)) & 0x000fffffffffffffu) << 12);
  // z (1 - r)^(-1/3) with r = 1 - x z^3, to the third power of r: 0.1, 1e-5, 1e-17 are the sizes of r.
  for (int i = 0; i < 2; ++i)
  {
    const T r = 1.0 - x * z * (z * z);
    z += z * r * (1.0 / 3.0 + r * (2.0 / 9.0 + r * (14.0 / 81.0)));
  }
  return z;
}

/// x^(k/3). Numbers beyond the range of `inverse_cube_root` take the C library's function, lane by lane.
template <int k, typename T>
inline T third_power(T x)
{
  static_assert(k == 1 or k == 2 or k == -1 or k == -2);
  const T z = inverse_cube_root(x);
  T y = k == -1 ? z : k == -2 ? T(z * z) : k == 1 ? T(x * (z * z)) : T(x * z);
  if constexpr (__is_same(T, double))
    return x > 1e-290 and x < 1e290 ? y : __builtin_pow(x, k / 3.0);
  else
  {
    const auto regular = (x > 1e-290) & (x < 1e290);
    if (any_lane(~regular)) [[unlikely]]
      for (unsigned i = 0; i < sizeof(T) / sizeof(double); ++i)
        if (regular[i] == 0)
          y[i] = __builtin_pow(x[i], k / 3.0);
    return y;
  }
}
} // namespace math
} // namespace dolfinx_impact::kernels
