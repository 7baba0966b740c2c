// SPDX-License-Identifier: MIT
#include "Flow.h"
#include "../common/vectors.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::rolling
{
namespace
{
constexpr double unit = 1e-12; ///< what the length of a unit vector is off by, and the sine of angles that are none

void check(const Motion& motion, int gdim)
{
  if (!motion.rate)
    throw std::invalid_argument("a motion has no rate: give it a constant");
  const Spin* spin = motion.spin();
  const std::size_t wanted = spin ? 1 : std::size_t(gdim);
  if (motion.rate->value.size() != wanted)
    throw std::invalid_argument("the rate of a motion has " + std::to_string(motion.rate->value.size()) +
                                " components: a spin has one, a translation one for each direction");
  if (spin && std::abs(std::sqrt(dot(spin->axis.data(), spin->axis.data(), 3)) - 1.0) > unit)
    throw std::invalid_argument("the axis of a spin is no unit vector");
  if (spin && gdim == 2 && std::hypot(spin->axis[0], spin->axis[1]) > unit)
    throw std::invalid_argument("the axis of a spin in the plane must be along z");
}
} // namespace

void Motion::velocity(const double* x, int gdim, double* w) const
{
  if (const Spin* about = spin())
  {
    double arm[3] = {0.0, 0.0, 0.0}, full[3];
    for (int c = 0; c < gdim; ++c)
      arm[c] = x[c] - about->point[c];
    cross(about->axis.data(), arm, full);
    for (int c = 0; c < gdim; ++c)
      w[c] = rate->value[0] * full[c];
  }
  else
    std::copy_n(rate->value.begin(), gdim, w);
}

Flow::Flow(std::shared_ptr<const surface::FunctionSpace> V, std::vector<Motion> motions)
    : _gdim(int(V->mesh()->geometry().dim())), _places(V->tabulate_dof_coordinates(false)), _motions(std::move(motions))
{
  for (const Motion& motion : _motions)
  {
    check(motion, _gdim);
    _reached.emplace_back(motion.rate->value.size(), 0.0);
  }
}

const Motion* Flow::first_spin() const
{
  const auto found = std::ranges::find_if(_motions, [](const Motion& motion) { return motion.spin() != nullptr; });
  return found == _motions.end() ? nullptr : &*found;
}

std::vector<double> Flow::at_nodes() const
{
  std::vector<double> w(_places.size() / 3 * _gdim, 0.0);
  for (const Motion& motion : _motions)
    for (std::int32_t node : motion.nodes)
      motion.velocity(place(node), _gdim, &w[std::size_t(node) * _gdim]);
  return w;
}

std::vector<solve::Ramp> Flow::ramps()
{
  std::vector<solve::Ramp> out;
  for (std::size_t i = 0; i < _motions.size(); ++i)
    out.push_back({_motions[i].rate->value, _reached[i]});
  return out;
}

std::vector<double> Flow::rates() const
{
  std::vector<double> out;
  for (const Motion& motion : _motions)
    out.insert(out.end(), motion.rate->value.begin(), motion.rate->value.end());
  return out;
}

void Flow::set_rates(std::span<const double> rates)
{
  std::size_t first = 0;
  for (const Motion& motion : _motions)
  {
    std::copy_n(rates.begin() + first, motion.rate->value.size(), motion.rate->value.begin());
    first += motion.rate->value.size();
  }
}

std::vector<double> Flow::reached() const
{
  std::vector<double> out;
  for (const std::vector<double>& one : _reached)
    out.insert(out.end(), one.begin(), one.end());
  return out;
}

void Flow::mark_reached()
{
  for (std::size_t i = 0; i < _motions.size(); ++i)
    _reached[i] = _motions[i].rate->value;
}
} // namespace dolfinx_impact::rolling
