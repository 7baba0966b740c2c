// SPDX-License-Identifier: MIT
// Vectors of all widths against numbers: bits, signs, minimum and maximum.
#include <bit>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <cstdint>
#include <dolfinx_impact/kernels/functions.h>
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

template <int N>
void compare_bits()
{
  typedef typename Lanes<N>::type T;
  constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  for (double a : {0.0, -0.0, 1.5, -7.0, 5e-324, -5e-324, infinity, -infinity, nan})
  {
    const T splatted = splat<T>(a), back = from_bits<T>(bits_of(splatted)), size = math::abs(splatted);
    for (int l = 0; l < N; ++l)
    {
      CHECK(same(splatted[l], a));
      CHECK(same(back[l], a));
      CHECK(same(size[l], std::abs(a)));
    }
  }
}

template <int N>
void compare_ranges()
{
  typedef typename Lanes<N>::type T;
  constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double low = -1.5, high = 2.0;
  for (double a : {-infinity, -2.0, low, std::nextafter(low, 0.0), 0.0, std::nextafter(high, 0.0), high, infinity, nan})
    for (int lane = 0; lane < N; ++lane)
    {
      T x = splat<T>(1.0); // the other lanes
      x[lane] = a;
      CHECK(all_between(x, low, high) == (low < a && a < high));
      CHECK(all_between(double(x[lane]), low, high) == (low < a && a < high));
    }
}
} // namespace

TEST_CASE("one number out of a range, or none, is seen in any lane")
{
  compare_ranges<2>();
  compare_ranges<4>();
  compare_ranges<8>();
}

TEST_CASE("minimum and maximum of vectors are those of scalars, also where an argument is not a number")
{
  CHECK(math::min(std::numeric_limits<double>::quiet_NaN(), 1.0) == 1.0);
  compare_extrema<2>();
  compare_extrema<4>();
  compare_extrema<8>();
}

TEST_CASE("vectors hold the bits of any number, and know its size")
{
  compare_bits<2>();
  compare_bits<4>();
  compare_bits<8>();
}
