// SPDX-License-Identifier: MIT
#include "RigidEquilibrium.h"
#include "../common/dolfinx_api.h"
#include "../common/text.h"
#include "../operators/body_size.h"
#include "../solve/dense.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace dolfinx_impact::problems
{
namespace
{
constexpr int most_evaluations = 60; ///< of Broyden's method in an increment
constexpr int most_approaches = 30;  ///< motions until a body touches
constexpr double first_part = 1e-6;  ///< of the bodies' size: the first motion, which tells a stiffness
constexpr double longest = 0.05;     ///< of the bodies' size: a motion at once

double norm(const std::vector<double>& values)
{
  double sum = 0.0;
  for (double value : values)
    sum += value * value;
  return std::sqrt(sum);
}
} // namespace

RigidEquilibrium::RigidEquilibrium(std::shared_ptr<const solve::EquilibriumProblem> problem,
                                   std::vector<StaticRigidBody> bodies, std::function<void(const std::string&)> log)
    : _problem(std::move(problem)), _bodies(std::move(bodies)), _log(std::move(log)),
      _size(operators::body_size(*_problem->space().mesh()))
{
  const int gdim = _problem->space().mesh()->geometry().dim();
  for (std::size_t b = 0; b < _bodies.size(); ++b)
  {
    if (_bodies[b].contacts.empty() || _bodies[b].force.size() != 3)
      throw std::invalid_argument("a rigid body of a static problem has contacts and a force of three components");
    for (std::size_t k : _bodies[b].contacts)
      if (!_problem->contacts.at(k)->displacement())
        throw std::invalid_argument(_problem->contacts[k]->name() + " has no rigid master");
    for (int c = 0; c < gdim; ++c)
      if (!_bodies[b].fixed[c])
        _free.push_back({b, c});
  }
}

solve::Increment RigidEquilibrium::fail(solve::Increment increment, std::string why) const
{
  increment.iterations = _iterations;
  return increment.failed(std::move(why));
}

RigidEquilibrium::Answer RigidEquilibrium::evaluate(const Solver& solver, std::span<const double> target,
                                                    const std::vector<double>& q)
{
  const auto u = common::array(*_problem->u->x());
  const std::vector<double> guess(u.begin(), u.end()); // the last solution; the contacts begin where the increment does
  std::ranges::copy(_start, u.begin());
  for (std::size_t k = 0; k < _saved.size(); ++k)
    _problem->contacts[k]->state().assign(_saved[k]);
  auto obstacles = _obstacles;
  for (std::size_t i = 0; i < _free.size(); ++i)
    for (std::size_t k : _bodies[_free[i].body].contacts)
      (*obstacles[k])[_free[i].component] = q[i];
  for (std::size_t k = 0; k < _saved.size(); ++k)
    _problem->contacts[k]->begin_step(_start, obstacles[k], target);
  std::ranges::copy(guess, u.begin());
  Answer out{solver(target), {}, 0.0, true};
  _iterations += out.increment.iterations;
  if (!out.increment.fault.empty())
  {
    std::ranges::copy(guess, u.begin());
    return out;
  }
  const int bs = _problem->space().dofmap()->index_map_bs();
  std::vector<double> forces(3 * _bodies.size(), 0.0); // of contact, on the bodies
  for (std::size_t b = 0; b < _bodies.size(); ++b)
    for (std::size_t k : _bodies[b].contacts)
    {
      const std::vector<double> nodal = _problem->contacts[k]->contact_forces();
      for (std::size_t i = 0; i < nodal.size(); ++i)
        forces[3 * b + i % bs] -= nodal[i];
    }
  MPI_Allreduce(MPI_IN_PLACE, forces.data(), int(forces.size()), MPI_DOUBLE, MPI_SUM, _problem->comm());
  for (const Free& f : _free)
  {
    const double external = _bodies[f.body].force[f.component], contact = forces[3 * f.body + f.component];
    out.missing.push_back(external + contact);
    out.size = std::max({out.size, std::abs(external), std::abs(contact)});
    const double* const all = forces.data() + 3 * f.body;
    out.touches = out.touches && std::any_of(all, all + 3, [](double value) { return value != 0.0; });
  }
  return out;
}

bool RigidEquilibrium::approach(const Solver& solver, std::span<const double> target, std::vector<double>& q,
                                Answer& now)
{
  for (int k = 0; k < most_approaches && !now.touches; ++k)
  {
    // All bodies move along the forces on them, by the smallest gap and a little more.
    double gap = std::numeric_limits<double>::infinity();
    for (const StaticRigidBody& body : _bodies)
      for (std::size_t c : body.contacts)
        gap = std::min(gap, _problem->contacts[c]->smallest_gap());
    if (!std::isfinite(gap))
      return false;
    const double force = norm(now.missing);
    if (force == 0.0)
      return false;
    const double way = std::max(gap, 0.0) * (1.0 + 1e-9) + first_part * _size * std::pow(2.0, k);
    for (std::size_t i = 0; i < q.size(); ++i)
      q[i] += way * now.missing[i] / force;
    now = evaluate(solver, target, q);
    if (!now.increment.fault.empty())
      return false;
  }
  return now.touches;
}

solve::Increment RigidEquilibrium::run(const Solver& solver, std::span<const double> target)
{
  const std::span<const double> u = _problem->u->x()->array();
  _start.assign(u.begin(), u.end());
  _saved.clear();
  _obstacles.clear();
  _iterations = 0;
  for (const auto& contact : _problem->contacts)
  {
    _saved.push_back(contact->state().copy());
    _obstacles.push_back(contact->displacement());
  }
  const std::size_t n = _free.size();
  std::vector<double> q;
  for (const Free& f : _free)
    q.push_back((*_obstacles[_bodies[f.body].contacts.front()])[f.component]);
  Answer now = evaluate(solver, target, q);
  if (!now.increment.fault.empty())
    return fail(now.increment, now.increment.fault);
  const auto balanced = [](const Answer& answer) { return norm(answer.missing) <= tolerance * answer.size; };
  if (!balanced(now) && !now.touches)
  {
    _stiffness.clear();
    if (!approach(solver, target, q, now))
      return fail(now.increment, now.increment.fault.empty()
                                     ? "a rigid body finds nothing that bears it along the force on it"
                                     : now.increment.fault);
  }
  if (!balanced(now) && _stiffness.size() != n * n)
  {
    _stiffness.assign(n * n, 0.0);
    for (std::size_t j = 0; j < n; ++j)
    {
      std::vector<double> there = q;
      const double way = (now.missing[j] < 0.0 ? -1.0 : 1.0) * first_part * _size;
      there[j] += way;
      const Answer moved = evaluate(solver, target, there);
      if (!moved.increment.fault.empty())
        return fail(moved.increment, moved.increment.fault);
      for (std::size_t i = 0; i < n; ++i)
        _stiffness[i * n + j] = (moved.missing[i] - now.missing[i]) / way;
    }
    now = evaluate(solver, target, q);
  }
  double largest = longest * _size;
  for (int k = 0; k < most_evaluations && now.increment.fault.empty() && !balanced(now); ++k)
  {
    std::vector<double> transposed(n * n), right(n);
    double scale = 0.0;
    for (std::size_t i = 0; i < n; ++i)
    {
      right[i] = -now.missing[i];
      for (std::size_t j = 0; j < n; ++j)
      {
        transposed[j * n + i] = _stiffness[i * n + j];
        scale = std::max(scale, std::abs(_stiffness[i * n + j]));
      }
    }
    for (std::size_t j = 0; j < n; ++j)
    {
      double row = 0.0;
      for (std::size_t i = 0; i < n; ++i)
        row = std::max(row, std::abs(_stiffness[i * n + j]));
      if (!(row > 1e-12 * scale))
        return fail(now.increment, std::string("nothing holds a rigid body along ") + "xyz"[_free[j].component] +
                                       ": fix that component");
    }
    const auto step = solve::solve_dense(transposed, right);
    if (!step)
      return fail(now.increment, "nothing holds a rigid body in some direction: fix components");
    std::vector<double> way = *step;
    const double length = norm(way);
    if (!std::isfinite(length))
      return fail(now.increment, "nothing holds a rigid body in some direction: fix components");
    if (length > largest)
      for (double& value : way)
        value *= largest / length;
    std::vector<double> there = q;
    for (std::size_t i = 0; i < n; ++i)
      there[i] += way[i];
    Answer next = evaluate(solver, target, there);
    if (!next.increment.fault.empty()) // too far at once for the bodies
    {
      largest = 0.25 * norm(way);
      now = evaluate(solver, target, q);
      continue;
    }
    // Broyden (1965): the stiffness explains the last motion.
    double square = 0.0;
    for (double value : way)
      square += value * value;
    for (std::size_t i = 0; i < n; ++i)
    {
      double lacks = next.missing[i] - now.missing[i];
      for (std::size_t j = 0; j < n; ++j)
        lacks -= _stiffness[i * n + j] * way[j];
      for (std::size_t j = 0; j < n; ++j)
        _stiffness[i * n + j] += lacks * way[j] / square;
    }
    const double before = norm(now.missing), after = norm(next.missing);
    if (_log)
      _log("  rigid bodies: equilibrium lacks " + common::text("%.3e", after) + ", relative " +
           common::text("%.2e", next.size > 0.0 ? after / next.size : 0.0));
    if (after < before)
    {
      q = std::move(there);
      now = std::move(next);
      largest = longest * _size;
    }
    else
    {
      largest = 0.5 * norm(way);
      now = evaluate(solver, target, q);
    }
  }
  if (!now.increment.fault.empty())
    return fail(now.increment, now.increment.fault);
  now.increment.iterations = _iterations;
  if (!balanced(now))
    return fail(now.increment, "the rigid bodies found no equilibrium: it lacks a force of " +
                                   common::text("%.3e", norm(now.missing)) + ", relative " +
                                   common::text("%.1e", norm(now.missing) / now.size));
  return now.increment;
}
} // namespace dolfinx_impact::problems
