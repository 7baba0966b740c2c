// SPDX-License-Identifier: MIT
#include "Increment.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::solve
{
namespace
{
// Linearised problems in succession without an active set that fits: one for each state of a cycle of two.
constexpr int most_unsettled = 2;
constexpr double falling = 0.9; // of the residual: what such problems must reduce it to for going on
constexpr double same = 1e-3;   // relative difference of the residuals of states that count as equal
} // namespace

void Increment::add(double norm, std::int64_t size, std::int64_t changed)
{
  residual_norms.push_back(norm);
  active_set_sizes.push_back(size);
  changes.push_back(changed);
}

Increment& Increment::converged()
{
  fault.clear();
  return *this;
}

Increment& Increment::failed(std::string why, bool without_hope)
{
  fault = std::move(why);
  hopeless = without_hope;
  return *this;
}

int Increment::cycle() const
{
  const std::size_t num = residual_norms.size();
  for (std::size_t period : {2, 3})
  {
    if (num < 2 * period)
      continue;
    const double* norms = residual_norms.data() + num - period;
    const std::int64_t* sizes = active_set_sizes.data() + num - period;
    bool again = true;
    for (std::size_t i = 0; i < period; ++i)
      again = again && std::abs(norms[i - period] - norms[i]) <= same * norms[i] && sizes[i] == sizes[i - period];
    const auto [least, most] = std::minmax_element(norms, norms + period);
    if (again && *most - *least > same * *most)
      return int(period);
  }
  return 0;
}

bool Increment::stalled() const
{
  if (unsettled_in_succession < most_unsettled + 1)
    return false;
  const auto end = residual_norms.end();
  return *std::min_element(end - most_unsettled, end) >= falling * *(end - most_unsettled - 1);
}
} // namespace dolfinx_impact::solve
