// SPDX-License-Identifier: MIT
#pragma once

/// What generated kernels need of their scalar type T: double, or a vector of doubles that holds one cell per lane.
/// The vectors are the compiler's own (GCC and Clang vector extensions): arithmetic and comparison work as on double.
/// So are the mathematical functions (__builtin_sqrt is sqrt): hundreds of small sources include this file, and most of
/// their compilation would be that of <cmath>.
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

template <typename T>
inline T splat(double x)
{
  return T{} + x;
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
  T y;
  for (unsigned i = 0; i < sizeof(T) / sizeof(double); ++i)
    y[i] = f(x[i]);
  return y;
}
template <Vector T, typename F>
inline T each(T x, T y, F f)
{
  T z;
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

// The C library's vector logarithm and exponential (libmvec, at most 4 units in the last place off).
#if defined(__GLIBC__) && defined(__AVX2__)
extern "C" Lanes<4>::type _ZGVdN4v_log(Lanes<4>::type);
extern "C" Lanes<4>::type _ZGVdN4v_exp(Lanes<4>::type);
inline Lanes<4>::type log(Lanes<4>::type x)
{
  return _ZGVdN4v_log(x);
}
inline Lanes<4>::type exp(Lanes<4>::type x)
{
  return _ZGVdN4v_exp(x);
}
#endif
#if defined(__GLIBC__) && defined(__AVX512F__)
extern "C" Lanes<8>::type _ZGVeN8v_log(Lanes<8>::type);
extern "C" Lanes<8>::type _ZGVeN8v_exp(Lanes<8>::type);
inline Lanes<8>::type log(Lanes<8>::type x)
{
  return _ZGVeN8v_log(x);
}
inline Lanes<8>::type exp(Lanes<8>::type x)
{
  return _ZGVeN8v_exp(x);
}
#endif
template <Vector T>
inline T log(T x)
{
  return each(x, [](double a) { return __builtin_log(a); });
}
template <Vector T>
inline T exp(T x)
{
  return each(x, [](double a) { return __builtin_exp(a); });
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
  return x < 0.0 ? -x : x;
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
} // namespace math
} // namespace dolfinx_impact::kernels
