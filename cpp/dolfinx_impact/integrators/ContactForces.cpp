// SPDX-License-Identifier: MIT
#include "ContactForces.h"
#include "../common/Stopwatch.h"
#include <algorithm>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::integrators
{
using common::Stopwatch;

void ContactForces::add(enforcement::NodalPair pair, std::array<int, 3> columns)
{
  std::vector<enforcement::SpringForces*> springs;
  std::vector<enforcement::KinematicContact*> kinematic;
  for (const auto& direction : pair.directions())
    if (auto* const force = dynamic_cast<enforcement::SpringForces*>(direction.get()))
      springs.push_back(force);
    else if (auto* const correction = dynamic_cast<enforcement::KinematicContact*>(direction.get()))
      kinematic.push_back(correction);
    else
      throw std::invalid_argument("a contact has to act: by SpringForces or as a KinematicContact");
  if (!springs.empty() && !kinematic.empty())
    throw std::invalid_argument("one direction of a pair acts by SpringForces and the other as a KinematicContact");
  for (const auto& direction : pair.directions())
    _directions.push_back(direction.get());
  _springs.insert(_springs.end(), springs.begin(), springs.end());
  for (enforcement::KinematicContact* contact : kinematic)
    _kinematic_step.add(contact);
  _pairs.push_back({std::move(pair), !kinematic.empty(), columns, {}});
  _search_due = true;
}

void ContactForces::set_step(double dt)
{
  if (!(dt > 0.0))
    throw std::invalid_argument("the step of contact stiffnesses is " + std::to_string(dt) + ": it must be positive");
  _step = dt;
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
  std::vector<double> du(fields.v.begin(), fields.v.begin() + fields.owned);
  for (double& value : du)
    value *= last_step > 0.0 ? last_step : _step;
  for (enforcement::NodalContact* contact : _directions)
  {
    contact->search({fields.u.data(), fields.owned}, du);
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
  _nodes.assign_numbers(fields, std::move(nodes), has_kinematic());
  for (enforcement::NodalContact* contact : _directions)
    contact->assign_numbers(*_nodes.halo(), _nodes.numbers(), _nodes.mass());
  _kinematic_step.assign_numbers(*fields.halo, *_nodes.halo(), _nodes.numbers());
  _search_due = false;
}

void ContactForces::move_obstacles(const double* amplitudes, bool first)
{
  for (Pair& pair : _pairs)
  {
    if (pair.columns[0] < 0)
      continue;
    Obstacle& o = pair.obstacle;
    std::array<double, 3> displacement{};
    for (int k = 0; k < 3; ++k)
      displacement[k] = amplitudes[pair.columns[k]];
    o.increment_before = o.increment;
    for (int k = 0; k < 3; ++k)
      o.increment[k] = first ? 0.0 : displacement[k] - o.displacement[k];
    o.displacement = displacement;
    for (const auto& direction : pair.contact.directions())
      direction->set_obstacle(o.displacement, o.increment);
  }
}

double ContactForces::largest_position() const
{
  double largest = 0.0;
  for (const enforcement::NodalContact* contact : _directions)
    largest = std::max(largest, contact->largest_position());
  return largest;
}

double ContactForces::half_work(const Pair& pair, const std::array<double, 3>& increment, int bs)
{
  const std::array<double, 3> force = pair.contact.force();
  double work = 0.0;
  for (int k = 0; k < bs; ++k)
    work += 0.5 * increment[k] * force[k];
  return work;
}

enforcement::NodalState ContactForces::state() const
{
  return {_nodes.u, _nodes.du, _nodes.inverse, _step};
}

void ContactForces::check_step() const
{
  if (!empty() && !(_step > 0.0))
    throw std::invalid_argument("contact has no step to make its stiffness for: call set_contact_step first");
}

bool ContactForces::work_of_step(NodalFields& fields, double last_step)
{
  if (empty())
    return false;
  const Stopwatch watch(_seconds);
  _work.done += 0.5 * _nodes.gather(fields, last_step, has_springs());
  for (const Pair& pair : _pairs)
    _obstacle_work += half_work(pair, pair.obstacle.increment, fields.bs);
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
    if (!pair.kinematic)
      _obstacle_work += half_work(pair, pair.obstacle.increment, fields.bs);
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
  if (has_kinematic())
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
  _kinematic_step.correct({n.du, n.du_before, n.inverse, h * dt, dt, release_share}, n.u, n.kinematic);
  for (const Pair& pair : _pairs)
    if (pair.kinematic)
      _obstacle_work += half_work(pair, pair.obstacle.increment_before, fields.bs);
  const int bs = fields.bs;
  for (std::size_t k = 0; k < n.size(); ++k)
    for (int c = 0; c < bs; ++c)
      fields.u[std::size_t(n.nodes()[k]) * bs + c] = n.u[k * bs + c];
  fields.update_ghost_velocities(dt); // so far they are those of the prediction
  const std::size_t owned = n.halo()->num_owned();
  for (std::size_t k = 0; k < owned; ++k)
    for (int c = 0; c < bs; ++c)
    {
      const std::size_t j = k * bs + c, i = std::size_t(n.nodes()[k]) * bs + c;
      if (n.inverse[j] == 0.0)
        continue;
      const double m = 1.0 / n.inverse[j], predicted = n.v[j];
      const double v = predicted + h * n.inverse[j] * n.kinematic[j];
      fields.v[i] = v;
      sums.momentum += m * n.v_before[j] * (v - predicted);
      sums.speed += m * (v * v - predicted * predicted);
      sums.after += n.r_before[j] * (v - predicted);
      sums.load_after += loads.force(i) * (v - predicted);
    }
}

void ContactForces::add_energies(EnergySums& sums) const
{
  if (has_springs())
  {
    sums.work[std::size_t(WorkKind::contact)] += _work.value();
    sums.terms_position -= 0.5 * _position;
  }
  sums.load_work += _obstacle_work;
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
    if (pair.kinematic)
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
                            const std::vector<Obstacle>& obstacles)
{
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
      direction->restore_obstacle(obstacles[k].displacement, obstacles[k].increment);
  }
  for (enforcement::NodalContact* contact : _directions)
    contact->forget_search();
}
} // namespace dolfinx_impact::integrators
