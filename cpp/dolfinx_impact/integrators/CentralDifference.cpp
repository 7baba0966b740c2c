// SPDX-License-Identifier: MIT
#include "CentralDifference.h"
#include "../operators/cell_ghosts.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/fem/DofMap.h>
#include <limits>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::integrators
{
namespace
{
/// Steps between looks at deformations: the looks take some percent of a step together, and cells that are struck
/// deform by a tenth of the speed over that of waves meanwhile.
constexpr int steps_per_look = 4;
} // namespace

CentralDifference::CentralDifference(const std::shared_ptr<const FunctionSpace>& V, FormForces internal, bool linear,
                                     std::span<const double> mass, double alpha, Scheme scheme)
    : _positions(V), _fields(V->dofmap()->index_map, V->dofmap()->index_map_bs(),
                             // kernels read whole nodes where the space has those as blocks
                             V->dofmap()->bs() == V->dofmap()->index_map_bs(), operators::cell_ghosts(*V)),
      _internal(std::move(internal)), _alpha(alpha), _scheme(scheme), _loads(_fields.owned_entries),
      _contact(V->dofmap()->index_map->comm()), _energies(V->dofmap()->index_map->comm(),
                                                          _internal.has_history() ? InternalEnergy::elastic
                                                          : linear                ? InternalEnergy::quadratic
                                                                                  : InternalEnergy::work,
                                                          scheme, alpha)
{
  if (mass.size() != _fields.own)
    throw std::invalid_argument("the mass has " + std::to_string(mass.size()) + " entries on this rank, the space " +
                                std::to_string(_fields.own));
  for (double x : V->mesh()->geometry().x())
    _largest_coordinate = std::max(_largest_coordinate, std::abs(x));
  _internal.check();
  _fields.use(_internal.outer_nodes());
  _internal.read(_fields);
  _internal.read_positions(_positions);
  _fields.spread(mass, _fields.mass);
  for (std::size_t i = 0; i < mass.size(); ++i)
    _fields.inverse[_fields.entry(i)] = 1.0 / mass[i];
  _masses = NodeMasses(_fields);
}

std::vector<std::int32_t> CentralDifference::entries(std::span<const std::int32_t> dofs) const
{
  std::vector<std::int32_t> out(dofs.size());
  std::ranges::transform(dofs, out.begin(), [this](std::int32_t dof) { return std::int32_t(_fields.entry(dof)); });
  return out;
}

// --- set-up
// -----------------------------------------------------------------------------------------------------------

void CentralDifference::add_term(FormForces forces, WorkKind kind)
{
  forces.check();
  _fields.use(forces.outer_nodes());
  _terms.emplace_back(std::move(forces), kind, _fields);
  _terms.back().read_positions(_positions);
}

void CentralDifference::add_load(std::span<const std::int32_t> dofs, std::span<const double> values, int amplitude)
{
  _loads.add(entries(dofs), values, amplitude);
}

void CentralDifference::set_load(std::size_t i, std::span<const double> values)
{
  _loads.set_values(i, values);
}

void CentralDifference::prescribe(std::span<const std::int32_t> dofs, std::span<const double> values, int amplitude)
{
  const std::vector<std::int32_t> places = entries(dofs);
  _prescribed.add(places, values, amplitude);
  for (const std::int32_t place : places)
  {
    _fields.inverse.at(place) = 0.0;
    _masses.prescribe(std::size_t(place));
  }
  _fields.halo->forward(_fields.inverse, _fields.bs, _fields.stride);
}

void CentralDifference::add_contact(enforcement::NodalPair pair, std::array<int, 3> columns,
                                    std::array<int, 3> rotation)
{
  _contact.add(std::move(pair), columns, rotation);
}

void CentralDifference::add_rigid_body_contact(enforcement::NodalPair pair, std::shared_ptr<RigidBody> body)
{
  _contact.add(std::move(pair), std::move(body));
}

void CentralDifference::start(std::span<const double> u, std::span<const double> v)
{
  if (u.size() != _fields.owned || v.size() != _fields.owned)
    throw std::invalid_argument("start takes the owned entries of displacement and velocity");
  _positions.update();
  _fields.spread(u, _fields.u);
  _fields.spread(v, _fields.v);
  _fields.halo->forward(_fields.u, _fields.bs, _fields.stride);
  _fields.halo->forward(_fields.v, _fields.bs, _fields.stride);
  _fields.exchanging = false;
  std::fill(_fields.r.begin(), _fields.r.end(), 0.0);
  for (ForceTerm& term : _terms)
    term.reset();
  _contact.reset();
  _energies.reset(uncertainty());
  _last_step = 0.0;
  _evaluated = false;
  _unwatched = 0;
  _far = _deformed = false;
}

void CentralDifference::set_watch(std::span<const double> u, std::span<const double> allowed)
{
  if (!_watch)
    throw std::invalid_argument("there is no watch");
  AlignedVector own(_fields.own_entries, 0.0);
  _fields.spread(u.first(_fields.own), own);
  _watch->set(own, allowed);
  _far = _deformed = false;
}

std::vector<double> CentralDifference::deformations(std::span<const double> u)
{
  if (!_watch)
    throw std::invalid_argument("there is no watch");
  AlignedVector own(_fields.own_entries, 0.0);
  _fields.spread(u.first(_fields.own), own);
  return _watch->deformations(own);
}

/// Mass times the square of what rounding does to a position, of all ranks.
double CentralDifference::uncertainty() const
{
  double mass = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < _fields.owned_entries; ++i)
  {
    mass += _fields.mass[i];
    largest = std::max(largest, std::abs(_fields.u[i]));
  }
  largest += std::max(_largest_coordinate, _contact.largest_position());
  const MPI_Comm comm = _fields.space_map().comm();
  MPI_Allreduce(MPI_IN_PLACE, &mass, 1, MPI_DOUBLE, MPI_SUM, comm);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm);
  const double rounding = std::numeric_limits<double>::epsilon() * largest;
  return mass * rounding * rounding;
}

