// SPDX-License-Identifier: MIT
#include "InputChanges.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::integrators
{
namespace
{
constexpr double least = 0.01; // change of an input that is always allowed before the next look
constexpr double margin = 1.5; // by which the effect that was seen may be exceeded
} // namespace

void InputChanges::add(double change)
{
  stale = true;
  total += change;
}

void InputChanges::done(double before, double after)
{
  const auto counts = [](double x) { return x > 0.0 && std::isfinite(x); };
  if (stale && counts(before) && counts(after) && counts(total))
  {
    const double seen = margin * std::abs(2.0 * std::log(after / before)), most = 2.0 * std::max(total, allowed);
    allowed = std::max(least, std::min(most, seen > 0.0 ? effect * total / seen : most));
  }
  stale = false;
  total = 0.0;
}

} // namespace dolfinx_impact::integrators
