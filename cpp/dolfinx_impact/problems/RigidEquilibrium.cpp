// SPDX-License-Identifier: MIT
#include "RigidEquilibrium.h"
#include "../common/dolfinx_api.h"
#include "../common/text.h"
#include "../operators/body_size.h"
#include "../solve/dense.h"
#include "../solve/force_on_master.h"
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
/// Least resistance to an unknown, of the largest, that counts: differences over `first_part` are rounded to 1e-10.
constexpr double held = 1e-8;
constexpr double shortest = 1e-9; ///< of the bodies' size: motions that are tried

double norm(const std::vector<double>& values)
{
  double sum = 0.0;
  for (double value : values)
    sum += value * value;
  return std::sqrt(sum);
}
} // namespace

RigidEquilibrium::RigidEquilibrium(std::shared_ptr<const solve::EquilibriumProblem> problem,
                                   std::vector<RigidMember> bodies, std::function<void(const std::string&)> log)
    : _problem(std::move(problem)), _bodies(std::move(bodies)), _first{0}, _log(std::move(log)),
      _size(operators::body_size(*_problem->space().mesh()))
{
  for (const RigidMember& body : _bodies)
  {
    if (!body.equations || body.contacts.empty())
      throw std::invalid_argument("a rigid body of a problem is the master of a contact");
    for (std::size_t k : body.contacts)
    {
      const auto& contact = *_problem->contacts.at(k);
      if (!contact.displacement())
        throw std::invalid_argument(contact.name() + " has no rigid master");
      if (body.equations->turns() && !contact.rotation())
        throw std::invalid_argument(contact.name() + ": the rigid body turns, but the contact's master cannot");
    }
    _first.push_back(_first.back() + body.equations->size());
    _needs_contact = _needs_contact || body.equations->needs_contact();
  }
  if (!_needs_contact) // inertia alone, until something touches
    _stiffness.assign(_first.back() * _first.back(), 0.0);
}

std::string RigidEquilibrium::component(std::size_t unknown) const
{
  const std::size_t b = std::ranges::upper_bound(_first, unknown) - _first.begin() - 1;
  return _bodies[b].equations->component(unknown - _first[b]);
}

std::vector<double> RigidEquilibrium::derivatives() const
{
  std::vector<double> out;
  for (const RigidMember& body : _bodies)
  {
    const std::vector<double> own = body.equations->derivatives();
    out.insert(out.end(), own.begin(), own.end());
  }
  return out;
}

