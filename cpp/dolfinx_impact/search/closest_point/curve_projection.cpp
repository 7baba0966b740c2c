// SPDX-License-Identifier: MIT
#include "curve_projection.h"
#include <algorithm>
#include <cmath>
#include <limits>

namespace dolfinx_impact::search
{
namespace
{
/// Value and derivative of c0 + c1 t + c2 t^2 + c3 t^3.
double cubic(const double* c, double t)
{
  return c[0] + t * (c[1] + t * (c[2] + t * c[3]));
}
double slope(const double* c, double t)
{
  return c[1] + t * (2 * c[2] + t * 3 * c[3]);
}

/// Root of a cubic that rises through zero once in [low, high]: Newton's method, halving when it leaves.
double root(const double* c, double low, double high)
{
  double t = 0.5 * (low + high);
  for (int i = 0; i < 100; ++i)
  {
    const double value = cubic(c, t);
    (value < 0.0 ? low : high) = t;
    const double step = value / slope(c, t);
    if (std::abs(step) < 1e-15 || high - low < 1e-15)
      break;
    t = t - step > low && t - step < high ? t - step : 0.5 * (low + high);
  }
  return t;
}
} // namespace

bool project_on_curve(int gdim, const double* a, const double* b, const double* middle, const double* point,
                      double margin, double& t)
{
  // x(t) - point = r + B t + C t^2; the derivative of half its square is a cubic.
  double c[4] = {0.0, 0.0, 0.0, 0.0}, r[3], B[3], C[3];
  for (int k = 0; k < gdim; ++k)
  {
    C[k] = middle ? 2 * (a[k] + b[k] - 2 * middle[k]) : 0.0;
    B[k] = b[k] - a[k] - C[k];
    r[k] = a[k] - point[k];
    c[0] += r[k] * B[k];
    c[1] += B[k] * B[k] + 2 * r[k] * C[k];
    c[2] += 3 * B[k] * C[k];
    c[3] += 2 * C[k] * C[k];
  }
  // Between the extrema of the cubic it is monotonic.
  const double low = -margin, high = 1.0 + margin;
  double breaks[4] = {low};
  int num = 1;
  const double discriminant = c[2] * c[2] - 3 * c[3] * c[1];
  if (discriminant > 0.0)
  {
    const double q = -(c[2] + std::copysign(std::sqrt(discriminant), c[2]));
    double t1 = q / (3 * c[3]), t2 = c[1] / q;
    if (t2 < t1)
      std::swap(t1, t2);
    for (double extremum : {t1, t2})
      if (extremum > breaks[num - 1] && extremum < high)
        breaks[num++] = extremum;
  }
  breaks[num++] = high;
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i + 1 < num; ++i)
  {
    if (!(cubic(c, breaks[i]) <= 0.0 && cubic(c, breaks[i + 1]) >= 0.0))
      continue;
    const double s = root(c, breaks[i], breaks[i + 1]);
    double squared = 0.0;
    for (int k = 0; k < gdim; ++k)
    {
      const double d = r[k] + s * (B[k] + s * C[k]);
      squared += d * d;
    }
    if (squared < best)
    {
      best = squared;
      t = s;
    }
  }
  return std::isfinite(best);
}
} // namespace dolfinx_impact::search
