// SPDX-License-Identifier: MIT
#pragma once
#include "functions.h"

/// Local equations r(x) = 0 at a quadrature point, solved for all cells of a batch at once. There is no branch per
/// lane: a lane that has converged keeps its values while the others go on, so that its result does not depend on them.
namespace dolfinx_impact::kernels
{
/// Convergence: the largest |r_i| is at most this times the residual's scale. Round-off leaves some 1e-16 of the terms
/// that r is summed of; the last correction, which is applied still, squares the distance.
inline constexpr double local_tolerance = 1e-12;
/// Evaluations of the equations before a point counts as not solved. Newton's method doubles the digits in each; what
/// is left is for steps that the line search halves.
inline constexpr int local_evaluations = 50;
/// Required decrease of the norm, relative to that of the linearised equations (Armijo's condition; Nocedal & Wright
/// 2006, 11.2).
inline constexpr double local_decrease = 1e-4;

template <typename T, int N>
struct LocalSolution
{
  T x[N];
  T residual; ///< largest |r_i|, relative to the scale
  T failed;   ///< 1 in lanes that have not converged, 0 in the others
};

/// d = -J^-1 r by elimination with row exchange, each lane its own. J and r are overwritten.
template <typename T, int N>
inline void newton_direction(T (&J)[N * N], T (&r)[N], T (&d)[N])
{
  if constexpr (N == 1)
  {
    d[0] = -r[0] / J[0];
    return;
  }
#pragma GCC unroll 8
  for (int k = 0; k < N - 1; ++k)
  {
    // The largest entry of the column goes to the diagonal, one exchange after the other.
    for (int i = k + 1; i < N; ++i)
    {
      const auto larger = math::abs(J[N * i + k]) > math::abs(J[N * k + k]);
      for (int j = k; j < N; ++j)
      {
        const T upper = J[N * k + j], lower = J[N * i + j];
        J[N * k + j] = select<T>(larger, lower, upper);
        J[N * i + j] = select<T>(larger, upper, lower);
      }
      const T upper = r[k], lower = r[i];
      r[k] = select<T>(larger, lower, upper);
      r[i] = select<T>(larger, upper, lower);
    }
    const T inverse = 1.0 / J[N * k + k];
    for (int i = k + 1; i < N; ++i)
    {
      const T factor = J[N * i + k] * inverse;
      for (int j = k + 1; j < N; ++j)
        J[N * i + j] -= factor * J[N * k + j];
      r[i] -= factor * r[k];
    }
  }
  for (int k = N - 1; k >= 0; --k)
  {
    T sum = r[k];
    for (int j = k + 1; j < N; ++j)
      sum += J[N * k + j] * d[j];
    d[k] = -sum / J[N * k + k];
  }
}

/// Newton's method with a line search that halves the step until the norm of r decreases.
/// @param[in] start first iterate
/// @param[in] scale size of the residual's terms
/// @param[in] equations function (const T* x, T* r, T* J): residual and its derivative, rows first
template <typename T, int N, typename Equations>
inline LocalSolution<T, N> local_newton(const T (&start)[N], T scale, const Equations& equations)
{
  LocalSolution<T, N> s;
  T trial[N], direction[N], step = splat<T>(1.0), norm;
  T r[N], J[N * N];
  const T reciprocal = 1.0 / scale;
  // Sum of squares and largest one of the relative residuals.
  const auto measure = [&](T& sum, T& largest)
  {
    sum = largest = splat<T>(0.0);
    for (int i = 0; i < N; ++i)
    {
      const T relative = math::abs(r[i] * reciprocal);
      sum += relative * relative;
      largest = select<T>(relative > largest, relative, largest);
    }
    largest = select<T>(sum <= 1e300, largest, sum); // what is no number, or too large, does not converge
  };
  // Lanes that have converged do not go on. They still get the correction at the solution: it is known already, and as
  // large as the round-off of r allows. It is left out where the derivative has no inverse.
  const auto finish = [&]
  {
    const T converged = select<T>(s.residual <= local_tolerance, s.failed, 0.0);
    for (int i = 0; i < N; ++i)
    {
      const T last = select<T>(math::abs(direction[i]) <= 1e300, direction[i], 0.0);
      s.x[i] = select<T>(converged > 0.0, s.x[i] + last, s.x[i]);
    }
    s.failed = s.failed - converged;
  };

  for (int i = 0; i < N; ++i)
    s.x[i] = start[i];
  s.failed = splat<T>(1.0); // lanes that go on
  equations(s.x, r, J);
  measure(norm, s.residual);
  newton_direction<T, N>(J, r, direction);
  finish();
  for (int evaluation = 1; evaluation < local_evaluations and any_lane(s.failed > 0.0); ++evaluation)
  {
    T d[N], trial_norm, largest;
    for (int i = 0; i < N; ++i)
      trial[i] = select<T>(s.failed > 0.0, s.x[i] + step * direction[i], s.x[i]);
    equations(trial, r, J);
    measure(trial_norm, largest);
    // A lane accepts its trial value where the norm has decreased.
    const T bound = (1.0 - 2.0 * local_decrease * step) * norm;
    T accept = select<T>(trial_norm <= bound, s.failed, 0.0);
    accept = select<T>(largest <= local_tolerance, s.failed, accept);
    newton_direction<T, N>(J, r, d);
    for (int i = 0; i < N; ++i)
    {
      s.x[i] = select<T>(accept > 0.0, trial[i], s.x[i]);
      direction[i] = select<T>(accept > 0.0, d[i], direction[i]);
    }
    norm = select<T>(accept > 0.0, trial_norm, norm);
    s.residual = select<T>(accept > 0.0, largest, s.residual);
    step = select<T>(accept > 0.0, 1.0, 0.5 * step);
    finish();
  }
  return s;
}

/// The same where the distance of the first iterate from the solution is known, of one equation whose derivative is
/// about one in size: lanes in which it is below the round-off of the residual keep the first iterate.
/// @param[in] error bound of that distance
template <typename T, int N, typename Equations>
inline LocalSolution<T, N> local_newton(const T (&start)[N], T scale, T error, const Equations& equations)
{
  static_assert(N == 1);
  constexpr double round_off = 0x1p-53;
  const auto known = error <= round_off * scale; // not where the bound is no number
  if (not any_lane(known == 0))
    return {{start[0]}, splat<T>(0.0), splat<T>(0.0)};
  LocalSolution<T, N> s = local_newton<T, N>(start, scale, equations);
  s.x[0] = select<T>(known, start[0], s.x[0]);
  s.residual = select<T>(known, splat<T>(0.0), s.residual);
  s.failed = select<T>(known, splat<T>(0.0), s.failed);
  return s;
}

/// The points of a cell that were not solved: how many, and what is known of the first.
template <typename T, int N>
struct LocalFailures
{
  T count = splat<T>(0.0), point = splat<T>(0.0), residual = splat<T>(0.0), x[N] = {};

  void add(const LocalSolution<T, N>& s, int number)
  {
    if (not any_lane(s.failed > 0.0)) [[likely]]
      return;
    const T isfirst = select<T>(count > 0.0, 0.0, s.failed);
    point = select<T>(isfirst > 0.0, double(number), point);
    residual = select<T>(isfirst > 0.0, s.residual, residual);
    for (int i = 0; i < N; ++i)
      x[i] = select<T>(isfirst > 0.0, s.x[i], x[i]);
    count += s.failed;
  }

  void store(T* out) const
  {
    out[0] = count;
    out[1] = point;
    out[2] = residual;
    for (int i = 0; i < N; ++i)
      out[3 + i] = x[i];
  }
};
} // namespace dolfinx_impact::kernels
