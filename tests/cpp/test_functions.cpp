// SPDX-License-Identifier: MIT
// Mathematical functions of vectors against the C library's in extended precision: over the whole range, at special
// values, in every lane beside others. This source is compiled for each instruction set of the kernels.
#include <bit>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstdint>
#include <dolfinx_impact/kernels/functions.h>
#include <limits>
#include <random>
#include <sstream>
#include <vector>

using namespace dolfinx_impact::kernels;

namespace
{
using limits = std::numeric_limits<double>;
#if defined(__AVX512F__)
constexpr int lanes = 8;
#elif defined(__AVX2__)
constexpr int lanes = 4;
#else
constexpr int lanes = 2;
#endif
typedef Lanes<lanes>::type T;

/// Distance of a value from the exact one in units in the last place of the latter, which are equal below the least
/// normal number.
double units(double value, long double exact)
{
  const double nearest = double(exact);
  if (std::isnan(nearest) || std::isnan(value))
    return std::isnan(nearest) && std::isnan(value) ? 0.0 : limits::infinity();
  if (std::isinf(nearest) || std::isinf(value)) // rounding may go beyond the largest number
    return value == nearest                                                         ? 0.0
           : std::abs(value) == limits::max() || std::abs(nearest) == limits::max() ? 1.0
                                                                                    : limits::infinity();
  const double size = std::max(std::abs(nearest), limits::min());
  return double(std::abs(value - exact) / std::scalbn(1.0L, std::ilogb(size) - 52));
}

std::vector<double> special_numbers()
{
  std::vector<double> numbers{0.0,
                              limits::denorm_min(),
                              4e-320,
                              1e-310,
                              limits::min(),
                              1e-300,
                              1e-290,
                              1e-155,
                              limits::epsilon(),
                              1e-3,
                              0.25,
                              1.0 / 3.0,
                              0.5,
                              0.6,
                              0.75,
                              1.0,
                              1.5,
                              2.0,
                              3.0,
                              7.0,
                              28.0,
                              699.9,
                              709.78,
                              709.79,
                              710.0,
                              710.47,
                              710.48,
                              745.1,
                              745.2,
                              1e5,
                              1e16,
                              9007199254740993.0,
                              1e154,
                              1e290,
                              1e300,
                              limits::max(),
                              limits::infinity()};
  for (std::size_t i = 0, n = numbers.size(); i < n; ++i)
    numbers.push_back(-numbers[i]);
  numbers.push_back(limits::quiet_NaN());
  return numbers;
}

/// Numbers of all exponents and both signs, numbers near 1 and of moderate size, and special numbers.
std::vector<double> numbers(int count)
{
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> moderate(-800.0, 800.0), near(-3.0, 3.0), exponent(-1.0, 1.0);
  std::vector<double> all = special_numbers();
  for (int i = 0; i < count; ++i)
  {
    const double bits = std::bit_cast<double>(std::uint64_t(random()));
    all.insert(all.end(),
               {bits, moderate(random), near(random), 1.0 + 0.5 * std::pow(10.0, -12 * (exponent(random) + 1))});
  }
  for (double x = 0.0; x < 40.0; x += 0.25 * 3.14159265358979323846) // multiples of pi/4 as near as numbers are
    all.insert(all.end(), {x, std::nextafter(x, 1e9), -std::nextafter(x, -1e9)});
  return all;
}

/// The function in one lane beside a harmless number in the others, whose value is to stay the same.
template <typename F>
double in_lane(F function, double x, int lane)
{
  static const volatile double harmless = 0.6; // not known to the compiler, which would compute the function itself
  T values = splat<T>(harmless);
  const double neighbour = function(values)[0];
  values[lane] = x;
  const T found = function(values);
  for (int l = 0; l < lanes; ++l)
    if (l != lane && std::bit_cast<std::uint64_t>(double(found[l])) != std::bit_cast<std::uint64_t>(neighbour))
      FAIL("a lane depends on its neighbour " << x);
  return found[lane];
}

template <typename F, typename G>
void compare(const char* name, F function, G exact, double largest = 2.0, int count = 20000)
{
  double worst = 0.0, at = 0.0;
  int lane = 0;
  for (double x : numbers(count))
  {
    const double found = in_lane(function, x, lane++ % lanes);
    const double distance = units(found, exact(static_cast<long double>(x)));
    if (!(distance <= worst))
      worst = distance, at = x;
    if (found == 0.0 && double(exact(x)) == 0.0 && std::signbit(found) != std::signbit(double(exact(x))))
      worst = limits::infinity(), at = x;
  }
  std::ostringstream text;
  text.precision(17);
  text << name << ", " << lanes << " lanes: " << worst << " units in the last place at " << at;
  INFO(text.str());
  CHECK(worst <= largest);
}

#define IMPACT_COMPARE(name, exact)                                                                                    \
  compare(#name, [](T x) { return math::name(x); }, [](long double x) { return exact(x); })
} // namespace

TEST_CASE("functions of vectors are exact to two units in the last place, and in special values")
{
  IMPACT_COMPARE(exp, expl);
  IMPACT_COMPARE(log, logl);
  IMPACT_COMPARE(sin, sinl);
  IMPACT_COMPARE(cos, cosl);
  IMPACT_COMPARE(tan, tanl);
  IMPACT_COMPARE(asin, asinl);
  IMPACT_COMPARE(acos, acosl);
  IMPACT_COMPARE(atan, atanl);
  IMPACT_COMPARE(sinh, sinhl);
  IMPACT_COMPARE(cosh, coshl);
  IMPACT_COMPARE(tanh, tanhl);
  IMPACT_COMPARE(erf, erfl);
  IMPACT_COMPARE(sqrt, sqrtl);
}

TEST_CASE("logarithms of numbers near one, with all lanes there and with one")
{
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> moderate(-1.2 * math::near_one, 1.2 * math::near_one), exponent(-16.0, 0.0);
  double worst = 0.0, worst_at = 0.0;
  for (int i = 0; i < 20000; ++i)
  {
    const double f = i % 2 == 0 ? moderate(random) : math::near_one * std::pow(10.0, exponent(random));
    const double x = i == 0 ? 1.0 : 1.0 + (i % 4 < 2 ? f : -f);
    const double found = math::log(splat<T>(x))[0], beside = in_lane([](T y) { return math::log(y); }, x, i % lanes);
    if (const double distance = units(found, logl(static_cast<long double>(x))); !(distance <= worst))
      worst = distance, worst_at = x;
    if (std::bit_cast<std::uint64_t>(found) != std::bit_cast<std::uint64_t>(beside))
      FAIL("a lane depends on its neighbour " << x);
  }
  INFO(worst << " units in the last place at 1 + " << worst_at - 1.0);
  CHECK(worst <= 2.0);
}

TEST_CASE("powers of vectors are exact to two units in the last place, and in special values")
{
  for (double p : {-2.3, -5.0 / 7.0, -0.1, 0.37, 0.9, 1.7, 3.0, -3.0, 11.0, 40.5})
    compare("pow", [p](T x) { return math::pow(x, p); }, [p](long double x) { return powl(x, p); }, 2.0, 2000);
  for (double x : special_numbers())
    for (double p : special_numbers())
    {
      INFO("pow(" << x << ", " << p << ")");
      const double found = in_lane([p](T y) { return math::pow(y, splat<T>(p)); }, x, 1);
      CHECK(units(found, std::pow(static_cast<long double>(x), static_cast<long double>(p))) <= 2.0);
    }
  // Large exponents of numbers near 1: the logarithm needs more digits than a number has.
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> base(0.5, 1.8), result(-740.0, 709.0);
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i)
  {
    const double x = base(random), p = result(random) / std::log(x);
    worst = std::max(worst, units(math::pow(splat<T>(x), p)[0], powl(x, p)));
  }
  CHECK(worst <= 2.0);
}

template <int k>
void compare_third_power()
{
  // Of numbers that pow gets, the exponent would not be a third.
  const auto exact = [](long double x)
  {
    if (!(x > 0.0L) || std::isinf(x))
      return static_cast<long double>(std::pow(double(x), k / 3.0));
    const long double root = cbrtl(x);
    return k == 1 ? root : k == 2 ? root * root : k == -1 ? 1.0L / root : 1.0L / (root * root);
  };
  compare("third power", [](T x) { return math::third_power<k>(x); }, exact);
  compare(
      "third power of a number",
      [](T x)
      {
        for (int l = 0; l < lanes; ++l)
          x[l] = math::third_power<k>(double(x[l]));
        return x;
      },
      exact);
}

TEST_CASE("powers of a third are exact to two units in the last place, and in special values")
{
  compare_third_power<1>();
  compare_third_power<2>();
  compare_third_power<-1>();
  compare_third_power<-2>();
}
