// SPDX-License-Identifier: MIT
#pragma once

/// What generated kernels need of their scalar type T: double, or a vector of doubles that holds one cell per lane.
/// The vectors are the compiler's own (GCC and Clang vector extensions): arithmetic and comparison work as on double.
/// Their functions are in functions.h.
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

/// x as a variable of its own: a product is rounded before it is added to what follows, wherever the compiler puts it.
template <typename T>
__attribute__((always_inline)) inline T rounded(T x)
{
#if defined(__x86_64__) && defined(__GNUC__)
  __asm__("" : "+v"(x));
#endif
  return x;
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

/// Is low < x < high in every lane? Not where x is not a number.
template <typename T>
inline bool all_between(T x, double low, double high)
{
#if defined(__GNUC__) && !defined(__clang__) && defined(__AVX512F__)
  if constexpr (sizeof(T) == 64) // greater (30), then less (17): lanes of the first comparison only
    return __builtin_ia32_cmppd512_mask(x, splat<T>(high), 17,
                                        __builtin_ia32_cmppd512_mask(x, splat<T>(low), 30, 0xff, 4), 4) == 0xff;
#endif
  return !any_lane(((x > low) & (x < high)) == 0);
}
} // namespace dolfinx_impact::kernels
