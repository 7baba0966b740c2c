#include "CentralDifference.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

// The accounts of a run and what it saves.
namespace impact::integrators
{
namespace
{
/// Kinetic energy half a step on may exceed all energy put in by 1/(1 - (omega dt/2)^2) in stable runs: 50 at 99 % of
/// the limit. More than this is growth.
constexpr double unstable = 1000.0;
} // namespace

void CentralDifference::account(const Sums& sums, double dt, bool commit)
{
  _residual_work.before = 0.5 * _last_step * sums.before;
  _load_work.before = 0.5 * _last_step * sums.load_before;
  const bool classical = _scheme == Scheme::classical;
  const double old = classical ? 0.5 * (sums.old_speed + sums.momentum) : sums.old_speed;
  const double now = classical && _last_step > 0.0 ? 0.5 * (sums.momentum + sums.speed) : sums.momentum;
  _damped.before = 0.5 * _last_step * _alpha * old;
  auto& e = _local;
  std::fill(e.begin(), e.end(), 0.0);
  // At the start v_(-1/2) = 2 v_0 - v_(1/2), seed (3.77).
  e[Local::kinetic] = _last_step > 0.0 ? 0.5 * sums.momentum : sums.momentum - 0.5 * sums.speed;
  e[Local::speed] = 0.5 * sums.speed;
  e[Local::position] = 0.5 * sums.position;
  e[Local::residual_work] = _residual_work.value();
  e[Local::load_work] = _load_work.value() + _obstacle_work;
  e[Local::support_work] = _support_before;
  e[Local::damped] = _damped.value();
  for (const Part& part : _parts)
  {
    e[Local::part_work + int(part.account)] += part.work.value();
    e[Local::parts_position] += 0.5 * part.sign * part.position;
  }
  double* force = e.data() + Local::size;
  for (const Contact& c : _contacts)
  {
    for (int k = 0; k < _bs; ++k)
      force[k] = c.contact->force()[k];
    force += 3;
    const enforcement::ContactEnergy energy = c.contact->energy();
    e[Local::stored] += energy.stored;
    e[Local::friction] += energy.friction;
    e[Local::normal] += energy.normal;
    e[Local::passed] += c.contact->passage().node >= 0;
    if (c.contact->kinematic())
    {
      e[Local::kinematic] += energy.normal;
      e[Local::taken] -= energy.normal + energy.later_normal;
      e[Local::recoverable] += energy.recoverable;
    }
  }
  e[Local::search] = _used;
  e[Local::stop] = _stop ? 1.0 : 0.0;
  if (!commit)
    return;
  _residual_work.commit(0.5 * dt * sums.after);
  _load_work.commit(0.5 * dt * sums.load_after);
  _damped.commit(0.5 * dt * _alpha * now);
  for (Part& part : _parts)
    part.work.commit(0.0); // the other half when ghosts' velocities are there
}

void CentralDifference::reduce_begin()
{
  MPI_Iallreduce(_local.data(), _global.data(), int(_local.size()), MPI_DOUBLE, MPI_SUM, _halo->map().comm(),
                 &_request);
}

/// Sums of the last step over ranks are there; returns false if they tell that it was unstable.
bool CentralDifference::reduce_end()
{
  if (_request == MPI_REQUEST_NULL)
    return true;
  MPI_Wait(&_request, MPI_STATUS_IGNORE);
  if (_global[Local::search] > 0.0)
    _search_due = true;
  _stopped = _global[Local::stop] > 0.0;
  // So nodes that leave the master never give back more in all than contact has taken.
  const double taken = _global[Local::taken], recoverable = _global[Local::recoverable];
  _release_share = recoverable > 0.0 ? std::clamp(taken / recoverable, 0.0, 1.0) : 0.0;
  const Energies now = energies_of(_global, _linear);
  if (_row)
    std::copy(_global.begin() + Local::size, _global.end(), std::copy(now.values.begin(), now.values.end(), _row));
  _row = nullptr;
  const double speed = _global[Local::speed], internal = now.values[Energies::internal];
  // The first step tells what there is at the start; springs that start pressed give theirs back.
  if (_reference == 0.0)
    _reference = speed + std::max(0.0, internal) + now.values[Energies::contact];
  _reference = std::max(_reference, now.values[Energies::external] + std::max(0.0, -internal));
  _gain.see(now, -_global[Local::kinematic]);
  return std::isfinite(speed) && !(speed > unstable * _reference) && !(_gain.now > _gain_limit) &&
         !(_global[Local::passed] > 0.0);
}

// --- what the run looks like now ----------------------------------------------------------------------------

Energies CentralDifference::energies()
{
  if (!_fresh)
    evaluate();
  const double dt = _last_step;
  Sums sums = measure(_owned, _r.data(), loads(), _inverse.data(), coefficients(dt), _u.data(), _v.data());
  double support = 0.0;
  for (const Motion& motion : _motions)
    for (std::size_t k = 0; k < motion.dofs.size(); ++k)
    {
      const std::int32_t i = motion.dofs[k];
      const double v = _v[i], next = dt > 0.0 ? (target(motion, k, _beyond.data()) - _u[i]) / dt : v;
      const double force = _mass[i] * ((dt > 0.0 ? (next - v) / dt : 0.0) + _alpha * v) + _r[i] - load_at(i);
      support += force * v;
      sums.momentum += _mass[i] * v * next;
    }
  _support_work.before = 0.5 * _last_step * support;
  _support_before = _support_work.value();
  account(sums, dt, false);
  std::vector<double> total(_local.size());
  MPI_Allreduce(_local.data(), total.data(), int(total.size()), MPI_DOUBLE, MPI_SUM, _halo->map().comm());
  return energies_of(total, _linear);
}

void CentralDifference::motion(std::span<double> v, std::span<double> a)
{
  if (v.size() != _owned || a.size() != _owned)
    throw std::invalid_argument("motion takes the owned entries of velocity and acceleration");
  if (!_fresh)
    evaluate();
  const double dt = _last_step;
  const Coefficients c = coefficients(dt);
  // Kinematic contact knows its forces once the step is predicted: those of the last step.
  const std::vector<double> contact = _kinematic ? kept_forces() : std::vector<double>();
  for (std::size_t i = 0; i < _owned; ++i)
  {
    const double f = _inverse[i] * (load_at(i) - _r[i] + (_kinematic ? contact[_owned + i] : 0.0));
    if (_inverse[i] > 0.0)
      a[i] = dt > 0.0 ? ((c.keep - 1.0) * _v[i] + c.push * f) / dt : f - _alpha * _v[i];
    else
      a[i] = 0.0;
  }
  for (const Motion& motion : _motions)
    for (std::size_t k = 0; k < motion.dofs.size(); ++k)
      if (const std::int32_t i = motion.dofs[k]; dt > 0.0)
        a[i] = ((target(motion, k, _beyond.data()) - _u[i]) / dt - _v[i]) / dt;
  for (std::size_t i = 0; i < _owned; ++i)
    v[i] = _v[i] + 0.5 * dt * a[i];
}

std::pair<std::int32_t, double> CentralDifference::fastest() const
{
  std::pair<std::int32_t, double> found{-1, -1.0};
  for (std::size_t i = 0; i < _owned; ++i)
    if (!(std::abs(_v[i]) <= found.second))
    {
      found = {std::int32_t(i), std::abs(_v[i])};
      if (std::isnan(_v[i]))
        break;
    }
  return found;
}

std::pair<int, enforcement::Passage> CentralDifference::passage() const
{
  std::pair<int, enforcement::Passage> found{-1, {}};
  for (std::size_t k = 0; k < _contacts.size(); ++k)
    if (const enforcement::Passage p = _contacts[k].contact->passage(); p.facets > found.second.facets)
      found = {int(k), p};
  return found;
}

bool CentralDifference::passed() const
{
  int mine = passage().first >= 0, all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_MAX, _halo->map().comm());
  return all > 0;
}

