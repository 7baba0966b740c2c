// SPDX-License-Identifier: MIT
#include "friction.h"
#include "../common/vectors.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::enforcement
{
namespace
{
/// (I - n n) v
void project(const double* n, const double* v, int gdim, double* out)
{
  const double along = dot(n, v, gdim);
  for (int c = 0; c < gdim; ++c)
    out[c] = v[c] - along * n[c];
}
} // namespace

FrictionResult evaluate(const Friction& p)
{
  FrictionResult out;
  std::copy_n(p.last, p.gdim, out.traction);
  std::copy_n(p.increment, p.gdim, out.slip);
  const auto law = p.gdim == 2 ? coulomb<2> : coulomb<3>;
  out.slips =
      law(p.normal, p.stiffness, 1.0 / p.stiffness, p.coefficient * p.pressure, out.traction, out.slip, out.trial);
  return out;
}

void linearise(const Friction& p, const FrictionResult& result, int num, const double* d_pressure,
               const double* d_normal, const double* d_increment, double* d_traction)
{
  const int gdim = p.gdim;
  double turned[3];
  project(p.normal, p.last, gdim, turned);
  const double size = std::sqrt(dot(p.last, p.last, gdim)), left = std::sqrt(dot(turned, turned, gdim));
  const double scale = left > 0.0 ? size / left : 0.0;
  const double last_n = dot(p.normal, p.last, gdim), increment_n = dot(p.normal, p.increment, gdim);
  const double trial = std::sqrt(dot(result.trial, result.trial, gdim));
  for (int j = 0; j < num; ++j)
  {
    double n[3], d_last[3], d[3], d_trial[3];
    for (int c = 0; c < gdim; ++c)
    {
      n[c] = d_normal[c * num + j];
      d[c] = d_increment[c * num + j];
    }
    const double turn_last = dot(n, p.last, gdim), turn_increment = dot(n, p.increment, gdim);
    const double along = dot(p.normal, d, gdim);
    for (int c = 0; c < gdim; ++c)
      d_last[c] = -n[c] * last_n - p.normal[c] * turn_last;
    const double stretch = left > 0.0 ? dot(turned, d_last, gdim) / (left * left) : 0.0;
    for (int c = 0; c < gdim; ++c)
    {
      const double s = d[c] - p.normal[c] * along - n[c] * increment_n - p.normal[c] * turn_increment;
      d_trial[c] = scale * (d_last[c] - turned[c] * stretch) - p.stiffness * s;
    }
    if (result.slips)
    {
      const double limit = p.coefficient * p.pressure;
      const double radial = dot(result.trial, d_trial, gdim) / (trial * trial);
      for (int c = 0; c < gdim; ++c)
        d_trial[c] =
            (p.coefficient * d_pressure[j] * result.trial[c] + limit * (d_trial[c] - result.trial[c] * radial)) / trial;
    }
    for (int c = 0; c < gdim; ++c)
      d_traction[c * num + j] = d_trial[c];
  }
}
} // namespace dolfinx_impact::enforcement
