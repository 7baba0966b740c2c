#include "CentralDifference.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/fem/DofMap.h>
#include <limits>
#include <stdexcept>

namespace impact::integrators
{
CentralDifference::CentralDifference(std::shared_ptr<const FunctionSpace> V, Forces internal, bool linear,
                                     std::span<const double> mass, double alpha, Scheme scheme)
    : _V(std::move(V)), _bs(_V->dofmap()->index_map_bs()), _internal(std::move(internal)), _linear(linear),
      _alpha(alpha), _scheme(scheme), _mass(mass.begin(), mass.end())
{
  const auto map = _V->dofmap()->index_map;
  _owned = std::size_t(map->size_local()) * _bs;
  _own_size = _owned + std::size_t(map->num_ghosts()) * _bs;
  if (mass.size() != _own_size)
    throw std::invalid_argument("the mass has " + std::to_string(mass.size()) + " entries on this rank, the space " +
                                std::to_string(_own_size));
  check(_internal);
  _inverse.resize(_own_size);
  for (std::size_t i = 0; i < _own_size; ++i)
    _inverse[i] = 1.0 / _mass[i];
  _local.assign(Local::size, 0.0);
  _global = _local;
  resize(map);
}

CentralDifference::~CentralDifference()
{
  if (_request != MPI_REQUEST_NULL)
    MPI_Wait(&_request, MPI_STATUS_IGNORE);
}

// --- set-up -------------------------------------------------------------------------------------------------

void CentralDifference::check(const Forces& forces) const
{
  if (!forces.inner || !forces.outer)
    throw std::invalid_argument(std::string("the operator of the ") + (forces.inner ? "outer" : "inner") +
                                " cells is null: give one without cells where there are none");
  for (const std::string& name : {forces.displacement, forces.velocity})
    if (!name.empty() && !forces.inner->has(name) && !forces.outer->has(name))
      throw std::invalid_argument("no kernel of the forces has a coefficient named '" + name +
                                  "': give the name in the kernels, or an empty one if they have none");
}

void CentralDifference::set_contact_step(double dt)
{
  if (!(dt > 0.0))
    throw std::invalid_argument("the step of contact stiffnesses is " + std::to_string(dt) + ": it must be positive");
  _contact_step = dt;
}

void CentralDifference::add_term(Forces forces, Account account)
{
  if (account == Account::contact)
    throw std::invalid_argument("contacts are added by add_contact");
  check(forces);
  const double sign = account == Account::external ? -1.0 : 1.0;
  _parts.push_back({std::move(forces), account, sign, std::vector<double>(_u.size(), 0.0), {}, 0.0});
  bind(_parts.back().forces);
}

void CentralDifference::add_load(std::span<const std::int32_t> dofs, std::span<const double> values, int amplitude)
{
  if (dofs.size() != values.size())
    throw std::invalid_argument("a load has as many values as degrees of freedom");
  _loads.push_back({{dofs.begin(), dofs.end()},
                    {values.begin(), values.end()},
                    amplitude,
                    std::numeric_limits<double>::quiet_NaN()});
  _load.resize(_owned, 0.0);
}

void CentralDifference::set_load(std::size_t i, std::span<const double> values)
{
  Load& load = _loads.at(i);
  if (values.size() != load.values.size())
    throw std::invalid_argument("a load has as many values as degrees of freedom");
  load.values.assign(values.begin(), values.end());
  load.reached = std::numeric_limits<double>::quiet_NaN(); // sum anew
}

void CentralDifference::prescribe(std::span<const std::int32_t> dofs, std::span<const double> values, int amplitude)
{
  if (dofs.size() != values.size())
    throw std::invalid_argument("a prescribed motion has as many values as degrees of freedom");
  const std::vector<double> none(dofs.size(), 0.0);
  _motions.push_back({{dofs.begin(), dofs.end()}, {values.begin(), values.end()}, amplitude, none, none, none});
  for (std::int32_t dof : dofs)
    _inverse.at(dof) = 0.0;
  _halo->forward(_inverse.data(), _bs);
}

void CentralDifference::add_contact(std::shared_ptr<enforcement::NodalContact> contact, std::array<int, 3> columns)
{
  if (contact->kinematic())
    _kinematic = true;
  else if (!_penalty)
  {
    _penalty = true;
    _parts.push_back({{}, Account::contact, -1.0, {}, {}, 0.0});
  }
  _contacts.push_back({std::move(contact), columns});
  _local.assign(Local::size + 3 * _contacts.size(), 0.0);
  _global = _local;
  _search_due = true;
}

void CentralDifference::bind(const Forces& forces)
{
  for (InternalForce* operation : {forces.inner.get(), forces.outer.get()})
    if (operation) // contact has none
    {
      if (!forces.displacement.empty())
        operation->read(forces.displacement, _u.data());
      if (!forces.velocity.empty())
        operation->read(forces.velocity, _v.data());
    }
}

void CentralDifference::resize(std::shared_ptr<const dolfinx::common::IndexMap> map)
{
  if (_halo)
    _traffic += _halo->traffic();
  _halo = std::make_unique<Halo>(map);
  const std::size_t size = std::size_t(_halo->num_nodes()) * _bs;
  for (std::vector<double>* values : {&_u, &_v, &_r, &_mass, &_inverse})
    values->resize(size, 0.0);
  _old_ghosts.resize(size - _owned);
  for (Part& part : _parts)
    if (part.account != Account::contact)
      part.force.resize(size, 0.0);
  bind(_internal);
  for (const Part& part : _parts)
    bind(part.forces);
}

void CentralDifference::start(std::span<const double> u, std::span<const double> v)
{
  if (u.size() != _owned || v.size() != _owned)
    throw std::invalid_argument("start takes the owned entries of displacement and velocity");
  std::copy(u.begin(), u.end(), _u.begin());
  std::copy(v.begin(), v.end(), _v.begin());
  _halo->forward(_u.data(), _bs);
  _halo->forward(_v.data(), _bs);
  std::fill(_r.begin(), _r.end(), 0.0);
  std::fill(_near.force.begin(), _near.force.end(), 0.0);
  _near.kept.clear();
  for (Part& part : _parts)
  {
    std::fill(part.force.begin(), part.force.end(), 0.0);
    part.work = {};
  }
  for (Work* work : {&_residual_work, &_load_work, &_support_work, &_damped})
    *work = {};
  _obstacle_work = _reference = _last_step = _release_share = 0.0;
  _gain = {};
  _fresh = _pending = false;
  _search_due = true;
}

// --- the step -----------------------------------------------------------------------------------------------

/// The first step is half a step from v_0: seed (3.76).
Coefficients CentralDifference::coefficients(double dt) const
{
  const double h = 0.5 * (_last_step + dt);
  if (_scheme == Scheme::classical && _last_step > 0.0)
    return {(1.0 - 0.5 * dt * _alpha) / (1.0 + 0.5 * dt * _alpha), dt / (1.0 + 0.5 * dt * _alpha), dt};
  return {1.0 - h * _alpha, h, dt};
}

void CentralDifference::apply_loads(const double* amplitudes)
{
  bool changed = false;
  for (Load& load : _loads)
  {
    const double value = load.amplitude < 0 ? 1.0 : amplitudes[load.amplitude];
    changed = changed || value != load.reached;
    load.reached = value;
  }
  if (!changed)
    return;
  // From zero, so that the sum does not depend on how it was reached.
  std::fill(_load.begin(), _load.end(), 0.0);
  for (const Load& load : _loads)
    for (std::size_t k = 0; k < load.dofs.size(); ++k)
      _load[load.dofs[k]] += load.reached * load.values[k];
}

double CentralDifference::target(const Motion& motion, std::size_t k, const double* amplitudes)
{
  return motion.values[k] * (motion.amplitude < 0 ? 1.0 : amplitudes[motion.amplitude]);
}

void CentralDifference::prescribed_motion(double dt, double h, const double* amplitudes, Sums& sums)
{
  double before = 0.0, after = 0.0;
  for (Motion& motion : _motions)
    for (std::size_t k = 0; k < motion.dofs.size(); ++k)
    {
      const std::int32_t i = motion.dofs[k];
      const double place = target(motion, k, amplitudes);
      const double old = motion.v[k], v = (place - motion.u[k]) / dt, m = _mass[i];
      const double load = load_at(i);
      const double force = m * ((v - old) / h + _alpha * old) + motion.r[k] - load;
      before += force * old;
      after += force * v;
      sums.momentum += m * old * v;
      sums.speed += m * v * v;
      sums.old_speed += m * old * old;
      sums.after += motion.r[k] * (v - _v[i]);
      sums.load_after += load * (v - _v[i]);
      _v[i] = v;
      _u[i] = place;
    }
  _support_work.before = 0.5 * _last_step * before;
  _support_before = _support_work.value();
  _support_work.commit(0.5 * dt * after);
}

void CentralDifference::advance(double dt, const double* amplitudes)
{
  const Coefficients c = coefficients(dt);
  for (Motion& motion : _motions)
    for (std::size_t k = 0; k < motion.dofs.size(); ++k)
    {
      const std::int32_t i = motion.dofs[k];
      motion.u[k] = _u[i];
      motion.v[k] = _v[i];
      motion.r[k] = _r[i];
    }
  if (_kinematic)
  {
    const Stopwatch watch(_contact_seconds);
    for (std::size_t k = 0; k < _touched.size(); ++k)
      for (int j = 0; j < _bs; ++j)
      {
        const std::size_t n = k * _bs + j, i = std::size_t(_touched[k]) * _bs + j;
        _near.before[2 * n] = _v[i];
        _near.before[2 * n + 1] = _r[i];
      }
  }
  Sums sums = update(_owned, _r.data(), loads(), _inverse.data(), c, _u.data(), _v.data());
  prescribed_motion(dt, 0.5 * (_last_step + dt), amplitudes, sums);
  move_obstacles(amplitudes, false);
  if (_kinematic)
    kinematic_contact(dt, c.push, sums);
  else
  {
    _halo->forward_begin(_u.data(), _bs);
    _pending = true;
  }
  account(sums, dt, true);
  _last_step = dt;
  _fresh = false;
}

/// Asks ten times a second at most: the answer may take a lock.
bool CentralDifference::asked_to_stop(const std::function<bool()>& asked)
{
  if (!asked)
    return false;
  const auto now = std::chrono::steady_clock::now();
  if (now - _asked < std::chrono::milliseconds(100))
    return false;
  _asked = now;
  return asked();
}

int CentralDifference::run(std::span<const double> steps, std::span<const double> table, int columns,
                           std::span<double> history, const std::function<bool()>& asked)
{
  if (table.size() != (steps.size() + 2) * columns)
    throw std::invalid_argument("the table of amplitudes needs a row for each time level, and one beyond");
  _beyond.assign(table.end() - columns, table.end());
  if (!history.empty() && history.size() != steps.size() * row_size())
    throw std::invalid_argument("the history needs a row for each step");
  for (double dt : steps)
    if (!(dt > 0.0))
      throw std::invalid_argument("a step is " + std::to_string(dt) + ": it must be positive");
  _stop = _stopped = false;
  apply_loads(table.data());
  if (_last_step == 0.0)
    move_obstacles(table.data(), true);
  if (_fresh && _search_due && !_contacts.empty())
    search();
  for (std::size_t k = 0; k < steps.size(); ++k)
  {
    const double* row = table.data() + k * columns;
    apply_loads(row);
    if (!_fresh && !evaluate())
    {
      _stopped = false;
      return int(k);
    }
    if (_stopped) // the sums of the last step have told
    {
      _beyond.assign(row + columns, row + 2 * columns);
      return int(k);
    }
    _stop = _stop || asked_to_stop(asked);
    advance(steps[k], row + columns);
    _row = history.empty() ? nullptr : history.data() + k * row_size();
    reduce_begin();
  }
  apply_loads(table.data() + steps.size() * columns);
  if (_fresh)
    return int(steps.size());
  const bool stable = evaluate();
  // Sums tell it with the next step; springs have looked at the last state just now.
  if (stable && !(_penalty && passed()))
    return int(steps.size());
  _stopped = false;
  return int(steps.size()) - 1;
}
} // namespace impact::integrators
