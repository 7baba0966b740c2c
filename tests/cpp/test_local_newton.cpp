// SPDX-License-Identifier: MIT
// Newton's method for the local equations of a material: each lane on its own, line search, row exchange, failures.
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <dolfinx_impact/kernels/LocalNewton.h>
#include <limits>

using namespace dolfinx_impact::kernels;

namespace
{
typedef Lanes<4>::type T4;

/// x * x = p in every lane.
LocalSolution<T4, 1> roots(T4 p)
{
  const T4 start[1] = {splat<T4>(1.0)};
  return local_newton<T4, 1>(start, math::abs(p),
                             [p](const T4* x, T4* r, T4* J)
                             {
                               r[0] = x[0] * x[0] - p;
                               J[0] = 2.0 * x[0];
                             });
}
} // namespace

TEST_CASE("lanes converge after different numbers of steps, each to its own solution")
{
  const T4 p{1.0, 1e-6, 2.0, 1e8};
  const auto together = roots(p);
  for (int lane = 0; lane < 4; ++lane)
  {
    CHECK(together.failed[lane] == 0.0);
    // Round-off of x * x, since a correction is made beyond the tolerance.
    CHECK(std::abs(together.x[0][lane] / std::sqrt(p[lane]) - 1.0) < 1e-15);
    CHECK(roots(splat<T4>(p[lane])).x[0][0] == together.x[0][lane]); // the same bits in other company
  }
}

TEST_CASE("a lane that has converged stays where it is while others go on")
{
  // x^3 + x = p: round-off of the root depends on the way to it, so that a step more would show in the last bits.
  const auto solve = [](T4 p)
  {
    const T4 start[1] = {splat<T4>(0.1)};
    return local_newton<T4, 1>(start, math::abs(p),
                               [p](const T4* x, T4* r, T4* J)
                               {
                                 r[0] = x[0] * x[0] * x[0] + x[0] - p;
                                 J[0] = 3.0 * x[0] * x[0] + 1.0;
                               });
  };
  int different = 0;
  for (int k = 0; k < 2000; ++k)
  {
    const double p = 0.05 + 0.00137 * k;
    // The companions need many steps, or none.
    const T4 x = solve(T4{p, 1e9 + k, 0.101, 1e-3 * k + 40.0}).x[0];
    different += x[0] != solve(splat<T4>(p)).x[0][0];
  }
  CHECK(different == 0);
}

TEST_CASE("a lane without solution fails and leaves the others alone")
{
  const T4 p{4.0, -4.0, 9.0, std::numeric_limits<double>::quiet_NaN()};
  const auto s = roots(p);
  CHECK(s.failed[0] == 0.0);
  CHECK(s.failed[1] == 1.0);
  CHECK(s.failed[2] == 0.0);
  CHECK(s.failed[3] == 1.0);
  CHECK(s.x[0][0] == 2.0);
  CHECK(s.x[0][2] == 3.0);
  CHECK(s.residual[1] >= 1.0); // |x * x + 4| / 4
  LocalFailures<T4, 1> failures;
  failures.add(roots(splat<T4>(1.0)), 0);
  failures.add(s, 5);
  failures.add(s, 6);
  CHECK(failures.count[1] == 2.0);
  CHECK(failures.point[1] == 5.0); // the first one
  CHECK(failures.count[0] == 0.0);
}

TEST_CASE("the line search finds a root that full steps run away from")
{
  // Newton's method for atan diverges from |x| > 1.39; full steps from 3 grow without bound.
  const double start[1] = {3.0};
  const auto s = local_newton<double, 1>(start, 1.0,
                                         [](const double* x, double* r, double* J)
                                         {
                                           r[0] = std::atan(x[0]);
                                           J[0] = 1.0 / (1.0 + x[0] * x[0]);
                                         });
  CHECK(s.failed == 0.0);
  CHECK(std::abs(s.x[0]) < 1e-15);
}

TEST_CASE("rows are exchanged where the diagonal is zero")
{
  // 3 x1 = 6, x0 + x2 = 5, 2 x0 = 4
  const double start[3] = {0.0, 0.0, 0.0};
  const auto s = local_newton<double, 3>(start, 1.0,
                                         [](const double* x, double* r, double* J)
                                         {
                                           const double matrix[9] = {0, 3, 0, 1, 0, 1, 2, 0, 0}, right[3] = {6, 5, 4};
                                           for (int i = 0; i < 3; ++i)
                                           {
                                             r[i] = -right[i];
                                             for (int j = 0; j < 3; ++j)
                                             {
                                               J[3 * i + j] = matrix[3 * i + j];
                                               r[i] += matrix[3 * i + j] * x[j];
                                             }
                                           }
                                         });
  CHECK(s.failed == 0.0);
  CHECK(s.x[0] == 2.0);
  CHECK(s.x[1] == 2.0);
  CHECK(s.x[2] == 3.0);
}

TEST_CASE("a start that solves the equations is kept, also where the derivative is zero")
{
  const double start[1] = {0.25};
  const auto s = local_newton<double, 1>(start, 1.0, [](const double*, double* r, double* J) { r[0] = J[0] = 0.0; });
  CHECK(s.failed == 0.0);
  CHECK(s.x[0] == 0.25);
}

TEST_CASE("lanes whose start is known to be the solution keep it, the others are solved")
{
  int evaluations = 0;
  const auto solve = [&](T4 error)
  {
    const T4 start[1] = {splat<T4>(1.5)};
    return local_newton<T4, 1>(start, splat<T4>(2.0), error,
                               [&](const T4* x, T4* r, T4* J)
                               {
                                 ++evaluations;
                                 r[0] = x[0] * x[0] - 2.0;
                                 J[0] = 2.0 * x[0];
                               });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto mixed = solve(T4{0.0, 2e-16, 3e-16, nan}); // half a unit in the last place of the scale is 2.2e-16
  CHECK(evaluations > 0);
  for (int lane = 0; lane < 4; ++lane)
  {
    CHECK(mixed.failed[lane] == 0.0);
    CHECK(std::abs(mixed.x[0][lane] - (lane < 2 ? 1.5 : std::sqrt(2.0))) < 1e-15);
  }
  evaluations = 0;
  CHECK(solve(splat<T4>(1e-17)).x[0][3] == 1.5);
  CHECK(evaluations == 0);
}
