// SPDX-License-Identifier: MIT
#include "StepMotion.h"

namespace dolfinx_impact::integrators
{
StepMotion::StepMotion(const ImplicitScheme& scheme, double step, Motion start, std::span<const std::int8_t> massless,
                       std::span<const std::int8_t> fixed, const TimeValues& prescribed)
    : _step(step), _mean_factor(1.0 / (scheme.beta * step * step)), _start(std::move(start)),
      _massless(massless.begin(), massless.end()), _fixed(fixed.begin(), fixed.begin() + massless.size())
{
  const std::size_t n = _massless.size();
  const double beta = scheme.beta, gamma = scheme.gamma, m = scheme.alpha_m, f = scheme.alpha_f;
  const double acceleration_factor = (1.0 - m) / (1.0 - f) * _mean_factor,
               velocity_factor = gamma * step * _mean_factor;
  _mean_rest.resize(n);
  _acceleration_factor.assign(n, acceleration_factor);
  _velocity_factor.assign(n, velocity_factor);
  _acceleration_rest.resize(n);
  _velocity_rest.resize(n);
  for (std::size_t i = 0; i < n; ++i)
  {
    const double v = _start.velocity[i], a = _start.acceleration[i], mean = _start.mean[i];
    // A_1 = (u_1 - u_0) / (beta h^2) + rest of Newmark's formula for the displacement.
    _mean_rest[i] = -v / (beta * step) - (0.5 / beta - 1.0) * mean;
    _acceleration_rest[i] = ((1.0 - m) * _mean_rest[i] + m * mean - f * a) / (1.0 - f);
    _velocity_rest[i] = v + step * ((1.0 - gamma) * mean + gamma * _mean_rest[i]);
    if (_massless[i])
    {
      _velocity_factor[i] = 1.0 / step;
      _velocity_rest[i] = _acceleration_factor[i] = _acceleration_rest[i] = 0.0;
    }
    if (_fixed[i])
    {
      _velocity_factor[i] = _acceleration_factor[i] = 0.0;
      _velocity_rest[i] = prescribed.velocity[i];
      _acceleration_rest[i] = prescribed.acceleration[i];
    }
  }
}

Motion StepMotion::end(std::span<const double> displacement) const
{
  const std::size_t n = _massless.size();
  Motion out{{displacement.begin(), displacement.begin() + n}, {}, {}, {}};
  out.velocity.resize(n);
  out.acceleration.resize(n);
  out.mean.resize(n);
  for (std::size_t i = 0; i < n; ++i)
  {
    const double moved = displacement[i] - _start.displacement[i];
    out.velocity[i] = _velocity_factor[i] * moved + _velocity_rest[i];
    out.acceleration[i] = _acceleration_factor[i] * moved + _acceleration_rest[i];
    out.mean[i] = _fixed[i] ? out.acceleration[i] : _massless[i] ? 0.0 : _mean_factor * moved + _mean_rest[i];
  }
  return out;
}

std::vector<double> StepMotion::predictor() const
{
  std::vector<double> out(_start.displacement);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] += _step * _start.velocity[i] + 0.5 * _step * _step * _start.mean[i];
  return out;
}
} // namespace dolfinx_impact::integrators
