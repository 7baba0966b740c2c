// SPDX-License-Identifier: MIT
// Functions of the SIMD type against the scalar ones that the same kernels call.
#include <bit>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstdint>
#include <dolfinx_impact/kernels/simd.h>
#include <limits>
#include <vector>

using namespace dolfinx_impact::kernels;

namespace
{
bool same(double a, double b)
{
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (std::isnan(a) && std::isnan(b));
}

template <int N>
void compare_extrema()
{
  typedef typename Lanes<N>::type T;
  constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> values{-infinity, -1.5, -0.0, 2.0, 7.0, infinity, nan};
  for (double a : values)
    for (double b : values)
      for (int lane = 0; lane < N; ++lane)
      {
        if (a == 0.0 && b == 0.0)
          continue;
        T x = splat<T>(3.0), y = splat<T>(4.0); // the other lanes
        x[lane] = a;
        y[lane] = b;
        const T low = math::min(x, y), high = math::max(x, y);
        for (int l = 0; l < N; ++l)
        {
          CHECK(same(low[l], math::min(double(x[l]), double(y[l]))));
          CHECK(same(high[l], math::max(double(x[l]), double(y[l]))));
        }
      }
}

template <int k, int N>
void compare_third_powers()
{
  typedef typename Lanes<N>::type T;
  constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  // A lane that the C library computes: the others do not change.
  for (double x : {0.0, 1e-310, 1e-300, 1e300, infinity, -2.0, nan})
    for (int lane = 0; lane < N; ++lane)
    {
      T values = splat<T>(1.7);
      values[lane] = x;
      const T found = math::third_power<k>(values);
      for (int l = 0; l < N; ++l)
        CHECK(same(found[l], l == lane ? std::pow(x, k / 3.0) : math::third_power<k>(splat<T>(1.7))[0]));
    }
  // Over all exponents and mantissas: three units in the last place of 2.2e-16, of the root and of two products.
  for (double x = 1e-289; x < 1e289; x *= 1.37)
  {
    const T found = math::third_power<k>(splat<T>(x));
    const long double root = cbrtl(x), exact = k == 1    ? root
                                               : k == 2  ? root * root
                                               : k == -1 ? 1 / root
                                                         : 1 / (root * root);
    for (int l = 0; l < N; ++l)
      CHECK(std::abs(double((found[l] - exact) / exact)) < 3 * 2.2e-16);
    CHECK(std::abs(double((math::third_power<k>(x) - exact) / exact)) < 3 * 2.2e-16);
  }
}

/// A value in one lane, harmless ones in the others, which are looked at, too.
template <int N>
typename Lanes<N>::type with_neighbours(double value, int lane)
{
  auto values = splat<typename Lanes<N>::type>(0.6);
  if constexpr (N == 1)
    return value;
  else
    values[lane] = value;
  return values;
}

template <int N>
double entry(typename Lanes<N>::type values, int lane)
{
  if constexpr (N == 1)
    return values;
  else
    return values[lane];
}

std::vector<double> extreme_numbers()
{
  using limits = std::numeric_limits<double>;
  std::vector<double> numbers{0.0,
                              limits::denorm_min(),
                              4e-320,
                              limits::min(),
                              1e-290,
                              limits::epsilon(),
                              1e-3,
                              1.0,
                              7.0,
                              699.9999,
                              700.0,
                              709.78,
                              709.79,
                              745.1,
                              745.2,
                              1e5,
                              6755399441055744.0,
                              9.3e18,
                              1e290,
                              limits::max(),
                              limits::infinity()};
  for (std::size_t i = 0, n = numbers.size(); i < n; ++i)
    numbers.push_back(-numbers[i]);
  numbers.push_back(limits::quiet_NaN());
  numbers.push_back(-limits::quiet_NaN());
  return numbers;
}

/// Numbers whose functions are infinite, not a number, zero, denormal or none of these. Where the result is regular, it
/// is that of the C library to some units in the last place; of a denormal number, the last bit counts as much as that
/// of the least regular number.
template <int N, typename F, typename G>
void compare_on_extreme_numbers(F function, G exact, double units)
{
  for (double x : extreme_numbers())
    for (int lane = 0; lane < N; ++lane)
    {
      const auto found = function(with_neighbours<N>(x, lane));
      for (int l = 0; l < N; ++l)
      {
        const double a = entry<N>(found, l), b = exact(l == lane ? x : 0.6);
        INFO("width " << N << ", lane " << lane << ", f(" << x << ") = " << a << ", C library " << b);
        if (std::isfinite(b) && b != 0.0)
          CHECK(std::abs(a - b) <= units * std::numeric_limits<double>::epsilon() * std::abs(b) + units * 5e-324);
        else
          CHECK(same(a, b));
      }
    }
}

template <int N>
void compare_functions()
{
  typedef typename Lanes<N>::type T;
  compare_on_extreme_numbers<N>([](T x) { return math::exp(x); }, [](double x) { return std::exp(x); }, 2);
  compare_on_extreme_numbers<N>([](T x) { return math::log(x); }, [](double x) { return std::log(x); }, 4);
  compare_on_extreme_numbers<N>([](T x) { return math::sqrt(x); }, [](double x) { return std::sqrt(x); }, 0);
  compare_on_extreme_numbers<N>([](T x) { return math::abs(x); }, [](double x) { return std::abs(x); }, 0);
  compare_on_extreme_numbers<N>([](T x) { return math::tanh(x); }, [](double x) { return std::tanh(x); }, 0);
  compare_on_extreme_numbers<N>([](T x) { return math::pow(x, 1.7); }, [](double x) { return std::pow(x, 1.7); }, 0);
  compare_on_extreme_numbers<N>([](T x) { return math::pow(splat<T>(0.3), x); },
                                [](double x) { return std::pow(0.3, x); }, 0);
  // Of numbers that the C library does not get, the root itself: 1/3 as a double is not a third.
  const auto third = [](double x, int k)
  { return x > 1e-290 && x < 1e290 ? double(k == 1 ? cbrtl(x) : 1 / (cbrtl(x) * cbrtl(x))) : std::pow(x, k / 3.0); };
  compare_on_extreme_numbers<N>([](T x) { return math::third_power<1>(x); }, [&](double x) { return third(x, 1); }, 3);
  compare_on_extreme_numbers<N>([](T x) { return math::third_power<-2>(x); }, [&](double x) { return third(x, -2); },
                                3);
  for (double x : extreme_numbers())
    compare_on_extreme_numbers<N>([x](T) { return splat<T>(x); }, [x](double) { return x; }, 0);
  compare_on_extreme_numbers<N>([](T x) { return from_bits<T>(bits_of(x)); }, [](double x) { return x; }, 0);
}

template <int N>
void compare_exponentials()
{
  typedef typename Lanes<N>::type T;
  constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  for (double x : {-infinity, -800.0, -720.0, 705.0, 720.0, infinity, nan}) // what the C library computes
    for (int lane = 0; lane < N; ++lane)
    {
      T values = splat<T>(-1.3);
      values[lane] = x;
      const T found = math::exp(values);
      for (int l = 0; l < N; ++l)
        CHECK(same(found[l], l == lane ? std::exp(x) : math::exp(splat<T>(-1.3))[0]));
    }
  CHECK(math::exp(splat<T>(0.0))[0] == 1.0);
  for (double x = -699.0; x < 699.0; x += 0.137) // two units in the last place
    CHECK(std::abs(double((math::exp(splat<T>(x))[N - 1] - expl(x)) / expl(x))) < 2 * 2.2e-16);
}
} // namespace

TEST_CASE("functions of extreme numbers are those of the C library in all widths, also beside other lanes")
{
  compare_functions<1>();
  compare_functions<2>();
  compare_functions<4>();
  compare_functions<8>();
}

TEST_CASE("the exponential of vectors is that of the C library, without its calls")
{
  compare_exponentials<2>();
  compare_exponentials<4>();
  compare_exponentials<8>();
}

TEST_CASE("powers of a third are those of the C library, without its calls")
{
  compare_third_powers<1, 4>();
  compare_third_powers<2, 4>();
  compare_third_powers<-1, 8>();
  compare_third_powers<-2, 4>();
}

TEST_CASE("minimum and maximum of vectors are those of scalars, also where an argument is not a number")
{
  CHECK(math::min(std::numeric_limits<double>::quiet_NaN(), 1.0) == 1.0);
  compare_extrema<4>();
  compare_extrema<8>();
}
