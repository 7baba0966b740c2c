// SPDX-License-Identifier: MIT
#include "ExplicitStepper.h"
#include "../common/OnAllRanks.h"
#include "../common/text.h"
#include "failed_run.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::problems
{
using common::text;

namespace
{
constexpr std::int64_t chunk = 1000;   // steps that the integrator takes in one call
constexpr std::int64_t snapshot = 100; // steps between the states that a failed run returns to
constexpr double most_steps = 1e9;     // in one call: what a history of as many steps takes is a hundred gigabytes
constexpr double round_off = 1e-12;    // relative, of a length of steps

/// Distance to the next number.
double spacing(double x)
{
  return std::nextafter(x, std::numeric_limits<double>::infinity()) - x;
}
} // namespace

ExplicitStepper::ExplicitStepper(System system, double& time, std::int64_t& step)
    : _system(std::move(system)), _time(time), _step(step),
      _nominal(integrators::SafeStep::safety * _system.safe.value())
{
}

std::vector<double> ExplicitStepper::table(std::span<const double> times, RunObserver& observer) const
{
  auto given = observer.table(times);
  return given ? std::move(*given) : _system.table(times);
}

void ExplicitStepper::begin_anew()
{
  _system.safe.begin_anew();
  _nominal = integrators::SafeStep::safety * _system.safe.value();
  _schedule.reset();
}

void ExplicitStepper::start(std::span<const double> u, std::span<const double> v, RunObserver& observer)
{
  _system.integrator.set_contact_step(_nominal);
  _system.integrator.start(u, v);
  _good.reset(); // internal variables may be others than at an earlier start
  run(0, observer);
  _system.check_start();
}

/// Springs are others: the forces of the start once more.
void ExplicitStepper::restart(RunObserver& observer)
{
  const std::vector<double> u = _system.integrator.displacement();
  std::vector<double> v(u.size()), a(u.size());
  _system.integrator.motion(v, a);
  start(u, v, observer);
}

void ExplicitStepper::advance(double until, const AdvanceOptions& options, RunObserver& observer)
{
  if (until == _time)
    return;
  _gain_warning = options.gain_warning;
  _system.integrator.set_gain_limit(options.gain_limit);
  integrators::SafeStep& safe = _system.safe;
  const bool known = !safe.changes.stale;
  if (!known)
    safe.find();
  choose_schedule(until, options, observer);
  safe.enter(known, options.dt.has_value());
  safe.begin(options.dt ? 0.0 : _nominal);
  observer.begins(*_schedule);
  while (_step < _schedule->last)
    take_steps(until, options, observer);
  _schedule.reset();
}

void ExplicitStepper::take_steps(double until, const AdvanceOptions& options, RunObserver& observer)
{
  if (_system.safe.due(_step))
    recheck(until, options, observer);
  const std::int64_t rest = _schedule->last - _step, first = _step == 0 ? 1 : chunk;
  run(std::min({first, rest, observer.room(), _system.safe.steps_left(_step, rest)}), observer);
  if (first == 1) // kinematic contact has gaps only after a step
    _system.check_start();
  observer.after_steps();
}

/// Takes steps, fewer if a rank is asked to stop; 0: computes the forces of the present state.
void ExplicitStepper::run(std::int64_t count, RunObserver& observer)
{
  integrators::CentralDifference& integrator = _system.integrator;
  _times.resize(count + 2); // the integrator needs functions of time one step ahead
  for (std::int64_t k = 0; k < count + 2; ++k)
    _times[k] = _schedule ? _schedule->time(_step + k) : _time;
  const std::vector<double> table = this->table(_times, observer);
  if (!_good || _step - _good->step >= snapshot || count > snapshot)
  {
    GoodState& good = _good.emplace(_step, _time);
    good.u = integrator.displacement();
    good.v.resize(good.u.size());
    std::vector<double> a(good.u.size());
    integrator.motion(good.v, a);
    _system.keep_history();
  }
  _rows.resize(count * integrator.row_size());
  _lengths.assign(count, _schedule ? _schedule->dt() : 1.0);
  std::function<bool()> asked;
  if (observer.asks())
    asked = [&observer] { return observer.asked(); };
  const int columns = int(table.size() / _times.size());
  const std::int64_t done = integrator.run(_lengths, table, columns, _rows, asked);
  if (asked) // what was asked for since is told here, not where the steps have not been noted yet
    observer.asked();
  const std::span<const double> times(_times.data(), done), rows(_rows.data(), done * integrator.row_size());
  _system.history.add(times, rows);
  observer.add_rows(times, rows);
  if (done < count && !integrator.stopped())
    fail(_times[done], "", observer);
  _step += done;
  _time = _times[done];
  _next_time = _times[done + 1];
  if (integrator.gain().most > _gain_warning && !_warned)
  {
    _warned = true;
    warn(observer,
         "the run gains energy: by the time " + text("%.6g", _time) + " " + gain_message(integrator.gain().most));
  }
}

void ExplicitStepper::warn(RunObserver& observer, const std::string& text) const
{
  int rank = 0;
  MPI_Comm_rank(comm(), &rank);
  if (rank == 0)
    observer.warn(text);
}

/// Returns to the last good state and throws, on all ranks.
void ExplicitStepper::fail(double time, const std::string& fault, RunObserver& observer)
{
  std::optional<std::string> unsolved = observer.unsolved();
  if (!unsolved)
    unsolved = _system.unsolved();
  const FailedRun failed(_system.integrator, *_system.space, _system.contacts, *unsolved, time, _nominal,
                         _system.safe.value());
  _schedule.reset();
  observer.failed();
  _step = _good->step;
  _time = _good->time;
  _system.safe.start_again(_step);
  _system.go_back();
  _system.history.begin_anew();
  _system.integrator.start(_good->u, _good->v);
  run(0, observer);
  _system.update_motion();
  if (!fault.empty())
    throw common::Failure(failed.message_of(fault, _time));
  double stable = _system.safe.value();
  try
  {
    stable = _system.safe.compute();
  }
  catch (const common::BadValue&) // of a state that is no number there is none
  {
  }
  throw common::Failure(failed.message(_time, stable));
}

/// Keeps the schedule of an `advance` to the same time that was left.
void ExplicitStepper::choose_schedule(double until, const AdvanceOptions& options, RunObserver& observer)
{
  const double stable = _system.safe.value();
  const double nominal = options.dt.value_or(integrators::SafeStep::safety * stable);
  bool known = _schedule.has_value();
  if (!options.dt)
    known = known && _schedule->automatic && !(_nominal > nominal);
  else
  {
    if (!(nominal > 0.0))
      throw common::BadValue("dt is " + text("%g", nominal) + ": it must be positive [T]");
    known = known && nominal == _nominal;
    if (nominal > stable * (1.0 + round_off))
    {
      const std::string beyond = "dt = " + text("%.6g", nominal) + " is beyond the stable step " + text("%.6g", stable);
      if (!options.unsafe)
        throw common::BadValue(beyond + ": take a smaller one, or pass unsafe=True to try it");
      warn(observer, beyond + ": the run may go unstable");
    }
  }
  if (known && _schedule->until == until)
    return; // a run that was restored or left goes on with the steps it had
  if (!std::isfinite(nominal))
    throw common::BadValue("nothing limits the step: give dt");
  const double needed = (until - _time) / nominal * (1.0 - round_off);
  if (needed > most_steps || nominal < spacing(until))
    throw common::BadValue(
        "a step of " + text("%g", nominal) + " takes " + text("%.3g", needed) + " steps to the time " +
        text("%g", until) + ", more than " + text("%g", most_steps) +
        (options.dt ? "; take a larger dt"
                    : ": the stable step is that small; check the mesh for tiny cells and the contacts for a large "
                      "penalty"));
  const std::int64_t count = std::max<std::int64_t>(1, std::llround(std::ceil(needed)));
  _nominal = nominal;
  _schedule = integrators::StepSchedule{_time, until, _step, _step + count, !options.dt};
  const double contact = _system.integrator.contact_step();
  if (nominal > contact || std::isinf(contact))
  {
    // Springs by the step follow longer steps only, which do not bear them otherwise: under shorter ones a stiffness
    // that changes would change the forces of what is already pressed. (Where cells have no stiffness at rest, nothing
    // limits the step at the start.)
    _system.integrator.set_contact_step(nominal);
    if (_step == 0)
      restart(observer);
  }
}

/// Finds the stable step of the deformed body, and shortens the steps if they exceed it.
void ExplicitStepper::recheck(double until, const AdvanceOptions& options, RunObserver& observer)
{
  _system.update_motion();
  try
  {
    _system.safe.recheck(_step);
  }
  catch (const common::BadValue& e) // the deformation is beyond what the law is made for
  {
    fail(_time, e.what(), observer);
  }
  if (_nominal > (options.dt ? 1.0 : integrators::SafeStep::safety) * _system.safe.value())
  {
    _schedule.reset();
    choose_schedule(until, options, observer);
  }
  _system.safe.begin(options.dt ? 0.0 : _nominal);
}

void ExplicitStepper::resume(double next_time, double nominal, const std::optional<integrators::StepSchedule>& schedule,
                             RunObserver& observer)
{
  _next_time = next_time;
  _nominal = nominal;
  _schedule = schedule;
  _good.reset();
  const std::vector<double> times{_time, _next_time};
  const std::vector<double> table = this->table(times, observer);
  _system.integrator.run({}, table, int(table.size() / 2), {}, {});
  _system.safe.begin(nominal);
}
} // namespace dolfinx_impact::problems
