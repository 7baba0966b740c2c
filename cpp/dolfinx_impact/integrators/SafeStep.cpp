// SPDX-License-Identifier: MIT
#include "SafeStep.h"
#include <algorithm>
#include <cmath>
#include <limits>

namespace dolfinx_impact::integrators
{
namespace
{
constexpr std::int64_t first_check = 2; // steps after which it is computed for the second time, of bodies that flow
constexpr double wanted = 0.03;         // relative change from one check to the next; 0.9 of the stable step leaves 0.1
} // namespace

SafeStep::SafeStep(const std::shared_ptr<const operators::Function>& u, std::shared_ptr<CellFrequencies> frequencies,
                   CellSteps steps, Kind kind, CentralDifference& integrator)
    : _u(u), _frequencies(std::move(frequencies)), _steps(std::move(steps)), _kind(kind), _integrator(integrator)
{
  if (kind.watched || kind.periodic)
    _frequencies->keep_masses();
  if (kind.watched)
    _watch.emplace(*u->function_space(), _frequencies, _steps, integrator);
  begin_anew();
}

void SafeStep::begin_anew()
{
  _value = _watch ? _watch->find_all(_u->x()->array()) : compute();
  _check_step = _check_interval = _kind.flows ? first_check : _longest;
  _periodic = _kind.periodic;
  _deformed = false;
  _num_found = 0;
  changes = {};
}

double SafeStep::compute()
{
  const auto found = _frequencies->by_cell();
  double smallest = std::numeric_limits<double>::infinity();
  for (const double step : _steps(found.squares, found.rates))
    smallest = std::min(smallest, step);
  MPI_Allreduce(MPI_IN_PLACE, &smallest, 1, MPI_DOUBLE, MPI_MIN, _u->function_space()->mesh()->comm());
  return smallest;
}

void SafeStep::find()
{
  const double before = _value;
  ++_num_found;
  if (!_watch)
    _value = compute();
  else if (changes.stale || _kind.periodic) // frequencies of all cells may be others
    _value = _watch->find_all(_u->x()->array());
  else
    _value = _watch->find_changed(_u->x()->array());
  changes.done(before, _value);
  _deformed = false;
}

void SafeStep::begin(double nominal)
{
  if (_watch)
    _watch->begin(nominal);
}

void SafeStep::enter(bool known, bool given)
{
  if (_watch)
    _deformed = known && deformed(); // a call that was left did not look at what had deformed
  _periodic = _kind.periodic || (_watch && given);
}

bool SafeStep::due(std::int64_t step) const
{
  return changes.due() || (changes.stale && step > 0 && step % _longest == 0) || (_periodic && step >= _check_step) ||
         deformed();
}

/// With plastic flow the next check is due when the stable step will have changed by about `wanted`, if it goes on as
/// since the last one; the time between two checks is at most doubled.
void SafeStep::recheck(std::int64_t step)
{
  const double before = _value;
  find();
  const double changed = std::isfinite(before) ? std::abs(_value / before - 1.0) : 0.0;
  const double factor = changed > 0.0 ? std::min(2.0, wanted / changed) : 2.0;
  plan(step, std::clamp<std::int64_t>(std::int64_t(factor * double(_check_interval)), 1, _longest));
}

std::int64_t SafeStep::steps_left(std::int64_t step, std::int64_t otherwise) const
{
  return _periodic ? _check_step - step : otherwise;
}

void SafeStep::set_longest_interval(std::int64_t steps)
{
  _longest = steps;
  if (!_kind.flows)
    _check_step = _check_interval = steps;
}

void SafeStep::start_again(std::int64_t step)
{
  plan(step, first_check);
  changes.add(std::numeric_limits<double>::infinity()); // the stable step was that of another state
}

void SafeStep::restore(const Saved& saved)
{
  _value = saved.value;
  _check_step = saved.check_step;
  _check_interval = saved.check_interval;
  _deformed = saved.deformed;
}

/// Elastic bodies are checked every so many steps, those that flow after the given interval.
void SafeStep::plan(std::int64_t step, std::int64_t interval)
{
  _check_interval = _kind.flows ? interval : _longest;
  _check_step = _kind.flows ? step + interval : (step / _longest + 1) * _longest;
}
} // namespace dolfinx_impact::integrators