// --- the step
// ---------------------------------------------------------------------------------------------------------

/// The first step is half a step from v_0: seed (3.76).
Coefficients CentralDifference::coefficients(double dt) const
{
  const double h = 0.5 * (_last_step + dt);
  if (_scheme == Scheme::classical && _last_step > 0.0)
    return {(1.0 - 0.5 * dt * _alpha) / (1.0 + 0.5 * dt * _alpha), dt / (1.0 + 0.5 * dt * _alpha), dt};
  return {1.0 - h * _alpha, h, dt};
}

/// A search has given the fields other ghosts.
void CentralDifference::fields_changed()
{
  _internal.read(_fields);
  for (ForceTerm& term : _terms)
    term.resize(_fields);
}

/// Forces at the present time level. @returns is the run stable, as far as the sums of the last step tell?
bool CentralDifference::evaluate()
{
  _contact.check_step();
  assemble(*_internal.early, _fields, _fields.r);
  _fields.end_exchange(_last_step);
  const bool stable = _energies.end_sum();
  _deformed = _deformed || _energies.deformed();
  _stopped = _stopped || _energies.stop_asked() || _energies.deformed();
  if (_energies.search_due())
    _contact.request_search();
  for (ForceTerm& term : _terms)
    term.work_of_step(_fields, _last_step);
  if (_contact.work_of_step(_fields, _last_step))
    fields_changed();
  assemble(*_internal.outer, _fields, _fields.r);
  for (ForceTerm& term : _terms)
    term.evaluate(_fields, _last_step);
  _contact.evaluate(_fields);
  _fields.halo->reverse_begin(_fields.r, _fields.bs, _fields.stride);
  assemble(*_internal.late, _fields, _fields.r);
  _energies.set_materials(_internal.elastic_energy(), _internal.num_unsolved());
  _internal.commit();
  _contact.sum_forces_on_bodies();
  _contact.predict_searches();
  end_residual_exchange();
  _evaluated = true;
  return stable;
}

/// Owners receive the ghosts' contributions.
void CentralDifference::end_residual_exchange()
{
  _fields.halo->reverse_end(_fields.r, _fields.bs, _fields.stride);
  std::fill(_fields.r.begin() + _fields.owned_entries, _fields.r.end(), 0.0);
}

