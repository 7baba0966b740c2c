// SPDX-License-Identifier: MIT
#include "PrescribedMotion.h"
#include <stdexcept>

namespace dolfinx_impact::integrators
{
void PrescribedMotion::add(std::span<const std::int32_t> entries, std::span<const double> values, int amplitude)
{
  if (entries.size() != values.size())
    throw std::invalid_argument("a prescribed motion has as many values as degrees of freedom");
  const std::vector<double> none(entries.size(), 0.0);
  _groups.push_back({{entries.begin(), entries.end()}, {values.begin(), values.end()}, amplitude, none, none, none});
}

void PrescribedMotion::keep(const double* u, const double* v, const double* r)
{
  for (Group& group : _groups)
    for (std::size_t k = 0; k < group.entries.size(); ++k)
    {
      const std::int32_t i = group.entries[k];
      group.u[k] = u[i];
      group.v[k] = v[i];
      group.r[k] = r[i];
    }
}

PrescribedMotion::Power PrescribedMotion::impose(double dt, double h, double alpha, const double* amplitudes,
                                                 const double* mass, const Loads& loads, double* u, double* v,
                                                 Sums& sums) const
{
  Power power;
  for (const Group& group : _groups)
    for (std::size_t k = 0; k < group.entries.size(); ++k)
    {
      const std::int32_t i = group.entries[k];
      const double place = group.displacement(k, amplitudes), r = group.r[k], load = loads.force(i), m = mass[i];
      const double v_old = group.v[k], v_new = (place - group.u[k]) / dt;
      const double force = m * ((v_new - v_old) / h + alpha * v_old) + r - load;
      power.before += force * v_old;
      power.after += force * v_new;
      sums.momentum += m * v_old * v_new;
      sums.speed += m * v_new * v_new;
      sums.old_speed += m * v_old * v_old;
      sums.after += r * (v_new - v[i]);
      sums.load_after += load * (v_new - v[i]);
      v[i] = v_new;
      u[i] = place;
    }
  return power;
}

double PrescribedMotion::power(double dt, double alpha, const double* amplitudes, const double* mass,
                               const Loads& loads, const double* u, const double* v, const double* r, Sums& sums) const
{
  double power = 0.0;
  for (const Group& group : _groups)
    for (std::size_t k = 0; k < group.entries.size(); ++k)
    {
      const std::int32_t i = group.entries[k];
      const double v_new = dt > 0.0 ? (group.displacement(k, amplitudes) - u[i]) / dt : v[i];
      const double inertia = mass[i] * ((dt > 0.0 ? (v_new - v[i]) / dt : 0.0) + alpha * v[i]);
      power += (inertia + r[i] - loads.force(i)) * v[i];
      sums.momentum += mass[i] * v[i] * v_new;
    }
  return power;
}

void PrescribedMotion::accelerations(double dt, const double* amplitudes, const double* u, const double* v,
                                     double* a) const
{
  if (!(dt > 0.0))
    return;
  for (const Group& group : _groups)
    for (std::size_t k = 0; k < group.entries.size(); ++k)
    {
      const std::int32_t i = group.entries[k];
      a[i] = ((group.displacement(k, amplitudes) - u[i]) / dt - v[i]) / dt;
    }
}
} // namespace dolfinx_impact::integrators
