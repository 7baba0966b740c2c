// SPDX-License-Identifier: MIT
#pragma once
#include "simd.h"

/// Mathematical functions of kernels. On a double they are those of the C library. On vectors they are computed here,
/// in registers: a call would save and load all that registers hold, at every point.
///
/// All results of vectors are within two units in the last place, also subnormal ones and those of subnormal numbers,
/// and special values are those of the C library (tests/cpp/test_functions.cpp). A lane's result does not depend on its
/// neighbours. Some functions leave rare arguments to the C library, lane by lane: `replace_lanes`.
///
/// Polynomials interpolate the function at Chebyshev's points in 60 digits; their coefficients are rounded to double.
/// The largest relative error over the interval stands beside each [1]; half a unit in the last place is 1.1e-16.
///
/// The functions of double are the compiler's own (__builtin_sqrt is sqrt): hundreds of small sources include this
/// file, and most of their compilation would be that of the header cmath.
namespace dolfinx_impact::kernels::math
{
#define IMPACT_SCALAR(name)                                                                                            \
  inline double name(double x)                                                                                         \
  {                                                                                                                    \
    return __builtin_##name(x);                                                                                        \
  }
IMPACT_SCALAR(acos)
IMPACT_SCALAR(asin)
IMPACT_SCALAR(atan)
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

inline constexpr double infinity = __builtin_inf(), not_a_number = __builtin_nan("");
inline constexpr double least_normal = 0x1p-1022, largest_subnormal = 0x0.fffffffffffffp-1022;
inline constexpr double ln2_high = 0x1.62e42fefa3000p-1, ln2_low = 0x1.3de6af278ece6p-42; // the first has 41 bits
inline constexpr double pi_low = 0x1.1a62633145c07p-53;                                   // pi less its nearest double
inline constexpr double pi = 0x1.921fb54442d18p+1;
/// Added to a number below 2^51 in size it leaves the nearest integer in the last bits: 1.5 2^52.
inline constexpr double to_integer = 6755399441055744.0;
inline constexpr unsigned long long sign_bit = 0x8000000000000000u;

template <Vector T>
inline T abs(T x)
{
  return from_bits<T>(bits_of(x) & ~sign_bit); // without its sign; also of -0 and of what is not a number
}
/// x with its sign changed where that of y is set.
template <Vector T>
inline T times_sign(T x, T y)
{
  return from_bits<T>(bits_of(x) ^ (bits_of(y) & sign_bit));
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

/// x to the power of n, a power of two.
template <int n, Vector T>
inline T repeated_square(T x)
{
  if constexpr (n == 1)
    return x;
  else
    return repeated_square<n / 2>(T(x * x));
}

/// c[first] + c[first + 1] x + ... of `count` terms in pairs (Estrin), which do not wait for each other.
template <int first, int count, int N, Vector T>
inline T partial_polynomial(const double (&c)[N], T x)
{
  constexpr int half = count > 8 ? 8 : count > 4 ? 4 : count > 2 ? 2 : 1;
  static_assert(first + count <= N and count <= 16);
  if constexpr (count == 1)
    return splat<T>(c[first]);
  else if constexpr (count == 2)
    return c[first] + x * c[first + 1];
  else
    return partial_polynomial<first, half>(c, x) +
           repeated_square<half>(x) * partial_polynomial<first + half, count - half>(c, x);
}
template <int N, Vector T>
inline T polynomial(const double (&c)[N], T x)
{
  return partial_polynomial<0, N>(c, x);
}

/// Lanes that are not regular get the value of a function of double.
template <Vector T, typename Mask, typename F>
inline void replace_lanes(T& y, Mask regular, F function)
{
  if (any_lane(~regular)) [[unlikely]]
    for (unsigned i = 0; i < sizeof(T) / sizeof(double); ++i)
      if (regular[i] == 0)
        y[i] = function(i);
}

/// high + low, with more digits than a number has.
template <typename T>
struct Sum
{
  T high, low;
};

/// a + b exactly, where |a| >= |b| or a = 0.
template <Vector T>
inline Sum<T> ordered_sum(T a, T b)
{
  const T high = a + b;
  return {high, b - (high - a)};
}

/// a + b exactly.
template <Vector T>
inline Sum<T> exact_sum(T a, T b)
{
  const T high = a + b, second = high - a;
  return {high, (a - (high - second)) + (b - second)};
}

/// a b exactly, but for underflow.
template <typename T>
inline Sum<T> exact_product(T a, T b)
{
  const T high = a * b;
#if defined(__GNUC__) && !defined(__clang__) && defined(__AVX512F__)
  if constexpr (sizeof(T) == 64)
    return {high, __builtin_ia32_vfmaddpd512_mask(a, b, -high, -1, 4)}; // 4: the present rounding
#endif
#if defined(__GNUC__) && !defined(__clang__) && defined(__FMA__)
  if constexpr (sizeof(T) == 32)
    return {high, __builtin_ia32_vfmaddpd256(a, b, -high)};
#endif
#if defined(__FP_FAST_FMA) || defined(__FMA__) || defined(__ARM_FEATURE_FMA)
  if constexpr (is_double<T>)
    return {high, __builtin_fma(a, b, -high)};
  else
  {
    T low = high; // all lanes are replaced
    for (unsigned i = 0; i < sizeof(T) / sizeof(double); ++i)
      low[i] = __builtin_fma(a[i], b[i], -high[i]);
    return {high, low};
  }
#else
  // Halves of 26 and 27 bits, whose products are exact (Dekker 1971).
  const T a1 = from_bits<T>(bits_of(a) & 0xfffffffff8000000u), b1 = from_bits<T>(bits_of(b) & 0xfffffffff8000000u);
  const T a2 = a - a1, b2 = b - b1;
  return {high, ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2};
#endif
}

/// Quotient of sums, whose lower parts are far below the upper ones.
template <Vector T>
inline T quotient(const Sum<T>& a, const Sum<T>& b)
{
  const T q = a.high / b.high;
  return q + (a.low - q * b.low) / b.high;
}

template <Vector T>
inline T sqrt(T x)
{
#if defined(__GNUC__) && !defined(__clang__) && defined(__AVX512F__)
  if constexpr (sizeof(T) == 64)
    return __builtin_ia32_sqrtpd512_mask(x, x, -1, 4);
#endif
#if defined(__GNUC__) && !defined(__clang__) && defined(__AVX__)
  if constexpr (sizeof(T) == 32)
    return __builtin_ia32_sqrtpd256(x);
#endif
  T y = x; // all lanes are replaced
  for (unsigned i = 0; i < sizeof(T) / sizeof(double); ++i)
    y[i] = __builtin_sqrt(x[i]);
  return y;
}

/// An integer power of two, 2^n, of integers n in the last bits of numbers, -1022 <= n <= 1023.
template <Vector T>
inline T power_of_two(T integer)
{
  return from_bits<T>((bits_of(integer) << 52) + 0x3ff0000000000000u);
}

/// Has the processor instructions for powers of two of such vectors, which overflow and underflow as they should?
#if defined(__GNUC__) && !defined(__clang__) && defined(__AVX512F__)
template <typename T>
inline constexpr bool has_exponents = sizeof(T) == 64;
#else
template <typename T>
inline constexpr bool has_exponents = false;
#endif

/// p 2^n of a number n that is an integer; without `has_exponents`, -1022 <= n <= 1023.
template <Vector T>
inline T times_power_of_two(T p, T n)
{
#if defined(__GNUC__) && !defined(__clang__) && defined(__AVX512F__)
  if constexpr (has_exponents<T>)
    return __builtin_ia32_scalefpd512_mask(p, n, p, -1, 4);
#endif
  return p * power_of_two(T(n + to_integer));
}

/// exp(high + low) = 2^n p, where low is far below high and n is an integer.
template <Vector T>
struct Exponential
{
  T n, p;
  explicit Exponential(T x) : n(nearest(x)), p(of_remainder((x - n * ln2_high) - n * ln2_low)) {}
  Exponential(T high, T low) : n(nearest(high)), p(of_remainder((high - n * ln2_high) + (low - n * ln2_low))) {}

private:
  static T nearest(T x) { return (x * 1.4426950408889634 + to_integer) - to_integer; }
  static T of_remainder(T r)
  {
    // 1.3e-17: exp(r) but for its first two terms, over r^2, where |r| < ln(2)/2
    static constexpr double series[] = {0.5000000000000001,     0.16666666666666669,    0.041666666666623824,
                                        0.008333333333330039,   0.0013888888917367081,  0.00019841269863171557,
                                        2.4801521057868204e-05, 2.7557268276905696e-06, 2.7620201591031547e-07,
                                        2.5100472505694996e-08};
    return 1.0 + (r + r * r * polynomial(series, r));
  }
};

/// x, or a number near the ends of the range whose exponential overflows or underflows as that of x does.
template <Vector T>
inline T bounded_exponent(T x)
{
  constexpr double least = -747.0, largest = 711.0;
#if defined(__GNUC__) && !defined(__clang__) && defined(__AVX512F__)
  if constexpr (sizeof(T) == 64) // one instruction each; x stands second, as that is taken where it is not a number
  {
    const T upper = __builtin_ia32_minpd512_mask(splat<T>(largest), x, x, -1, 4);
    return __builtin_ia32_maxpd512_mask(splat<T>(least), upper, upper, -1, 4);
  }
#endif
  const T upper = select<T>(x > largest, largest, x);
  return select<T>(upper < least, least, upper);
}

/// The value of an exponential of a bounded exponent over 2^halvings; overflow and underflow as they should.
template <Vector T>
inline T scaled(const Exponential<T>& e, double halvings = 0.0)
{
  const T n = e.n - halvings;
  if constexpr (has_exponents<T>)
    return times_power_of_two(e.p, n);
  // 2^n in two factors: one of them may be beyond the range of normal numbers when their product with p is not.
  const T total = n + to_integer, first = n * 0.5 + to_integer;
  const T second = from_bits<T>(bits_of(total) - bits_of(first));
  return e.p * power_of_two(first) * power_of_two(second);
}

/// exp(x) of all numbers. A function of its own, as it is rarely called.
template <Vector T>
[[gnu::noinline, gnu::cold]] T any_exponential(T x)
{
  return scaled(Exponential<T>(bounded_exponent(x)));
}

template <Vector T>
inline T exp(T x)
{
  if constexpr (has_exponents<T>)
    return scaled(Exponential<T>(bounded_exponent(x)));
  const Exponential<T> e(x);
  T y = times_power_of_two(e.p, e.n);
  if (!all_between(x, -708.0, 708.0)) [[unlikely]]
    y = select<T>(abs(x) < 708.0, y, any_exponential(x));
  return y;
}

/// m and k of a positive number m 2^k that is not subnormal; m is between sqrt(1/2) and sqrt(2).
template <Vector T>
inline void split_exponent(T x, T& m, T& k)
{
  constexpr unsigned long long first = 0x3fe6a09e667f3bcdu; // bits of sqrt(1/2)
  constexpr unsigned long long bias = 0x4000000000000000u;  // of exponents, so that they are positive: 1024 2^52
  const auto exponent = (bits_of(x) + (bias - first)) >> 52;
  m = from_bits<T>(bits_of(x) - (exponent << 52) + bias);
  k = from_bits<T>(exponent | 0x4330000000000000u) - (4503599627370496.0 + 1024.0); // bits of 2^52
}

/// log(x) + shift ln(2) of a positive number that is not subnormal.
/// log(m) = 2 artanh(s) = 2 s + 2 s^3/3 + ... with s = (m - 1)/(m + 1), summed up as f - (f^2/2 - s (f^2/2 + ...)) with
/// f = m - 1: f is exact.
template <Vector T>
inline T regular_logarithm(T x, double shift)
{
  // 4.3e-18: artanh(s) / s^3 - 1/s^2 of s^2.
  static constexpr double series[] = {0.3333333333333335,  0.19999999999949752, 0.14285714312987743, 0.1111110556739754,
                                      0.09091444562630861, 0.07665860800278021, 0.07308224842521703};
  T m, k;
  split_exponent(x, m, k);
  k += shift;
  const T f = m - 1.0, s = f / (m + 1.0), z = s * s, half = 0.5 * f * f;
  const T rest = s * (half + 2.0 * z * polynomial(series, z));
  return k * ln2_high + (f - (half - (rest + k * ln2_low)));
}

/// log(x) where |x - 1| is below near_one, to which x - 1 is exact: changes of volume are mostly as small. No division.
inline constexpr double near_one = 0.0625;
template <Vector T>
inline T logarithm_near_one(T x)
{
  // 1.2e-17: (f - log(1 + f)) / f^2 of f
  static constexpr double series[] = {
      0.5000000000000001,   -0.3333333333333335, 0.2499999999980894,   -0.1999999999982362, 0.16666667057820267,
      -0.14285714646811098, 0.12499719839022179, -0.11110852480322804, 0.10081825031586886, -0.09166444467686555};
  const T f = x - 1.0;
  return f - f * f * polynomial(series, f);
}

template <Vector T>
inline T log(T x)
{
  const auto near = abs(x - 1.0) < near_one;
  if (!any_lane(~near)) [[likely]]
    return logarithm_near_one(x);
  T y = regular_logarithm(x, 0.0);
  if (!all_between(x, largest_subnormal, infinity)) [[unlikely]]
  {
    const auto regular = (x > largest_subnormal) & (x < infinity);
    const T subnormal = regular_logarithm(T(x * 0x1p54), -54.0);
    const T of_negative = select<T>(x < 0.0, not_a_number, x); // what is infinite or not a number stays so
    const T special = select<T>(x == 0.0, -infinity, of_negative);
    y = select<T>(regular, y, select<T>((x > 0.0) & (x < infinity), subnormal, special));
  }
  if (any_lane(near)) [[unlikely]]
    y = select<T>(near, logarithm_near_one(x), y);
  return y;
}

// 1.0e-20: (artanh(s) / s^3 - 1/s^2 - 1/3) / s^2 of s^2, where s = (m - 1)/(m + 1)
inline constexpr double artanh_series[] = {0.2,
                                           0.14285714285714682,
                                           0.11111111110828116,
                                           0.09090909167657202,
                                           0.07692297485447727,
                                           0.06667402119112777,
                                           0.058531242704588336,
                                           0.05861525514070255};

/// k ln(2) and 2 s, with s to twice the digits of a number, of a positive number that is not subnormal.
template <Vector T>
struct LogarithmicParts
{
  T k;
  Sum<T> s;
  explicit LogarithmicParts(T x)
  {
    T m;
    split_exponent(x, m, k);
    const T f = m - 1.0;
    const Sum<T> g = ordered_sum(splat<T>(1.0), m);
    const T inverse = 1.0 / g.high;
    s.high = f * inverse;
    const Sum<T> back = exact_product(s.high, g.high);
    s.low = (((f - back.high) - back.low) - s.high * g.low) * inverse;
  }
};

/// log(x) of a positive number that is not subnormal, to some 58 bits.
template <Vector T>
inline Sum<T> longer_logarithm(T x)
{
  const LogarithmicParts<T> parts(x);
  const T s = parts.s.high, z = s * s;
  const T rest = s * z * (1.0 / 3.0 + z * polynomial(artanh_series, z));
  const Sum<T> first = exact_sum(T(parts.k * ln2_high), T(2.0 * s)); // the first product is exact
  return ordered_sum(first.high, first.low + (parts.k * ln2_low + 2.0 * (parts.s.low + rest)));
}

/// log(x) of a positive number that is not subnormal, to some 66 bits.
template <Vector T>
inline Sum<T> extended_logarithm(T x)
{
  constexpr double third = 1.0 / 3.0, third_low = 0x1.5555555555555p-56;
  const LogarithmicParts<T> parts(x);
  const T s = parts.s.high, s_low = parts.s.low;
  // s^3/3 and what follows: (z + z_low) (1/3 + z q) s.
  const Sum<T> square = exact_product(s, s);
  const T z = square.high, z_low = square.low + 2.0 * s * s_low;
  const Sum<T> factor = ordered_sum(splat<T>(third), z * polynomial(artanh_series, z) + third_low);
  const Sum<T> cubic = exact_product(z, factor.high);
  const T cubic_low = cubic.low + (z * factor.low + z_low * factor.high);
  const Sum<T> rest = exact_product(s, cubic.high);
  const T rest_low = rest.low + (s * cubic_low + s_low * cubic.high);
  const Sum<T> first = exact_sum(T(parts.k * ln2_high), T(2.0 * s));
  const Sum<T> second = exact_sum(first.high, T(2.0 * rest.high));
  return ordered_sum(second.high, second.low + (first.low + (parts.k * ln2_low + 2.0 * (s_low + rest_low))));
}

/// x^p of all numbers. A function of its own, as it is rarely called.
template <Vector T>
[[gnu::noinline, gnu::cold]] T any_power(T x, T p)
{
  const Sum<T> l = extended_logarithm(x), product = exact_product(p, l.high);
  T y = scaled(Exponential<T>(bounded_exponent(product.high), product.low + p * l.low));
  // Beyond this exponent an infinite or a huge p meets numbers that are none.
  const auto regular = (x >= least_normal) & (x < infinity) & (abs(product.high) < 1e4);
  const auto zero = (bits_of(x) == 0) & ((p > 0.0) | (p < 0.0)); // a body that is not strained has many of them
  y = select<T>(zero, select<T>(p > 0.0, 0.0, infinity), y);
  replace_lanes(y, regular | zero, [&](unsigned i) { return __builtin_pow(x[i], p[i]); });
  return y;
}

/// Powers of one x share its logarithm: the compiler sees that it is the same. Where the exponential's argument is
/// small, the logarithm needs less digits.
template <Vector T>
inline T pow(T x, T p)
{
  const Sum<T> l = longer_logarithm(x), product = exact_product(p, l.high);
  const Exponential<T> e(product.high, product.low + p * l.low);
  T y = times_power_of_two(e.p, e.n);
  if (!(all_between(x, largest_subnormal, infinity) & all_between(product.high, -4.0, 4.0))) [[unlikely]]
  {
    const auto regular = (x > largest_subnormal) & (x < infinity) & (abs(product.high) < 4.0);
    y = select<T>(regular, y, any_power(x, p));
  }
  return y;
}
template <Vector T>
inline T pow(T x, double p)
{
  return pow(x, splat<T>(p));
}

/// x^(k/3) of 1e-290 < x < 1e290, from z = x^(-1/3), without division or branch.
template <int k, typename T>
inline T regular_third_power(T x)
{
  static_assert(k == 1 or k == 2 or k == -1 or k == -2);
  // A first value, 4 % off, from the bits of x, whose exponent is divided by -3. Vector units have no division of
  // integers: the upper 52 bits are divided as a number, which is an integer when 2^52 is added.
  constexpr double two52 = 4503599627370496.0;
  constexpr unsigned long long two52_bits = 0x4330000000000000u;
  const T upper = from_bits<T>((bits_of(x) >> 12) | two52_bits) - two52;
  const T thirds = 1499660000000000.0 - upper * (1.0 / 3.0);
  T z = from_bits<T>((bits_of(T(thirds + two52)) & 0x000fffffffffffffu) << 12);
  // z (1 - r)^(-1/3) with r = 1 - x z^3, to the third power of r: 0.1, 1e-5, 1e-21 are the sizes of r. The second time,
  // x z and z^2 keep what is rounded away; of z itself, where it is a third of a unit in the last place, that can go.
  const T first = 1.0 - x * z * (z * z);
  z += z * first * (1.0 / 3.0 + first * (2.0 / 9.0 + first * (14.0 / 81.0)));
  if constexpr (k == -1)
  {
    const T r = 1.0 - x * z * (z * z);
    return z + z * (r * (1.0 / 3.0 + r * (2.0 / 9.0 + r * (14.0 / 81.0))));
  }
  const Sum<T> square = exact_product(z, z), other = exact_product(x, z), one = exact_product(square.high, other.high);
  const T r = (1.0 - one.high) - (one.low + (square.high * other.low + square.low * other.high));
  const T c = r * (1.0 / 3.0 + r * (2.0 / 9.0 + r * (14.0 / 81.0)));
  if constexpr (k == 2)
    return other.high + (other.low + other.high * c);
  if constexpr (k == -2)
    return square.high + (square.low + square.high * (c * (2.0 + c)));
  const Sum<T> root = exact_product(x, square.high);
  return root.high + (root.low + x * square.low + root.high * (c * (2.0 + c)));
}

/// x^(k/3); also of double, as the C library has no such function but its cube root.
template <int k, typename T>
inline T third_power(T x)
{
  T y = regular_third_power<k>(x);
  if (!all_between(x, 1e-290, 1e290)) [[unlikely]]
  {
    const auto regular = (x > 1e-290) & (x < 1e290);
    constexpr double factor = k == 1 ? 0x1p100 : k == -1 ? 0x1p-100 : k == 2 ? 0x1p200 : 0x1p-200;
    const auto small = x < 1.0;
    const T scaled = regular_third_power<k>(T(x * select<T>(small, 0x1p300, 0x1p-300)));
    const T extreme = scaled * select<T>(small, 1.0 / factor, factor);
    const T of_infinity = select<T>(abs(x) == infinity, k > 0 ? infinity : 0.0, not_a_number);
    const T special = select<T>(x == 0.0, k > 0 ? 0.0 : infinity, of_infinity);
    y = select<T>(regular, y, select<T>((x > 0.0) & (x < infinity), extreme, special));
  }
  return y;
}

/// Sine and cosine of x - n pi/2, which is at most pi/4 in size, and n.
template <Vector T>
struct Quadrant
{
  Sum<T> sine, cosine;
  typename BitsOf<T>::type number; ///< its last two bits
};

/// Of |x| < `largest_angle`; pi/2 is subtracted in three parts, the first two of 39 bits, whose products with n are
/// exact.
inline constexpr double largest_angle = 25000.0;
template <Vector T>
inline Quadrant<T> quadrant(T x)
{
  // 1.9e-17: sin(x) / x^3 - 1/x^2 of x^2; 7.7e-19: (cos(x) - 1 + x^2/2) / x^4 of x^2
  static constexpr double sines[] = {-0.16666666666666666,   0.008333333333330936,    -0.00019841269836740527,
                                     2.7557316093196066e-06, -2.5051129895962803e-08, 1.5917988944318488e-10};
  static constexpr double cosines[] = {0.041666666666666664,    -0.0013888888888887389, 2.48015872987544e-05,
                                       -2.7557317265876615e-07, 2.087614504910828e-09,  -1.1382544623404147e-11};
  const T shifted = x * 0x1.45f306dc9c883p-1 + to_integer, n = shifted - to_integer;
  const Sum<T> first = exact_sum(T(x - n * 0x1.921fb54440000p+0), T(n * -0x1.68c234c4c4000p-39));
  const Sum<T> r = ordered_sum(first.high, first.low - n * 0x1.3145c06e0e689p-78);
  const T z = r.high * r.high, half = 0.5 * z, c = 1.0 - half;
  Sum<T> sine = ordered_sum(r.high, z * r.high * polynomial(sines, z) + r.low * c);
  sine.high = select<T>(x == 0.0, x, sine.high); // with the sign of 0
  return {sine, ordered_sum(c, ((1.0 - c) - half) + (z * z * polynomial(cosines, z) - r.high * r.low)),
          bits_of(shifted)};
}

template <Vector T>
inline T sin(T x)
{
  const Quadrant<T> q = quadrant(x);
  T y = select<T>((q.number & 1) == 1, q.cosine.high, q.sine.high);
  y = from_bits<T>(bits_of(y) ^ ((q.number & 2) << 62));
  replace_lanes(y, abs(x) < largest_angle, [&](unsigned i) { return __builtin_sin(x[i]); });
  return y;
}
template <Vector T>
inline T cos(T x)
{
  const Quadrant<T> q = quadrant(x);
  T y = select<T>((q.number & 1) == 1, q.sine.high, q.cosine.high);
  y = from_bits<T>(bits_of(y) ^ (((q.number + 1) & 2) << 62));
  replace_lanes(y, abs(x) < largest_angle, [&](unsigned i) { return __builtin_cos(x[i]); });
  return y;
}
template <Vector T>
inline T tan(T x)
{
  const Quadrant<T> q = quadrant(x);
  const auto odd = (q.number & 1) == 1;
  const Sum<T> sine{select<T>(odd, q.cosine.high, q.sine.high), select<T>(odd, q.cosine.low, q.sine.low)};
  const Sum<T> cosine{select<T>(odd, -q.sine.high, q.cosine.high), select<T>(odd, -q.sine.low, q.cosine.low)};
  T y = quotient(sine, cosine);
  y = select<T>(x == 0.0, x, y); // with the sign of 0
  replace_lanes(y, abs(x) < largest_angle, [&](unsigned i) { return __builtin_tan(x[i]); });
  return y;
}

/// Angle of a point (x, y) with the nearer axis, between 0 and pi/4: artan(smaller/larger).
template <Vector T>
inline T angle_with_axis(T smaller, T larger)
{
  // 6.4e-18: artan(t) / t^3 - 1/t^2 of t^2
  static constexpr double series[] = {-0.3333333333333333,  0.19999999999995513,  -0.1428571428466482,
                                      0.11111111015117626,  -0.09090904572487347, 0.07692183059894106,
                                      -0.06664509603255293, 0.05858132894427219,  -0.05085365922341002,
                                      0.03922923713827552,  -0.019173922285454965};
  const auto turned = smaller > 0.4142135623730951 * larger; // beyond pi/8, the angle is taken from pi/4
  const T t = select<T>(turned, smaller - larger, smaller) / select<T>(turned, smaller + larger, larger);
  const T z = t * t, rest = t * z * polynomial(series, z);
  return select<T>(turned, 0.25 * pi, 0.0) + (t + (rest + select<T>(turned, 0.25 * pi_low, 0.0)));
}

template <Vector T>
inline T atan(T x)
{
  const T size = abs(x);
  const auto steep = size > 1.0;
  const T a = angle_with_axis(select<T>(steep, 1.0, size), select<T>(steep, size, 1.0));
  return times_sign(T(select<T>(steep, 0.5 * pi - (a - 0.5 * pi_low), a)), x);
}
template <Vector T>
inline T atan2(T y, T x)
{
  const T up = abs(y), along = abs(x);
  const auto steep = up > along, behind = x < 0.0;
  const T smaller = select<T>(steep, along, up), larger = select<T>(steep, up, along);
  const T a = angle_with_axis(smaller, larger);
  const T axis = select<T>(steep, 0.5 * pi, select<T>(behind, pi, 0.0));
  const T axis_low = select<T>(steep, 0.5 * pi_low, select<T>(behind, pi_low, 0.0));
  T angle = times_sign(T(axis + (select<T>(steep ^ behind, -a, a) + axis_low)), y);
  replace_lanes(angle, (larger > 0.0) & (larger < 1e300) & (smaller == smaller),
                [&](unsigned i) { return __builtin_atan2(y[i], x[i]); });
  return angle;
}

/// arcsin(|x|) where |x| <= 1/2, otherwise arcsin of the sine of half the angle to the axis.
template <Vector T>
inline Sum<T> half_arcsine(T size)
{
  // 5.8e-17: arcsin(x) / x^3 - 1/x^2 of x^2
  static constexpr double series[] = {0.1666666666666665,   0.07500000000020764,   0.044642857103423646,
                                      0.030381947367098483, 0.0223720476317445,    0.01735525995578648,
                                      0.013929652902324969, 0.01187549438264838,   0.007802949477301906,
                                      0.016035514349293623, -0.010749050339930202, 0.02816921806104353};
  const auto large = size > 0.5;
  const T z = select<T>(large, 0.5 * (1.0 - size), size * size);
  const T s = select<T>(large, sqrt(z), size);
  return {s, s * z * polynomial(series, z)};
}
template <Vector T>
inline T asin(T x)
{
  const T size = abs(x);
  const Sum<T> a = half_arcsine(size);
  const T large = (0.5 * pi - 2.0 * a.high) - (2.0 * a.low - 0.5 * pi_low);
  return times_sign(T(select<T>(size > 0.5, large, a.high + a.low)), x);
}
template <Vector T>
inline T acos(T x)
{
  const T size = abs(x);
  const Sum<T> a = half_arcsine(size);
  const T negative = (pi - 2.0 * a.high) - (2.0 * a.low - pi_low);
  const T large = select<T>(x < 0.0, negative, 2.0 * (a.high + a.low));
  return select<T>(size > 0.5, large, 0.5 * pi - (x + (times_sign(a.low, x) - 0.5 * pi_low)));
}

// 1.1e-17: sinh(x) / x^3 - 1/x^2 of x^2, where |x| < 1
inline constexpr double hyperbolic_sines[] = {0.16666666666666666,    0.008333333333333299,   0.00019841269841324198,
                                              2.7557319191381816e-06, 2.5052117695907823e-08, 1.6057679623801635e-10,
                                              7.746178593018927e-13};
template <Vector T>
inline T sinh(T x)
{
  const T size = abs(x), z = x * x;
  const T half = scaled(Exponential<T>(bounded_exponent(size)), 1.0); // exp(|x|)/2, below the largest number
  const T large = half - 0.25 / half;
  return times_sign(T(select<T>(size < 1.0, size + size * z * polynomial(hyperbolic_sines, z), large)), x);
}
template <Vector T>
inline T cosh(T x)
{
  const T half = scaled(Exponential<T>(bounded_exponent(T(abs(x)))), 1.0);
  return half + 0.25 / half;
}
template <Vector T>
inline T tanh(T x)
{
  // 2.1e-17: (cosh(x) - 1 - x^2/2) / x^4 of x^2, where |x| < 1
  static constexpr double cosines[] = {0.041666666666666644,  0.0013888888888905857,  2.480158728179637e-05,
                                       2.755732766402235e-07, 2.0875130774865365e-09, 1.1615012001988827e-11};
  const T size = abs(x), z = size * size;
  const auto small = size < 1.0;
  const Sum<T> sine = ordered_sum(size, size * z * polynomial(hyperbolic_sines, z));
  const Sum<T> cosine = ordered_sum(splat<T>(1.0), 0.5 * z + z * z * polynomial(cosines, z));
  const T square = scaled(Exponential<T>(bounded_exponent(T(2.0 * size))));
  const Sum<T> above{select<T>(small, sine.high, 2.0), select<T>(small, sine.low, 0.0)};
  const Sum<T> below{select<T>(small, cosine.high, square + 1.0), select<T>(small, cosine.low, 0.0)};
  const T q = quotient(above, below);
  return times_sign(T(select<T>(small, q, 1.0 - q)), x);
}

template <Vector T>
inline T erf(T x)
{
  // 1.9e-17: erf(x)/x - 1 of x^2, where |x| < 1
  static constexpr double small_series[] = {0.1283791670955126,      -0.3761263890318375,     0.11283791670954879,
                                            -0.026866170645076792,   0.0052239776248180145,   -0.000854832698083379,
                                            0.0001205533111164271,   -1.4925595266831182e-05, 1.6461000484121361e-06,
                                            -1.6350312701054618e-07, 1.4659775274046955e-08,  -1.1372848856789924e-09,
                                            5.957176147746114e-11};
  // 7.2e-17 of erf: exp(x^2) (1 - erf(x)) of (x - 3)/(x + 3), where 1 < x < 6
  static constexpr double large_series[] = {0.17900115118138907,   -0.32623356004299003,  0.24560380171289325,
                                            -0.1501159365078385,   0.07166583713850745,   -0.02439249905225781,
                                            0.004269138643318906,  0.0007077436205791401, -0.0005971019299440755,
                                            4.523670628663236e-05, 6.436074396760298e-05, -1.2383892608514314e-05,
                                            -8.668536150153648e-06};
  const T size = abs(x), z = size * size;
  const T inside = size + size * polynomial(small_series, z);
  const T bounded = select<T>(size > 6.0, 6.0, size);
  const T outside = 1.0 - scaled(Exponential<T>(T(-(bounded * bounded)))) *
                              polynomial(large_series, T((bounded - 3.0) / (bounded + 3.0)));
  return times_sign(T(select<T>(size < 1.0, inside, outside)), x);
}
} // namespace dolfinx_impact::kernels::math