void CentralDifference::advance(double dt, const double* amplitudes)
{
  NodalFields& f = _fields;
  const Coefficients c = coefficients(dt);
  const double mean_step = 0.5 * (_last_step + dt);
  _prescribed.keep(f.u.data(), f.v.data(), f.r.data());
  _contact.keep(f);
  Sums sums = _masses.known()
                  ? update(f.owned_entries / f.stride, f.r.data(), _loads.forces(), _masses, c, f.u.data(), f.v.data())
                  : update(f.owned_entries, f.r.data(), _loads.forces(), f.inverse.data(), f.mass.data(), c, f.u.data(),
                           f.v.data());
  const PrescribedMotion::Power power =
      _prescribed.impose(dt, mean_step, _alpha, amplitudes, f.mass.data(), _loads, f.u.data(), f.v.data(), sums);
  _contact.advance_bodies(dt, mean_step, _last_step == 0.0);
  _contact.move_obstacles(amplitudes, false);
  if (_contact.has_corrections())
    _contact.correct(f, dt, _last_step, c.push, _energies.release_share(), _loads, sums);
  else
    f.begin_exchange();
  _energies.add_step(sums, power, {_last_step, dt}, _terms, _contact, _stop, _far);
  _last_step = dt;
  _evaluated = false;
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

/// Ghosts' displacements are those of the present time level.
bool CentralDifference::look()
{
  if (!_watch || !_watch->is_set() || ++_unwatched < steps_per_look)
    return false;
  _unwatched = 0;
  return _watch->passed({_fields.u.data(), _fields.own_entries});
}

bool CentralDifference::passed() const
{
  int mine = passage().first >= 0, all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_MAX, _fields.space_map().comm());
  return all > 0;
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
  const History rows(history, _contact.size());
  _stop = _stopped = false;
  _positions.update();
  _loads.apply(table.data());
  _contact.apply_loads(table.data());
  if (_last_step == 0.0)
    _contact.move_obstacles(table.data(), true);
  if (_evaluated && _contact.search_due())
  {
    _contact.search(_fields, _last_step);
    fields_changed();
  }
  for (std::size_t k = 0; k < steps.size(); ++k)
  {
    const double* row = table.data() + k * columns;
    _loads.apply(row);
    _contact.apply_loads(row);
    if (!_evaluated && !evaluate())
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
    _far = look();
    advance(steps[k], row + columns);
    _energies.begin_sum(_contact, _fields.bs, rows, k);
  }
  _loads.apply(table.data() + steps.size() * columns);
  _contact.apply_loads(table.data() + steps.size() * columns);
  if (_evaluated)
    return int(steps.size());
  const bool stable = evaluate();
  // The sums of the next step would tell of passages; springs have just evaluated the last state.
  if (stable && !(_contact.has_springs() && passed()))
    return int(steps.size());
  _stopped = false;
  return int(steps.size()) - 1;
}

void CentralDifference::revise()
{
  if (!_evaluated)
    return; // nothing is known of this time level yet
  // Friction has its history: the forces of springs are not computed twice.
  const std::vector<double> springs = _contact.forces(_fields).springs;
  std::fill(_fields.r.begin(), _fields.r.end(), 0.0);
  _positions.update();
  for (const InternalForce* operation : _internal.parts())
    assemble(*operation, _fields, _fields.r);
  for (ForceTerm& term : _terms)
    term.evaluate(_fields, _last_step);
  _fields.halo->reverse_begin(_fields.r, _fields.bs, _fields.stride);
  end_residual_exchange();
  for (std::size_t i = 0; i < _fields.owned; ++i)
    _fields.r[_fields.entry(i)] -= springs[i];
}

// --- the present time level
// -------------------------------------------------------------------------------------------

Energies CentralDifference::energies()
{
  if (!_evaluated)
    evaluate();
  const NodalFields& f = _fields;
  Sums sums = measure(f.owned_entries, f.r.data(), _loads.forces(), f.inverse.data(), f.mass.data(),
                      coefficients(_last_step), f.u.data(), f.v.data());
  const double power = _prescribed.power(_last_step, _alpha, _beyond.data(), f.mass.data(), _loads, f.u.data(),
                                         f.v.data(), f.r.data(), sums);
  _contact.measure_bodies(_last_step > 0.0 ? _last_step : 0.0, _last_step == 0.0);
  return _energies.energies(sums, power, {_last_step, _last_step}, _terms, _contact);
}

/// Kinematic contact and ties know their forces once the step is predicted: those of the last step, empty without.
AlignedVector CentralDifference::kinematic_forces()
{
  AlignedVector out;
  if (_contact.has_corrections())
  {
    out.resize(_fields.owned_entries);
    _fields.spread(_contact.forces(_fields).kinematic, out);
  }
  return out;
}

