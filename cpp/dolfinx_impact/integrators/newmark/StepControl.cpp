// SPDX-License-Identifier: MIT
#include "StepControl.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::integrators
{
namespace
{
constexpr double same = 1e-9;                             // relative difference of steps that count as equal
constexpr double safety = 0.9;                            // of the step that the error estimate allows
constexpr double largest_growth = 2.0, largest_cut = 0.2; // factors from one step to the next
constexpr double rejected = 2.0;                          // times the tolerance: errors beyond it repeat the step
} // namespace

StepControl::StepControl(double largest, double smallest, std::optional<double> tolerance, std::optional<double> length,
                         double last)
    : _largest(largest), _smallest(smallest), _tolerance(tolerance),
      _length(std::min(length.value_or(largest), largest)), _last(last)
{
}

std::pair<double, double> StepControl::next(double time, double goal)
{
  const double left = goal - time, count = std::max(1.0, std::ceil(left / _length * (1.0 - same)));
  double step = left / count;
  if (std::abs(step - _last) <= same * step) // equal steps share a matrix and its factors
    step = _last;
  _last = step;
  return {step, count == 1.0 ? goal : time + step};
}

bool StepControl::failed(double step)
{
  _length = 0.5 * step;
  return _length >= _smallest;
}

bool StepControl::accepts(double step, std::optional<double> error)
{
  if (!_tolerance || !error || *error <= rejected * *_tolerance || step <= _smallest)
    return true;
  _length = std::max(step * factor(*error), _smallest);
  return false;
}

/// Factor of the next step: the error is of the third power of the step.
double StepControl::factor(double error) const
{
  if (error <= 0.0)
    return largest_growth;
  return std::clamp(safety * std::cbrt(*_tolerance / error), largest_cut, largest_growth);
}

void StepControl::choose_next_step(double step, int iterations, std::optional<double> error)
{
  double wanted = iterations <= few && _length < _largest ? 2.0 * _length : _length;
  if (iterations > many && step <= _length * (1.0 + same))
    wanted = 0.5 * step;
  else if (_tolerance && error)
  {
    // A step that was shortened to meet a time says little about longer ones.
    wanted = std::max(step * factor(*error), *error <= *_tolerance ? _length : 0.0);
    wanted = std::min(wanted, largest_growth * std::max(step, _length));
  }
  _length = std::min(std::max(wanted, _smallest), _largest);
}
} // namespace dolfinx_impact::integrators
