// SPDX-License-Identifier: MIT
#include "ContactForces.h"
#include "../common/Stopwatch.h"
#include "../common/clones.h"
#include "../common/columns.h"
#include "../gap/rotation.h"
#include <algorithm>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::integrators
{
using common::Stopwatch;

namespace
{
constexpr std::size_t sums_of_body = 12; ///< force and its moment

/// What corrected velocities add to the sums of the update (Sums): over all entries, mass times the change of the
/// velocity, times the velocity before and times the sum of predicted and corrected velocity [F L]; and the change
/// times the residual before [F L/T].
struct CorrectionSums
{
  double momentum, speed, after;
};

/// Velocities after forces of kinematic contact. A force changes nothing where the reciprocal mass is zero; elsewhere
/// mass times the change of the velocity is h times the force, so that no mass is needed.
/// @param[in] h step [T]
/// @param[in,out] v predicted, then corrected [L/T]
IMPACT_CLONES CorrectionSums correct_velocities(std::size_t size, double h, const double* inverse, const double* force,
                                                const double* v_before, const double* r_before, double* v)
{
  using common::Column, common::column;
  Column momentum = {}, speed = {}, after = {};
  std::size_t j = 0;
  for (; j + 4 <= size; j += 4)
  {
    const Column predicted = column(v + j), free = column(inverse + j);
    const Column impulse = free != 0.0 ? h * column(force + j) : Column{}, now = predicted + free * impulse;
    column(v + j) = now;
    momentum += impulse * column(v_before + j);
    speed += impulse * (now + predicted);
    after += column(r_before + j) * (now - predicted);
  }
  CorrectionSums out = {momentum[0] + momentum[1] + momentum[2] + momentum[3],
                        speed[0] + speed[1] + speed[2] + speed[3], after[0] + after[1] + after[2] + after[3]};
  for (; j < size; ++j)
  {
    const double predicted = v[j], impulse = inverse[j] != 0.0 ? h * force[j] : 0.0;
    v[j] = predicted + inverse[j] * impulse;
    out.momentum += impulse * v_before[j];
    out.speed += impulse * (v[j] + predicted);
    out.after += r_before[j] * (v[j] - predicted);
  }
  return out;
}
} // namespace

void ContactForces::add(enforcement::NodalPair pair, std::array<int, 3> columns, std::array<int, 3> rotation)
{
  std::vector<enforcement::SpringForces*> springs;
  std::vector<enforcement::KinematicContact*> kinematic;
  std::vector<enforcement::ExplicitTie*> ties;
  for (const auto& direction : pair.directions())
    if (auto* const force = dynamic_cast<enforcement::SpringForces*>(direction.get()))
      springs.push_back(force);
    else if (auto* const correction = dynamic_cast<enforcement::KinematicContact*>(direction.get()))
      kinematic.push_back(correction);
    else if (auto* const tie = dynamic_cast<enforcement::ExplicitTie*>(direction.get()))
      ties.push_back(tie);
    else
      throw std::invalid_argument("a contact has to act: by SpringForces, as a KinematicContact or as an ExplicitTie");
  if (int(!springs.empty()) + int(!kinematic.empty()) + int(!ties.empty()) > 1)
    throw std::invalid_argument("the two directions of a pair act differently: by SpringForces, as a KinematicContact "
                                "or as an ExplicitTie");
  for (const auto& direction : pair.directions())
    _directions.push_back(direction.get());
  _springs.insert(_springs.end(), springs.begin(), springs.end());
  for (enforcement::KinematicContact* contact : kinematic)
    _kinematic_step.add(contact);
  for (enforcement::ExplicitTie* tie : ties)
    _tie_step.add(tie);
  if (rotation[0] >= 0 && springs.empty())
    throw std::invalid_argument("a rigid master that turns as prescribed needs SpringForces");
  _pairs.push_back({std::move(pair), !kinematic.empty() || !ties.empty(), columns, rotation, {}, nullptr});
  _pairs.back().obstacle.rotates = rotation[0] >= 0;
  _search_due = true;
}

void ContactForces::add(enforcement::NodalPair pair, std::shared_ptr<RigidBody> body)
{
  if (!body)
    throw std::invalid_argument("there is no rigid body");
  if (pair.directions().size() != 1 || !dynamic_cast<enforcement::SpringForces*>(pair.directions().front().get()))
    throw std::invalid_argument("contact with a rigid body acts by SpringForces, in one direction");
  add(std::move(pair), std::array{-1, -1, -1});
  _pairs.back().body = body;
  add_body(std::move(body));
}

void ContactForces::add_body(std::shared_ptr<RigidBody> body)
{
  if (std::ranges::find(_bodies, body, &Body::body) != _bodies.end())
    return;
  _bodies.push_back({std::move(body)});
  int rank = 0, size = 1;
  MPI_Comm_rank(_comm, &rank);
  MPI_Comm_size(_comm, &size);
  _first_rank = rank == 0;
  _forces.assign(_bodies.size() * sums_of_body, 0.0);
  _gathered.assign(_forces.size() * size, 0.0);
}

void ContactForces::add(std::shared_ptr<RigidContact> contact)
{
  for (const RigidBody* body : {contact->slave().get(), contact->master().get()})
    if (body && std::ranges::none_of(_bodies, [&](const Body& b) { return b.body.get() == body; }))
      throw std::invalid_argument("the bodies of a contact of rigid bodies are added before it");
  _rigid_contacts.push_back(std::move(contact));
}

void ContactForces::set_body_loads(const RigidBody& body, std::array<int, 3> force, std::array<int, 3> torque)
{
  const auto found = std::ranges::find_if(_bodies, [&](const Body& b) { return b.body.get() == &body; });
  if (found == _bodies.end())
    throw std::invalid_argument("the rigid body with these loads is the master of no contact");
  found->force = force;
  found->torque = torque;
}

void ContactForces::set_step(double dt)
{
  if (!(dt > 0.0))
    throw std::invalid_argument("the step of contact stiffnesses is " + std::to_string(dt) + ": it must be positive");
  _step = dt;
  for (const auto& contact : _rigid_contacts)
    contact->set_step(dt);
}

void ContactForces::reset()
{
  _nodes.reset();
  _work = {};
  _obstacle_work = _half_obstacle_work = 0.0;
  _search_due = true;
}

void ContactForces::search(NodalFields& fields, double last_step)
{
  ++_num_searches;
  const auto& space = fields.space_map();
  std::vector<std::pair<std::int64_t, int>> found;
  const std::span<const std::int64_t> ghosts = space.ghosts();
  std::vector<std::int64_t> known(ghosts.begin(), ghosts.end());
  std::sort(known.begin(), known.end());
  const std::vector<double> u = fields.owned_values(fields.u), inverse = fields.owned_values(fields.inverse);
  std::vector<double> du = fields.owned_values(fields.v);
  for (double& value : du)
    value *= last_step > 0.0 ? last_step : _step;
  for (enforcement::NodalContact* contact : _directions)
  {
    contact->search(u, du);
    const auto nodes = contact->remote_nodes();
    for (std::size_t k = 0; k < nodes.size(); ++k)
      if (!std::binary_search(known.begin(), known.end(), nodes[k]))
        found.emplace_back(nodes[k], contact->remote_owners()[k]);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  fields.add_ghosts(found);
  std::vector<std::int32_t> nodes;
  for (enforcement::NodalContact* contact : _directions)
  {
    const auto needed = contact->required_nodes(*fields.halo);
    nodes.insert(nodes.end(), needed.begin(), needed.end());
  }
  fields.drop_ghosts(nodes);
  _nodes.assign_numbers(fields, std::move(nodes), has_corrections());
  for (enforcement::NodalContact* contact : _directions)
    contact->assign_numbers(*_nodes.halo(), _nodes.numbers(), _nodes.mass());
  _kinematic_step.assign_numbers(*fields.halo, *_nodes.halo(), _nodes.numbers());
  _tie_step.assign_numbers(*_nodes.halo(), inverse);
  _search_due = false;
}

void ContactForces::move_obstacles(const double* amplitudes, bool first)
{
  for (Pair& pair : _pairs)
  {
    if (pair.columns[0] < 0 && pair.rotation[0] < 0)
      continue;
    Obstacle& o = pair.obstacle;
    std::array<double, 3> displacement = o.displacement;
    for (int k = 0; k < 3 && pair.columns[0] >= 0; ++k)
      displacement[k] = amplitudes[pair.columns[k]];
    if (pair.rotation[0] >= 0)
    {
      const std::array<double, 3> angle{amplitudes[pair.rotation[0]], amplitudes[pair.rotation[1]],
                                        amplitudes[pair.rotation[2]]};
      const gap::Quaternion before = gap::quaternion_of(o.angle), after = gap::quaternion_of(angle);
      o.turn = first ? gap::Matrix3{} : gap::turn_of(gap::product(after, gap::inverse(before)));
      o.angle = angle;
    }
    o.increment_before = o.increment;
    for (int k = 0; k < 3; ++k)
      o.increment[k] = first ? 0.0 : displacement[k] - o.displacement[k];
    o.displacement = displacement;
    for (const auto& direction : pair.contact.directions())
      direction->set_obstacle(motion_of(pair));
  }
  if (!first || _bodies.empty())
    return;
  for (const Body& b : _bodies)
    b.body->begin();
  place_bodies();
}

gap::RigidMotion ContactForces::motion_of(const Pair& pair) const
{
  const Obstacle& o = pair.obstacle;
  if (pair.rotation[0] < 0)
    return {.displacement = o.displacement, .increment = o.increment};
  return {o.displacement, o.increment, true, gap::matrix_of(gap::quaternion_of(o.angle)), o.turn};
}

void ContactForces::place_bodies()
{
  for (const Pair& pair : _pairs)
    if (pair.body)
      for (const auto& direction : pair.contact.directions())
        direction->set_obstacle(pair.body->motion());
}

void ContactForces::apply_loads(const double* amplitudes)
{
  const auto load = [amplitudes](const std::array<int, 3>& columns)
  {
    std::array<double, 3> out{};
    for (int k = 0; k < 3; ++k)
      out[k] = columns[k] < 0 ? 0.0 : amplitudes[columns[k]];
    return out;
  };
  for (const Body& b : _bodies)
    b.body->set_loads(load(b.force), load(b.torque));
}

void ContactForces::advance_bodies(double dt, double h, bool starts)
{
  for (const Body& b : _bodies)
    b.body->advance(dt, h, starts);
  place_bodies();
}

void ContactForces::measure_bodies(double h, bool starts)
{
  for (const Body& b : _bodies)
    b.body->measure(h, starts);
}

/// Sums of forces on what a body touches, of all ranks; null for no body.
double* ContactForces::sums_of(const RigidBody* body)
{
  for (std::size_t i = 0; body && i < _bodies.size(); ++i)
    if (_bodies[i].body.get() == body)
      return _forces.data() + i * sums_of_body;
  return nullptr;
}

void ContactForces::sum_forces_on_bodies()
{
  if (_bodies.empty())
    return;
  const Stopwatch watch(_seconds);
  std::ranges::fill(_forces, 0.0);
  for (const Pair& pair : _pairs)
    if (pair.body)
    {
      const auto at = std::ranges::find(_bodies, pair.body, &Body::body) - _bodies.begin();
      double* const sums = _forces.data() + at * sums_of_body;
      const std::array<double, 3> force = pair.contact.force();
      const gap::Matrix3 moment = pair.contact.force_moment();
      for (std::size_t k = 0; k < 3; ++k)
        sums[k] += force[k];
      for (std::size_t k = 0; k < 9; ++k)
        sums[3 + k] += moment[k];
    }
  // MPI_Allreduce may round differently on different ranks, and the bodies must be the same on all.
  const int count = int(_forces.size());
  MPI_Allgather(_forces.data(), count, MPI_DOUBLE, _gathered.data(), count, MPI_DOUBLE, _comm);
  std::ranges::fill(_forces, 0.0);
  for (std::size_t k = 0; k < _gathered.size(); ++k)
    _forces[k % _forces.size()] += _gathered[k];
  // All ranks have these contacts, and compute the same.
  for (const auto& contact : _rigid_contacts)
  {
    contact->evaluate();
    double* const slave = sums_of(contact->slave().get());
    double* const master = sums_of(contact->master().get());
    for (std::size_t k = 0; k < 3; ++k)
    {
      slave[k] -= contact->force()[k];
      if (master)
        master[k] += contact->force()[k];
    }
    for (std::size_t k = 0; k < 9; ++k)
    {
      slave[3 + k] -= contact->moment_on_slave()[k];
      if (master)
        master[3 + k] += contact->moment_on_master()[k];
    }
  }
  for (std::size_t i = 0; i < _bodies.size(); ++i)
  {
    const double* const sums = _forces.data() + i * sums_of_body;
    std::array<double, 3> force;
    gap::Matrix3 moment;
    std::copy_n(sums, 3, force.begin());
    std::copy_n(sums + 3, 9, moment.begin());
    _bodies[i].body->set_contact_forces(force, moment);
  }
}

double ContactForces::half_obstacle_work() const
{
  double work = _half_obstacle_work;
  if (_first_rank)
    for (const Body& b : _bodies)
      work += b.body->half_external_work();
  return work;
}

double ContactForces::half_body_energy() const
{
  double energy = 0.0;
  if (_first_rank)
    for (const Body& b : _bodies)
      energy += b.body->energies().before;
  return energy;
}

void ContactForces::commit()
{
  _work.commit(0.0);
  for (const Body& b : _bodies)
    b.body->commit();
}

std::vector<RigidBodyState> ContactForces::bodies() const
{
  std::vector<RigidBodyState> out;
  for (const Body& b : _bodies)
    out.push_back(b.body->state());
  return out;
}

double ContactForces::largest_position() const
{
  double largest = 0.0;
  for (const enforcement::NodalContact* contact : _directions)
    largest = std::max(largest, contact->largest_position());
  return largest;
}

double ContactForces::half_work(const Pair& pair, const std::array<double, 3>& increment, const gap::Matrix3& turn,
                                int bs)
{
  const std::array<double, 3> force = pair.contact.force();
  double work = 0.0;
  for (int k = 0; k < bs; ++k)
    work += 0.5 * increment[k] * force[k];
  if (pair.rotation[0] >= 0)
  {
    const gap::Matrix3 moment = pair.contact.force_moment();
    for (int k = 0; k < 9; ++k)
      work += 0.5 * turn[k] * moment[k];
  }
  return work;
}

enforcement::NodalState ContactForces::state() const
{
  return {_nodes.u, _nodes.du, _nodes.inverse, _step, _nodes.range()};
}

void ContactForces::check_step() const
{
  if (!(empty() && _rigid_contacts.empty()) && !(_step > 0.0))
    throw std::invalid_argument("contact has no step to make its stiffness for: call set_contact_step first");
}

bool ContactForces::work_of_step(NodalFields& fields, double last_step)
{
  if (empty())
    return false;
  const Stopwatch watch(_seconds);
  if (!_nodes.corrected() || has_springs()) // else the nodes know what they were corrected to
    _work.done += 0.5 * _nodes.gather(fields, last_step, has_springs());
  for (const Pair& pair : _pairs)
    if (!pair.body)
    {
      // The arms of the forces before the step are turned by it.
      gap::Matrix3 ahead;
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
          ahead[3 * a + b] = -pair.obstacle.turn[3 * b + a];
      _obstacle_work += half_work(pair, pair.obstacle.increment, ahead, fields.bs);
    }
  _obstacle_work += _tie_step.support_work_after();
  _half_obstacle_work = _obstacle_work;
  if (!_search_due)
    return false;
  search(fields, last_step);
  _nodes.gather(fields, last_step, has_springs());
  return true;
}

void ContactForces::evaluate(NodalFields& fields)
{
  if (!has_springs())
    return;
  const Stopwatch watch(_seconds);
  for (enforcement::SpringForces* springs : _springs)
    springs->add_forces(state(), _nodes.springs);
  for (const Pair& pair : _pairs)
    if (!pair.corrects && !pair.body)
      _obstacle_work += half_work(pair, pair.obstacle.increment, pair.obstacle.turn, fields.bs);
  const ContactNodes::Products products = _nodes.add_springs(fields);
  _position = products.position;
  _work.before = 0.5 * products.work;
}

void ContactForces::predict_searches()
{
  _searches_due = 0.0;
  if (empty())
    return;
  const Stopwatch watch(_seconds);
  for (const enforcement::NodalContact* contact : _directions)
    _searches_due += !(contact->increment_used(state()) < 1.0);
}

void ContactForces::keep(const NodalFields& fields)
{
  if (has_corrections())
    _nodes.keep(fields);
}

void ContactForces::correct(NodalFields& fields, double dt, double last_step, double h, double release_share,
                            const Loads& loads, Sums& sums)
{
  fields.begin_exchange();
  fields.end_exchange(dt);
  const Stopwatch watch(_seconds);
  ContactNodes& n = _nodes;
  n.gather(fields, dt, false);
  for (std::size_t k = 0; k < n.u.size(); ++k)
  {
    n.du_before[k] = last_step * n.v_before[k];
    n.kinematic[k] = 0.0;
  }
  const enforcement::PredictedStep step{n.du, n.du_before, n.inverse, h * dt, dt, release_share};
  if (!_kinematic_step.empty())
    _kinematic_step.correct(step, n.u, n.kinematic);
  if (!_tie_step.empty())
  {
    _tie_step.correct(step, n.u, n.kinematic);
    _obstacle_work += _tie_step.support_work_before();
  }
  for (const Pair& pair : _pairs)
    if (pair.corrects)
      _obstacle_work += half_work(pair, pair.obstacle.increment_before, {}, fields.bs);
  n.put_displacements(fields);
  fields.update_ghost_velocities(dt); // so far they are those of the prediction
  const std::size_t bs = std::size_t(fields.bs), owned = n.halo()->num_owned();
  const CorrectionSums added = correct_velocities(owned * bs, h, n.inverse.data(), n.kinematic.data(),
                                                  n.v_before.data(), n.r_before.data(), n.v.data());
  sums.momentum += added.momentum;
  sums.speed += added.speed;
  sums.after += added.after;
  for (std::size_t k = 0; k < owned && loads.forces(); ++k)
    for (std::size_t c = 0; c < bs; ++c)
      if (const double load = loads.force(std::size_t(n.nodes()[k]) * fields.stride + c); load != 0.0)
        sums.load_after += load * h * n.inverse[k * bs + c] * n.kinematic[k * bs + c];
  n.finish_correction(fields, dt);
}

void ContactForces::add_energies(EnergySums& sums) const
{
  if (has_springs())
  {
    sums.work[std::size_t(WorkKind::contact)] += _work.value();
    sums.terms_position -= 0.5 * _position;
  }
  sums.load_work += _obstacle_work;
  if (_first_rank)
    for (const Body& b : _bodies)
    {
      const RigidBody::Energies& energies = b.body->energies();
      sums.kinetic += energies.kinetic;
      sums.speed += energies.after;
      sums.load_work += b.body->external_work();
    }
  if (_first_rank)
    for (const auto& contact : _rigid_contacts)
    {
      sums.stored += contact->stored();
      sums.friction += contact->dissipated();
    }
  sums.searches_due = _searches_due;
  for (const Pair& pair : _pairs)
  {
    const enforcement::ContactEnergy energy = pair.contact.energy();
    sums.stored += energy.stored;
    sums.friction += energy.friction;
    sums.normal += energy.normal;
    sums.passages += pair.contact.passage().node >= 0;
    for (const auto& direction : pair.contact.directions())
      sums.unsolved += double(direction->num_unsolved());
    if (pair.corrects)
    {
      sums.kinematic += energy.normal;
      sums.taken -= energy.normal + energy.later_normal;
      sums.recoverable += energy.recoverable;
    }
  }
}

void ContactForces::resultants(int bs, double* out) const
{
  for (const Pair& pair : _pairs)
  {
    const std::array<double, 3> force = pair.contact.force();
    std::copy_n(force.begin(), bs, out);
    out += 3;
  }
}

void ContactForces::update_gaps()
{
  for (enforcement::NodalContact* contact : _directions)
    contact->update_gaps(_nodes.u);
}

std::pair<int, enforcement::Passage> ContactForces::passage() const
{
  std::pair<int, enforcement::Passage> fastest{-1, {}};
  for (std::size_t k = 0; k < _pairs.size(); ++k)
    if (const enforcement::Passage p = _pairs[k].contact.passage(); p.facets > fastest.second.facets)
      fastest = {int(k), p};
  return fastest;
}

std::vector<ContactForces::Obstacle> ContactForces::obstacles() const
{
  std::vector<Obstacle> out;
  out.reserve(_pairs.size());
  for (const Pair& pair : _pairs)
    out.push_back(pair.obstacle);
  return out;
}

void ContactForces::forget_searches()
{
  for (enforcement::NodalContact* contact : _directions)
    contact->forget_search();
  _search_due = true;
}

void ContactForces::restore(ContactNodes::Forces forces, const Work& work, double position, double obstacle_work,
                            const std::vector<Obstacle>& obstacles, const std::vector<RigidBodyState>& bodies)
{
  for (std::size_t i = 0; i < _bodies.size(); ++i)
    _bodies[i].body->state() = bodies[i];
  if (empty())
    return;
  _nodes.restore(std::move(forces));
  _work = work;
  _position = position;
  _obstacle_work = obstacle_work;
  for (std::size_t k = 0; k < _pairs.size(); ++k)
  {
    _pairs[k].obstacle = obstacles[k];
    for (const auto& direction : _pairs[k].contact.directions())
      direction->restore_obstacle(motion_of(_pairs[k]));
  }
  place_bodies();
  for (enforcement::NodalContact* contact : _directions)
    contact->forget_search();
}
} // namespace dolfinx_impact::integrators