void CentralDifference::motion(std::span<double> v, std::span<double> a)
{
  if (v.size() != _fields.owned || a.size() != _fields.owned)
    throw std::invalid_argument("motion takes the owned entries of velocity and acceleration");
  if (!_evaluated)
    evaluate();
  const double dt = _last_step;
  const Coefficients c = coefficients(dt);
  const NodalFields& fields = _fields;
  const AlignedVector kinematic = kinematic_forces();
  AlignedVector accelerations(fields.owned_entries, 0.0);
  for (std::size_t i = 0; i < accelerations.size(); ++i)
  {
    const double force = _loads.force(i) - fields.r[i] + (kinematic.empty() ? 0.0 : kinematic[i]);
    const double f = fields.inverse[i] * force;
    if (fields.inverse[i] > 0.0)
      accelerations[i] = dt > 0.0 ? ((c.keep - 1.0) * fields.v[i] + c.push * f) / dt : f - _alpha * fields.v[i];
  }
  _prescribed.accelerations(dt, _beyond.data(), fields.u.data(), fields.v.data(), accelerations.data());
  fields.collect(accelerations, a);
  fields.collect({fields.v.data(), fields.owned_entries}, v);
  for (std::size_t i = 0; i < fields.owned; ++i)
    v[i] += 0.5 * dt * a[i];
}

std::vector<double> CentralDifference::support_forces()
{
  std::vector<double> v(_fields.owned), a(_fields.owned), out(_fields.owned, 0.0);
  motion(v, a);
  const AlignedVector kinematic = kinematic_forces();
  AlignedVector forces(_fields.owned_entries, 0.0);
  _fields.spread(a, forces);
  for (std::size_t i = 0; i < forces.size(); ++i)
    if (_fields.inverse[i] > 0.0)
      forces[i] = 0.0;
    else
      forces[i] = _fields.mass[i] * (forces[i] + _alpha * _fields.v[i]) + _fields.r[i] - _loads.force(i) -
                  (kinematic.empty() ? 0.0 : kinematic[i]);
  _fields.collect(forces, out);
  return out;
}

std::pair<std::int32_t, double> CentralDifference::fastest() const
{
  std::pair<std::int32_t, double> found{-1, -1.0};
  const std::vector<double> velocities = _fields.owned_values(_fields.v);
  for (std::size_t i = 0; i < _fields.owned; ++i)
    if (const double v = velocities[i]; !(std::abs(v) <= found.second))
    {
      found = {std::int32_t(i), std::abs(v)};
      if (std::isnan(v))
        break;
    }
  return found;
}

state::State CentralDifference::saved_state()
{
  if (!_evaluated)
    evaluate();
  ContactNodes::Forces contact = _contact.forces(_fields);
  auto saved = std::make_shared<RunState>(_fields.owned, _terms.size(), _contact.size(), _contact.num_bodies());
  saved->u = _fields.owned_values(_fields.u);
  saved->v = _fields.owned_values(_fields.v);
  saved->r = _fields.owned_values(_fields.r);
  for (std::size_t k = 0; k < _terms.size(); ++k)
    saved->terms[k] = {_terms[k].saved_force(_fields), _terms[k].work, _terms[k].position()};
  saved->springs = {std::move(contact.springs), _contact.spring_work(), _contact.spring_position()};
  saved->kinematic = std::move(contact.kinematic);
  saved->energies = _energies.save();
  saved->obstacle_work = _contact.obstacle_work();
  saved->last_step = _last_step;
  saved->contact_step = _contact.step();
  saved->unwatched = _unwatched;
  saved->obstacles = _contact.obstacles();
  saved->bodies = _contact.bodies();
  _contact.forget_searches();
  state::State out = saved->state(_fields.bs);
  out.keep(std::move(saved));
  return out;
}

state::State CentralDifference::empty_state() const
{
  RunState run(_fields.owned, _terms.size(), _contact.size(), _contact.num_bodies());
  run.obstacles = _contact.obstacles(); // with as many values as they have
  run.bodies = _contact.bodies();
  return run.state(_fields.bs).copy();
}

void CentralDifference::resume(const state::State& saved)
{
  RunState run(_fields.owned, _terms.size(), _contact.size(), _contact.num_bodies());
  run.obstacles = _contact.obstacles(); // with as many values as they have
  run.bodies = _contact.bodies();
  run.state(_fields.bs).assign(saved);
  start(run.u, run.v);
  _fields.spread(run.r, _fields.r);
  for (std::size_t k = 0; k < _terms.size(); ++k)
    _terms[k].restore(_fields, run.terms[k].force, run.terms[k].work, run.terms[k].position);
  _contact.restore({run.springs.force, run.kinematic}, run.springs.work, run.springs.position, run.obstacle_work,
                   run.obstacles, run.bodies);
  _energies.restore(run.energies);
  _last_step = run.last_step;
  _unwatched = int(run.unwatched);
  if (run.contact_step > 0.0)
    _contact.set_step(run.contact_step);
  _evaluated = true;
}

Halo::Traffic CentralDifference::traffic() const
{
  Halo::Traffic out = _fields.traffic();
  out += _contact.traffic();
  return out;
}
} // namespace dolfinx_impact::integrators
