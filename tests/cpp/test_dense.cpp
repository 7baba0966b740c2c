// SPDX-License-Identifier: MIT
// Small dense matrices, against closed forms.
#include <algorithm>
#include <array>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/operators/SymmetricMatrices.h>
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

TEST_CASE("the ends of the spectra of several matrices at a time")
{
  // The rows of chains are put into another order, so that they are not tridiagonal; factors differ from matrix to
  // matrix, the second set of them is written into the memory of the first one.
  for (const int n : {1, 2, 3, 11, 24})
  {
    operators::SymmetricMatrices A(n);
    for (const double factor : {1.0, -3e9})
    {
      const auto scale = [factor](int which) { return which == 3 ? 0.0 : factor * std::pow(10.0, which); };
      for (int which = 0; which < operators::SymmetricMatrices::num; ++which)
        for (int i = 0; i < n; ++i)
          for (int j = 0; j <= i; ++j)
            A(which, i, j) = scale(which) * chain_entry(7 * i % n, 7 * j % n);
      const auto found = A.extreme_eigenvalues();
      for (int which = 0; which < operators::SymmetricMatrices::num; ++which)
      {
        const double a = scale(which) * chain_eigenvalue(n, 1), b = scale(which) * chain_eigenvalue(n, n);
        const double margin = 1e-14 * std::abs(b); // some tens of units of round-off of the largest
        CHECK(found[which][0] == Approx(std::min(a, b)).margin(margin));
        CHECK(found[which][1] == Approx(std::max(a, b)).margin(margin));
      }
    }
  }
}

TEST_CASE("symmetric parts of scaled matrices, and norms of both parts")
{
  // S = I + factor * (a skew-symmetric matrix with ones above the diagonal), scaled by 1, 2, 3, ...
  const int n = 3, num = operators::SymmetricMatrices::num;
  operators::AlignedVector S(std::size_t(n) * n * num), d(std::size_t(n) * num);
  for (int which = 0; which < num; ++which)
    for (int i = 0; i < n; ++i)
    {
      d[std::size_t(i) * num + which] = i + 1.0;
      for (int j = 0; j < n; ++j)
        S[std::size_t(n * i + j) * num + which] = i == j ? 1.0 : which * (i < j ? 1.0 : -1.0);
    }
  operators::SymmetricMatrices A(n);
  const auto norms = A.set_scaled(S.data(), d.data());
  for (int which = 0; which < num; ++which)
  {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j <= i; ++j)
        CHECK(A(which, i, j) == (i == j ? (i + 1.0) * (i + 1.0) : 0.0));
    CHECK(norms[which].symmetric == Approx(std::sqrt(1.0 + 16.0 + 81.0)).epsilon(1e-15));
    CHECK(norms[which].skew == Approx(which * std::sqrt(2.0 * (4.0 + 9.0 + 36.0))).epsilon(1e-15));
  }
  const auto ends = A.extreme_eigenvalues();
  CHECK(ends[1][0] == Approx(1.0).epsilon(1e-14));
  CHECK(ends[1][1] == Approx(9.0).epsilon(1e-14));
}

TEST_CASE("ends of a spectrum that many eigenvalues share")
{
  // I + 4 v v^T with a unit vector v: one but for one eigenvalue of five.
  const int n = 12;
  operators::SymmetricMatrices A(n);
  for (int which = 0; which < operators::SymmetricMatrices::num; ++which)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j <= i; ++j)
        A(which, i, j) = (i == j ? 1.0 : 0.0) + (which % 2 ? -4.0 : 4.0) / n;
  const auto found = A.extreme_eigenvalues();
  for (int which = 0; which < operators::SymmetricMatrices::num; ++which)
  {
    CHECK(found[which][0] == Approx(which % 2 ? -3.0 : 1.0).epsilon(1e-14));
    CHECK(found[which][1] == Approx(which % 2 ? 1.0 : 5.0).epsilon(1e-14));
  }
}
