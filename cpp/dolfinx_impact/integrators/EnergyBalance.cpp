// SPDX-License-Identifier: MIT
#include "EnergyBalance.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::integrators
{
namespace
{
/// Number of steps whose rounding errors may add up at random, as the root of their number: docs/explicit/energies.md.
constexpr double random_steps = 1e6;
/// Gains are relative to no less than this part of what the bodies store at the start: an equilibrium is one to the
/// tolerance of its solver, and nothing else moves a body that begins at rest in it.
constexpr double equilibrium_error = 1e-9;

/// What the product of the velocities before and after a time level has more than the energy that both steps see, to
/// first order in the difference of their lengths: docs/explicit/energies.md, "Kinetic energy".
/// @param[in] old kinetic energy half a step before; product: of both velocities; later: half a step after [F L]
double change_of_step(const Steps& steps, double old, double product, double later)
{
  const double change = steps.after - steps.before, both = steps.after + steps.before;
  return change / (both * both) * (steps.after * (product - old) + steps.before * (later - product));
}
} // namespace

EnergyBalance::~EnergyBalance()
{
  if (_request != MPI_REQUEST_NULL)
    MPI_Wait(&_request, MPI_STATUS_IGNORE);
}

void EnergyBalance::reset(double uncertainty)
{
  for (Work* work : {&_residual_work, &_load_work, &_support_work, &_damped})
    *work = {};
  _reference = _release_share = _elastic = _released = 0.0;
  _release_limit = _given_limit;
  _gain = {};
  _totals = {};
  _uncertainty = uncertainty;
}

EnergySums EnergyBalance::local(const Sums& sums, const Steps& steps, std::span<const ForceTerm> terms,
                                const ContactForces& contact)
{
  _residual_work.before = 0.5 * steps.before * sums.before;
  _load_work.before = 0.5 * steps.before * sums.load_before;
  const double old_speed = _scheme == Scheme::classical ? 0.5 * (sums.old_speed + sums.momentum) : sums.old_speed;
  _damped.before = 0.5 * steps.before * _alpha * old_speed;
  EnergySums e;
  // At the start v_(-1/2) = 2 v_0 - v_(1/2), seed (3.77).
  e.kinetic = steps.before > 0.0 ? 0.5 * sums.momentum : sums.momentum - 0.5 * sums.speed;
  e.speed = 0.5 * sums.speed;
  e.position = 0.5 * sums.position;
  e.residual_work = _residual_work.value();
  e.elastic = _elastic;
  e.unsolved = _unsolved;
  e.load_work = _load_work.value();
  e.support_work = _support_value;
  e.damped = _damped.value();
  for (const ForceTerm& term : terms)
  {
    e.work[std::size_t(term.kind())] += term.work.value();
    e.terms_position += 0.5 * term.signed_position();
    if (term.kind() == WorkKind::foundation)
      e.foundation += 0.5 * term.position();
  }
  contact.add_energies(e);
  if (steps.before > 0.0)
  {
    // What is done of a work, without the half before the time level, goes up to the middle of the step before.
    e.half_kinetic = 0.5 * sums.old_speed + contact.half_body_energy();
    e.kinetic -= change_of_step(steps, e.half_kinetic, e.kinetic, e.speed);
    e.half_external = _load_work.done + _support_work.done + contact.half_obstacle_work();
    for (const ForceTerm& term : terms)
      if (term.kind() == WorkKind::external)
        e.half_external += term.work.done;
  }
  return e;
}

void EnergyBalance::add_step(const Sums& sums, const PrescribedMotion::Power& power, const Steps& steps,
                             std::span<ForceTerm> terms, ContactForces& contact, bool stop, bool deformed)
{
  _support_work.before = 0.5 * steps.before * power.before;
  _support_value = _support_work.value();
  _steps = steps;
  _local = local(sums, steps, terms, contact);
  _local.stops_asked = stop ? 1.0 : 0.0;
  _local.deformed = deformed ? 1.0 : 0.0;
  const bool classical = _scheme == Scheme::classical && steps.before > 0.0;
  const double speed = classical ? 0.5 * (sums.momentum + sums.speed) : sums.momentum;
  _support_work.commit(0.5 * steps.after * power.after);
  _residual_work.commit(0.5 * steps.after * sums.after);
  _load_work.commit(0.5 * steps.after * sums.load_after);
  _damped.commit(0.5 * steps.after * _alpha * speed);
  for (ForceTerm& term : terms)
    term.work.commit(0.0); // the other half is added when the ghosts' velocities are there
  contact.commit();
}

void EnergyBalance::begin_sum(const ContactForces& contact, int bs, const History& history, std::size_t step)
{
  _buffer.resize(EnergySums::size + 3 * contact.size());
  _summed.resize(_buffer.size());
  const auto values = _local.values();
  std::copy(values.begin(), values.end(), _buffer.begin());
  contact.resultants(bs, _buffer.data() + EnergySums::size);
  _history = history;
  _step = step;
  MPI_Iallreduce(_buffer.data(), _summed.data(), int(_buffer.size()), MPI_DOUBLE, MPI_SUM, _comm, &_request);
}

bool EnergyBalance::end_sum()
{
  if (_request == MPI_REQUEST_NULL)
  {
    _totals = {};
    return true;
  }
  MPI_Wait(&_request, MPI_STATUS_IGNORE);
  std::array<double, EnergySums::size> values;
  std::copy_n(_summed.begin(), values.size(), values.begin());
  _totals = EnergySums::of(values);
  _release_share = _totals.recoverable > 0.0 ? std::clamp(_totals.taken / _totals.recoverable, 0.0, 1.0) : 0.0;
  const Energies now = _totals.energies(_internal);
  _history.write(_step, now, std::span(_summed).subspan(EnergySums::size));
  _history = {};
  // The first step tells what there is at the start; springs that start pressed give theirs back.
  if (_steps.before == 0.0)
  {
    _release_limit = _given_limit + std::abs(_totals.position);
    _reference = _totals.speed + std::max(0.0, now.internal) + now.contact;
  }
  _released = -now.internal;
  // Loads that begin at zero have done no work up to the time level at which they move the body first.
  const double put_in = std::max(now.external, _totals.half_external) + std::clamp(_released, 0.0, _release_limit);
  _reference = std::max(_reference, put_in);
  const double round_off = 0.5 * random_steps * _uncertainty / (_steps.after * _steps.after);
  _gain.update(now, -_totals.kinematic, round_off);
  if (_steps.before == 0.0)
    _gain.largest = std::max(_gain.largest, equilibrium_error * std::abs(_totals.position));
  const bool grows = _totals.half_kinetic > largest_growth * std::max(_reference, round_off) || _gain.now > _gain_limit;
  return std::isfinite(_totals.speed) && !(grows && std::isfinite(_gain_limit)) && !(_totals.passages > 0.0) &&
         !(_totals.unsolved > 0.0);
}

Energies EnergyBalance::energies(const Sums& sums, double support_power, const Steps& steps,
                                 std::span<const ForceTerm> terms, const ContactForces& contact)
{
  _support_work.before = 0.5 * steps.before * support_power;
  _support_value = _support_work.value();
  const auto mine = local(sums, steps, terms, contact).values();
  std::array<double, EnergySums::size> all;
  MPI_Allreduce(mine.data(), all.data(), int(all.size()), MPI_DOUBLE, MPI_SUM, _comm);
  return EnergySums::of(all).energies(_internal);
}

EnergyBalance::Saved EnergyBalance::save() const
{
  return {.residual_work = _residual_work.done,
          .load_work = _load_work.done,
          .support_work = _support_work.done,
          .damped = _damped.done,
          .elastic = _elastic,
          .reference = _reference,
          .lowest = _gain.lowest,
          .largest = _gain.largest,
          .release_share = _release_share,
          .release_limit = _release_limit};
}

void EnergyBalance::restore(const Saved& saved)
{
  _residual_work = {saved.residual_work, 0.0};
  _load_work = {saved.load_work, 0.0};
  _support_work = {saved.support_work, 0.0};
  _damped = {saved.damped, 0.0};
  _elastic = saved.elastic;
  _reference = saved.reference;
  _gain.lowest = saved.lowest;
  _gain.largest = saved.largest;
  _release_share = saved.release_share;
  _release_limit = saved.release_limit;
}
} // namespace dolfinx_impact::integrators