CentralDifference::Saved CentralDifference::save()
{
  if (!_fresh)
    evaluate();
  Saved saved{
      {_u.begin(), _u.begin() + _owned}, {_v.begin(), _v.begin() + _owned}, {_r.begin(), _r.begin() + _owned}, {}, {}};
  const std::vector<double> contact = kept_forces();
  for (Part& part : _parts) // owners take all of it, here as in the run that continues
  {
    const double* force = contact.data();
    if (part.account != Account::contact)
    {
      _halo->reverse(part.force.data(), _bs);
      std::fill(part.force.begin() + _owned, part.force.end(), 0.0);
      force = part.force.data();
    }
    saved.parts.insert(saved.parts.end(), force, force + _owned);
    saved.accounts.insert(saved.accounts.end(), {part.work.done, part.work.before, part.position});
  }
  saved.parts.insert(saved.parts.end(), contact.begin() + _owned, contact.end());
  for (const Work& work : {_residual_work, _load_work, _support_work, _damped})
    saved.accounts.push_back(work.done);
  saved.accounts.insert(saved.accounts.end(), {_obstacle_work, _reference, _last_step, _contact_step, _gain.lowest,
                                               _gain.largest, _release_share});
  for (const Contact& c : _contacts)
    for (const auto& values : {c.place, c.moved, c.moved_before})
      saved.accounts.insert(saved.accounts.end(), values.begin(), values.end());
  for (const Contact& c : _contacts)
    c.contact->forget();
  _search_due = true;
  return saved;
}

void CentralDifference::restore(const Saved& saved)
{
  if (saved.u.size() != _owned || saved.v.size() != _owned || saved.r.size() != _owned ||
      saved.parts.size() != num_saved_parts() * _owned ||
      saved.accounts.size() != num_additive() + 6 + 9 * _contacts.size())
    throw std::invalid_argument("the saved state is that of another problem");
  start(saved.u, saved.v);
  std::copy(saved.r.begin(), saved.r.end(), _r.begin());
  _near.kept.assign(2 * _owned, 0.0);
  const double* accounts = saved.accounts.data();
  for (std::size_t k = 0; k < _parts.size(); ++k, accounts += 3)
  {
    const bool contact = _parts[k].account == Account::contact;
    std::copy_n(saved.parts.begin() + k * _owned, _owned, contact ? _near.kept.begin() : _parts[k].force.begin());
    _parts[k].work = {accounts[0], accounts[1]};
    _parts[k].position = accounts[2];
  }
  std::copy_n(saved.parts.begin() + _parts.size() * _owned, _owned, _near.kept.begin() + _owned);
  for (Work* work : {&_residual_work, &_load_work, &_support_work, &_damped})
    *work = {*accounts++, 0.0};
  _obstacle_work = *accounts++;
  _reference = *accounts++;
  _last_step = *accounts++;
  _contact_step = *accounts++;
  _gain.lowest = *accounts++;
  _gain.largest = *accounts++;
  _release_share = *accounts++;
  for (Contact& c : _contacts)
  {
    for (auto* values : {&c.place, &c.moved, &c.moved_before})
      for (double& value : *values)
        value = *accounts++;
    c.contact->set_obstacle(c.place, c.moved);
    c.contact->forget();
  }
  if (_contacts.empty())
    _near.kept.clear();
  _fresh = true;
}
} // namespace impact::integrators
