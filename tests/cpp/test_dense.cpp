// SPDX-License-Identifier: MIT
// Small dense matrices by LAPACK, against closed forms.
#include <array>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/operators/SymmetricMatrix.h>
#include <dolfinx_impact/solve/dense.h>
#include <numbers>

using Catch::Approx;
using namespace dolfinx_impact;

namespace
{
/// Of a chain of n equal springs between walls: 2 - 2 cos(k pi / (n + 1)), k = 1 ... n.
double chain_eigenvalue(int n, int k)
{
  return 2.0 - 2.0 * std::cos(k * std::numbers::pi / (n + 1));
}

double chain_entry(int i, int j)
{
  return i == j ? 2.0 : std::abs(i - j) == 1 ? -1.0 : 0.0;
}
} // namespace

TEST_CASE("eigenvalues and eigenvectors of a chain of springs")
{
  for (const int n : {1, 2, 5, 12})
  {
    std::vector<double> A;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        A.push_back(chain_entry(i, j));
    const solve::SymmetricEigen found = solve::symmetric_eigen(A, n);
    REQUIRE(found.values.size() == std::size_t(n));
    for (int k = 0; k < n; ++k)
    {
      CHECK(found.values[k] == Approx(chain_eigenvalue(n, k + 1)).epsilon(1e-12));
      for (int i = 0; i < n; ++i) // A v = lambda v
      {
        double product = 0.0;
        for (int j = 0; j < n; ++j)
          product += chain_entry(i, j) * found.vectors[std::size_t(k) * n + j];
        CHECK(product == Approx(found.values[k] * found.vectors[std::size_t(k) * n + i]).margin(1e-12));
      }
      for (int l = 0; l < n; ++l) // orthonormal
      {
        double product = 0.0;
        for (int i = 0; i < n; ++i)
          product += found.vectors[std::size_t(k) * n + i] * found.vectors[std::size_t(l) * n + i];
        CHECK(product == Approx(k == l ? 1.0 : 0.0).margin(1e-12));
      }
    }
    CHECK(solve::spectral_radius(A, n) == Approx(chain_eigenvalue(n, n)).epsilon(1e-12));
  }
}

TEST_CASE("the spectral radius of a matrix without real eigenvalues is the absolute value of complex ones")
{
  const double turn = 0.7, shrink = 0.9;
  const std::vector<double> A{shrink * std::cos(turn), -shrink * std::sin(turn), shrink * std::sin(turn),
                              shrink * std::cos(turn)};
  CHECK(solve::spectral_radius(A, 2) == Approx(shrink).epsilon(1e-14));
}

TEST_CASE("a dense system is given column after column, and a singular one has no solution")
{
  // 1 2 | 5   ->  1
  // 3 4 | 11  ->  2
  const auto found = solve::solve_dense({1.0, 3.0, 2.0, 4.0}, {5.0, 11.0});
  REQUIRE(found);
  CHECK((*found)[0] == Approx(1.0).epsilon(1e-14));
  CHECK((*found)[1] == Approx(2.0).epsilon(1e-14));
  CHECK_FALSE(solve::solve_dense({1.0, 2.0, 2.0, 4.0}, {1.0, 1.0}));
}

TEST_CASE("traces and extreme eigenvalues, one matrix after the other in the same memory")
{
  const int n = 6;
  operators::SymmetricMatrix A(n);
  for (const double factor : {1.0, 3.0})
  {
    const auto write = [&]
    {
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          A(i, j) = factor * chain_entry(i, j);
    };
    std::array<double, 3> sums{};
    for (int k = 1; k <= n; ++k)
      for (int power = 0; power < 3; ++power)
        sums[power] += std::pow(factor * chain_eigenvalue(n, k), power + 1);
    write();
    const operators::Traces traces = A.traces();
    CHECK(traces.first == Approx(sums[0]).epsilon(1e-13));
    CHECK(traces.second == Approx(sums[1]).epsilon(1e-13));
    CHECK(traces.third == Approx(sums[2]).epsilon(1e-13));
    CHECK(traces == operators::Traces{sums[0], sums[1], sums[2]});
    CHECK_FALSE(traces == operators::Traces{sums[0], sums[1], sums[2] * (1.0 + 1e-9)});
    write();
    const std::array<double, 2> extremes = A.extreme_eigenvalues();
    CHECK(extremes[0] == Approx(factor * chain_eigenvalue(n, 1)).epsilon(1e-12));
    CHECK(extremes[1] == Approx(factor * chain_eigenvalue(n, n)).epsilon(1e-12));
  }
}
