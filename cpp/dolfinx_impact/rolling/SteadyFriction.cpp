// SPDX-License-Identifier: MIT
#include "SteadyFriction.h"
#include "../common/vectors.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::rolling
{
SteadyFriction::SteadyFriction(const FrictionNodes& nodes, std::span<const double> friction,
                               std::span<const double> gap, std::span<const double> slip,
                               std::span<const double> multipliers)
    : active(gap.size(), 0), sliding(gap.size(), 0), target(multipliers.size(), 0.0)
{
  const int g = nodes.gdim;
  for (std::size_t i = 0; i < gap.size(); ++i)
  {
    if (!nodes.carriers[i])
      continue;
    const double *n = &nodes.normal[i * g], *lambda = &multipliers[i * g];
    const double along = dot(n, lambda, g), pressure = along - nodes.normal_stiffness[i] * gap[i];
    if (!(pressure > 0.0))
      continue;
    active[i] = 1;
    double trial[3] = {};
    for (int c = 0; c < g; ++c)
      trial[c] = lambda[c] - along * n[c] - nodes.tangential_stiffness[i] * slip[i * g + c];
    const double size = std::sqrt(dot(trial, trial, g)), limit = friction[i] * pressure;
    sliding[i] = size > limit;
    for (int c = 0; c < g; ++c)
      target[i * g + c] = pressure * n[c] + (sliding[i] ? limit / size : 1.0) * trial[c];
  }
}

std::vector<double> tangents(std::span<const double> normal, std::span<const double> first,
                             std::span<const std::int8_t> fixed)
{
  if (normal.size() == 2)
    return {-normal[1], normal[0]};
  double wanted[3] = {first[0], first[1], first[2]}, flat[3];
  const auto flatten = [&]
  {
    const double along = dot(normal.data(), wanted, 3);
    for (int c = 0; c < 3; ++c)
      flat[c] = wanted[c] - along * normal[c];
    return std::sqrt(dot(flat, flat, 3));
  };
  const auto follow = [&](int axis)
  {
    for (int c = 0; c < 3; ++c)
      wanted[c] = c == axis;
  };
  for (int c = 0; c < 3; ++c)
    if (fixed[c] && std::abs(normal[c]) < 0.5)
      follow(c);
  for (int c = 0; c < 3; ++c) // where the direction is normal to the surface, any other will do
    if (const double size = flatten(); size <= 1e-6 * std::max(std::sqrt(dot(wanted, wanted, 3)), 1e-300))
      follow(c);
  const double size = flatten();
  std::vector<double> out(6);
  for (int c = 0; c < 3; ++c)
    out[c] = flat[c] / size;
  cross(normal.data(), out.data(), &out[3]);
  return out;
}
} // namespace dolfinx_impact::rolling
