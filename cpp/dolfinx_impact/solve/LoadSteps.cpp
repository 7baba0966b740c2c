// SPDX-License-Identifier: MIT
#include "LoadSteps.h"
#include "../common/dolfinx_api.h"
#include "../common/text.h"
#include "../gap/rotation.h"
#include "bring_together.h"
#include "equilibrium.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

using dolfinx_impact::common::joined;

namespace dolfinx_impact::solve
{
void LoadStepReport::add(const Increment& increment, double fraction)
{
  iterations.push_back(increment.iterations);
  residual_norms.push_back(increment.residual_norms);
  active_set_sizes.push_back(increment.active_set_sizes);
  contact_changes.push_back(increment.changes);
  unsettled.push_back(increment.unsettled);
  fractions.push_back(fraction);
}

LoadSteps::LoadSteps(std::shared_ptr<const EquilibriumProblem> problem, std::vector<double> target,
                     std::vector<Ramp> loads, std::vector<Displacement> obstacles, LoadStepEvents events)
    : _problem(std::move(problem)), _target(std::move(target)), _loads(std::move(loads)),
      _obstacles(std::move(obstacles)), _events(std::move(events))
{
  const std::span<const double> u = _problem->u->x()->array();
  _start.assign(u.begin(), u.end());
  if (_target.size() != _start.size() || _obstacles.size() != _problem->contacts.size())
    throw std::invalid_argument("load steps: prescribed values or obstacles of another number");
  for (const Ramp& load : _loads)
    _load_ends.emplace_back(load.value.begin(), load.value.end());
  for (const auto& contact : _problem->contacts)
    _obstacle_starts.push_back(contact->displacement());
  _angles.resize(_obstacles.size());
}

void LoadSteps::log(const std::string& text) const
{
  if (_events.log)
    _events.log(text);
}

std::vector<double> LoadSteps::target(double fraction) const
{
  std::vector<double> out(_target);
  if (fraction != 1.0)
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = _start[i] + fraction * (_target[i] - _start[i]);
  return out;
}

/// Set loads and obstacles to a fraction of the way, and let the contacts begin there. Collective.
void LoadSteps::begin(double fraction)
{
  for (std::size_t k = 0; k < _loads.size(); ++k)
    for (std::size_t i = 0; i < _loads[k].value.size(); ++i)
      _loads[k].value[i] = _loads[k].reached[i] + fraction * (_load_ends[k][i] - _loads[k].reached[i]);
  const std::vector<double> prescribed = target(fraction);
  for (std::size_t k = 0; k < _problem->contacts.size(); ++k)
  {
    Displacement there;
    if (_obstacles[k])
    {
      there.emplace();
      for (int c = 0; c < 3; ++c)
        (*there)[c] = (*_obstacle_starts[k])[c] + fraction * ((*_obstacles[k])[c] - (*_obstacle_starts[k])[c]);
    }
    if (const std::span<const double> angle = _angles[k]; !angle.empty())
      _problem->contacts[k]->set_rotation(gap::matrix_of(gap::quaternion_of({angle[0], angle[1], angle[2]})));
    _problem->contacts[k]->begin_step(_problem->u->x()->array(), there, prescribed);
  }
}

/// Displacements and contacts are those of the start of the increment again.
void LoadSteps::go_back(std::span<const double> u, const std::vector<state::State>& contacts)
{
  std::ranges::copy(u, common::array(*_problem->u->x()).begin());
  for (std::size_t k = 0; k < contacts.size(); ++k)
    _problem->contacts[k]->state().assign(contacts[k]);
}

/// The loads at a fraction are the start of the next solve, and have the user's values again.
void LoadSteps::finish(double fraction)
{
  for (std::size_t k = 0; k < _loads.size(); ++k)
    for (std::size_t i = 0; i < _loads[k].value.size(); ++i)
    {
      _loads[k].reached[i] += fraction * (_load_ends[k][i] - _loads[k].reached[i]);
      _loads[k].value[i] = _load_ends[k][i];
    }
}

LoadStepReport LoadSteps::run(const Solver& solver, LoadStepOptions options)
{
  LoadStepReport report;
  double width = 1.0 / options.steps, done = 0.0;
  int halved = 0;
  std::vector<std::int8_t> closed;
  for (const auto& contact : _problem->contacts)
    closed.push_back(contact->num_active() > 0);
  std::vector<double> good(_start);                                     // of the last converged increment
  std::vector<double> from(_start);                                     // where the increment begins
  bool brings = options.brings_together && !_problem->contacts.empty(); // in this increment
  while (done < 1.0 - 1e-12)
  {
    double fraction = std::min(done + width, 1.0);
    if (fraction <= done)
    {
      finish(done);
      throw std::runtime_error("increments of " + common::text("%.1e", width) +
                               " of the way are round-off: ask for fewer cut_backs");
    }
    if (fraction > 1.0 - 1e-9)
      fraction = 1.0;
    const int number = int(report.iterations.size()) + 1;
    log("increment " + std::to_string(number) + ": to " + common::text("%.4f", fraction) + " of the way");
    if (_events.begins)
      _events.begins(number, done, fraction);
    std::vector<state::State> saved;
    for (const auto& contact : _problem->contacts)
      saved.push_back(contact->state().copy());
    Increment increment;
    try
    {
      begin(fraction);
      increment = solver(target(fraction));
    }
    catch (...) // an interrupt, a user's function: return to the last converged state
    {
      go_back(good, saved);
      finish(done);
      throw;
    }
    if (increment.fault.empty())
    {
      std::vector<std::string> overlaps;
      for (const auto& contact : _problem->contacts)
        overlaps.push_back(contact->prescribed_overlap());
      if (const std::string text = joined(overlaps); !text.empty())
        increment.failed(text, true);
    }
    if (increment.fault.empty())
    {
      _problem->body->accept_step();
      for (std::size_t k = 0; k < closed.size(); ++k)
        closed[k] = closed[k] || (k < increment.closed.size() && increment.closed[k]);
      for (const auto& contact : _problem->contacts)
        contact->accept_step();
      for (std::size_t k = 0; k < closed.size(); ++k)
        closed[k] = closed[k] || _problem->contacts[k]->num_active() > 0;
      report.add(increment, fraction);
      const std::span<const double> u = _problem->u->x()->array();
      good.assign(u.begin(), u.end());
      from = good;
      brings = options.brings_together && !_problem->contacts.empty();
      done = fraction;
      try
      {
        if (_events.accepted)
          _events.accepted(fraction);
      }
      catch (...)
      {
        finish(done);
        throw;
      }
      continue;
    }
    go_back(from, saved);
    std::string apart;
    if (brings)
    {
      brings = false;
      const Approach approach = bring_together(*_problem);
      if (!approach.moved.empty())
      {
        log("  " + approach.moved);
        report.brought_together.push_back(approach.moved);
        const std::span<const double> u = _problem->u->x()->array();
        from.assign(u.begin(), u.end());
        continue;
      }
      if (!approach.obstacle.empty())
        apart = " (bodies are not brought together: " + approach.obstacle + ")";
    }
    if (increment.hopeless || halved == options.cut_backs)
      go_back(good, saved);
    if (increment.hopeless)
    {
      finish(done);
      throw std::runtime_error(increment.fault + apart);
    }
    if (halved == options.cut_backs)
    {
      finish(done);
      const std::string where = done > 0.0 ? " (reached " + common::text("%.4f", done) + " of the way)" : "";
      const std::string end = increment.fault.ends_with("?") && where.empty() ? "" : ".";
      throw std::runtime_error(increment.fault + apart + where + end +
                               (increment.advice.empty() ? "" : " " + increment.advice));
    }
    ++halved;
    width /= 2;
    ++report.cut_backs;
    report.rejected_iterations.push_back(increment.iterations);
    log("  cut back to increments of " + common::text("%.3e", width) + ": " + increment.fault);
  }
  finish(1.0);
  report.lost = open_contacts(*_problem, closed);
  return report;
}
} // namespace dolfinx_impact::solve