std::vector<double> RigidEquilibrium::solution(std::size_t body) const
{
  return {_solution.begin() + std::ptrdiff_t(_first.at(body)), _solution.begin() + std::ptrdiff_t(_first.at(body + 1))};
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
  auto rotations = _rotations;
  const auto unknowns = [&](std::size_t b) { return std::span(q).subspan(_first[b], _first[b + 1] - _first[b]); };
  for (std::size_t b = 0; b < _bodies.size(); ++b)
  {
    const solve::RigidPlace place = _bodies[b].equations->place(unknowns(b));
    for (std::size_t k : _bodies[b].contacts)
    {
      obstacles[k] = place.displacement;
      rotations[k] = place.rotation;
    }
  }
  for (std::size_t k = 0; k < _saved.size(); ++k)
  {
    if (_rotations[k])
      _problem->contacts[k]->set_rotation(*rotations[k]);
    _problem->contacts[k]->begin_step(_start, obstacles[k], target);
  }
  std::ranges::copy(guess, u.begin());
  Answer out{solver(target), {}, 0.0, 0.0, true};
  _iterations += out.increment.iterations;
  _most_iterations = std::max(_most_iterations, out.increment.iterations);
  if (!out.increment.fault.empty())
  {
    std::ranges::copy(guess, u.begin());
    return out;
  }
  for (std::size_t b = 0; b < _bodies.size(); ++b)
  {
    const solve::RigidEquations& equations = *_bodies[b].equations;
    gap::Vector3 centre = equations.centre();
    for (int c = 0; c < 3; ++c)
      centre[c] += (*obstacles[_bodies[b].contacts.front()])[c];
    const auto [force, torque] = solve::force_on_master(*_problem, _bodies[b].contacts, centre);
    const solve::RigidBalance balance = equations.balance(unknowns(b), force, torque);
    out.missing.insert(out.missing.end(), balance.missing.begin(), balance.missing.end());
    out.size = std::max(out.size, balance.size);
    out.round_off = std::max(out.round_off, balance.round_off);
    const bool free = equations.size() > 0 && equations.needs_contact();
    out.touches = out.touches && (!free || std::ranges::any_of(force, [](double value) { return value != 0.0; }));
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
    for (const RigidMember& body : _bodies)
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
  _rotations.clear();
  _iterations = _most_iterations = 0;
  for (const auto& contact : _problem->contacts)
  {
    _saved.push_back(contact->state().copy());
    _obstacles.push_back(contact->displacement());
    _rotations.push_back(contact->rotation());
  }
  const std::size_t n = _first.back();
  std::vector<double> q;
  for (const RigidMember& body : _bodies)
  {
    const std::vector<double> guess = body.equations->first_guess();
    q.insert(q.end(), guess.begin(), guess.end());
  }
  Answer now = evaluate(solver, target, q);
  if (!now.increment.fault.empty())
    return fail(now.increment, now.increment.fault);
  const auto balanced = [](const Answer& answer)
  { return norm(answer.missing) <= std::max(tolerance * answer.size, answer.round_off); };
  if (!balanced(now) && !now.touches)
  {
    _stiffness.clear();
    if (!approach(solver, target, q, now))
      return fail(now.increment, now.increment.fault.empty()
                                     ? "a rigid body finds nothing that bears it along the force on it"
                                     : now.increment.fault);
  }
  const std::vector<double> own = derivatives();
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
        _stiffness[i * n + j] = (moved.missing[i] - now.missing[i]) / way - (i == j ? own[i] : 0.0);
    }
    // What nothing resists yet, as friction does not before the body is pressed, is given the largest resistance: the
    // iteration learns what there is, and says so if there is none.
    double scale = 0.0;
    for (double value : _stiffness)
      scale = std::max(scale, std::abs(value));
    _unheld.assign(n, 0);
    for (std::size_t j = 0; j < n; ++j)
    {
      double resistance = 0.0;
      for (std::size_t i = 0; i < n; ++i)
        resistance = std::max(resistance, std::abs(_stiffness[i * n + j]));
      if (!(resistance > held * scale))
      {
        _unheld[j] = 1;
        _stiffness[j * n + j] = -scale;
      }
    }
    now = evaluate(solver, target, q);
  }
  double largest = longest * _size;
  for (int k = 0; k < most_evaluations && largest > shortest * _size && now.increment.fault.empty() && !balanced(now);
       ++k)
  {
    std::vector<double> transposed(n * n), right(n);
    for (std::size_t i = 0; i < n; ++i)
    {
      right[i] = -now.missing[i];
      for (std::size_t j = 0; j < n; ++j)
      {
        transposed[j * n + i] = _stiffness[i * n + j] + (i == j ? own[i] : 0.0);
      }
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
      double lacks = next.missing[i] - now.missing[i] - own[i] * way[i];
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
  _solution = q;
  if (balanced(now))
    return now.increment;
  const auto worst = std::ranges::max_element(now.missing, {}, [](double value) { return std::abs(value); });
  if (const std::size_t at = worst - now.missing.begin(); at < _unheld.size() && _unheld[at])
    return fail(now.increment, "nothing holds a rigid body along " + component(at) +
                                   ", where a force or a torque acts: fix that component");
  return fail(now.increment, "the rigid bodies found no equilibrium: it lacks a force of " +
                                 common::text("%.3e", norm(now.missing)) + ", relative " +
                                 common::text("%.1e", norm(now.missing) / now.size));
}
} // namespace dolfinx_impact::problems
