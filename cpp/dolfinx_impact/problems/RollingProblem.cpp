// SPDX-License-Identifier: MIT
#include "RollingProblem.h"
#include "../common/OnAllRanks.h"
#include "../common/gather.h"
#include "../common/text.h"
#include "../common/vectors.h"
#include "../enforcement/penalty/QuadraturePenalty.h"
#include "../rolling/critical_speed.h"
#include "../solve/unconstrained_modes.h"
#include "OneCall.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dolfinx_impact::problems
{
namespace
{
/// Of the rates: so far beyond them a linear body's critical speed is looked for. It spares the factors that each point
/// of a rising creep curve would need.
constexpr double ahead = 1.1;

std::vector<double> moduli(std::vector<double> values)
{
  for (double& value : values)
    value = std::abs(value);
  return values;
}

std::vector<double> scaled(std::vector<double> values, double factor)
{
  for (double& value : values)
    value *= factor;
  return values;
}

template <typename T>
void append(std::vector<T>& to, const std::vector<T>& from)
{
  to.insert(to.end(), from.begin(), from.end());
}
} // namespace

RollingProblem::RollingProblem(std::shared_ptr<StaticProblem> equilibrium, std::shared_ptr<rolling::Flow> flow)
    : _equilibrium(std::move(equilibrium)), _flow(std::move(flow))
{
  const solve::EquilibriumProblem& p = bodies();
  for (const auto& contact : p.contacts)
    if (auto* rolling = dynamic_cast<rolling::RollingContact*>(contact.get()))
      _contacts.push_back(rolling);
    else if (const auto* penalty = dynamic_cast<const enforcement::QuadraturePenalty*>(contact.get());
             contact->has_friction() ||
             (penalty && penalty->options().law && penalty->options().law->make_history(0).variables.size() > 0))
      throw std::invalid_argument(contact->name() +
                                  ": a law with slip or internal variables needs points that stay with the material, "
                                  "which flows through the mesh of a rolling problem: take Lagrange, with a law of "
                                  "friction, or a law of the gap alone");
  for (const rolling::RollingContact* contact : _contacts)
    if (&contact->flow() != _flow.get())
      throw std::invalid_argument(contact->name() + " has another flow than the problem");
  if (!_contacts.empty() && _contacts.size() != p.contacts.size())
    throw std::invalid_argument("with friction against a slip velocity, all contacts are RollingContacts");
  for (const solve::Ramp& ramp : _flow->ramps())
    _equilibrium->add_load(ramp);
  _reached.resize(_contacts.size(), std::vector<double>(3, 0.0));
  for (std::size_t k = 0; k < _contacts.size(); ++k)
    if (_contacts[k]->geometry().obstacle())
      _equilibrium->add_load({_contacts[k]->obstacle_velocity(), _reached[k]});
  if (!_contacts.empty())
    _reduced.emplace(p.space(), std::vector<std::int8_t>(p.fixed.begin(), p.fixed.begin() + p.num_owned()));
}

RollingReport RollingProblem::solve(const SolveOptions& options, const SolveEvents& events,
                                    std::optional<double> torque)
{
  const OneCall call(_solving, "solve");
  const solve::EquilibriumProblem& p = bodies();
  if (torque && (_contacts.empty() || !_flow->first_spin()))
    throw std::invalid_argument("a torque needs contact with friction and a body that spins");
  for (rolling::RollingContact* c : _contacts)
    c->check_directions(p.u->x()->array());
  const state::State before = state().copy();
  RollingReport report;
  if (_contacts.empty())
    report.steps = _equilibrium->solve(options, events);
  else
    solve_with_friction(report, options, events, torque);
  if (p.body->properties().inelastic)
    return report; // tangents of materials that flow plastically are those of an increment
  const std::string fault = beyond_critical_speed();
  if (fault.empty())
    return report;
  if (std::ranges::any_of(p.contacts, [](const auto& contact) { return contact->has_multipliers(); }))
  {
    report.warning = "without what the contacts hold, " + fault;
    return report;
  }
  state().assign(before);
  _equilibrium->resume();
  throw common::Failure(fault + ". Hold the body, or let it turn slower");
}

void RollingProblem::solve_with_friction(RollingReport& report, const SolveOptions& options, const SolveEvents& events,
                                         std::optional<double> torque)
{
  solve::NewtonOptions newton;
  newton.rtol = options.rtol;
  newton.atol = options.atol;
  newton.max_iterations = options.max_iterations;
  rolling::RollingNewton solver(_equilibrium->equilibrium(), newton, *_reduced, events.newton);
  SolveOptions steps = options;
  steps.cut_backs = options.cut_backs.value_or(8);
  report.steps =
      _equilibrium->solve([&](std::span<const double> goal) { return solver.run(goal); }, steps, events.steps);
  if (torque)
    find_spin(solver, report.steps, options, events, *torque);
  report.steps.seconds = solver.seconds();
}

/// Solve for the spin of the first body, from the present state. Collective.
void RollingProblem::find_spin(rolling::RollingNewton& newton, solve::LoadStepReport& report,
                               const SolveOptions& options, const SolveEvents& events, double torque)
{
  const rolling::Motion& motion = *_flow->first_spin();
  const rolling::TorqueControl control(_equilibrium->equilibrium(), *_flow, motion, torque);
  const double before = control.omega();
  double found = before;
  newton.control = &control;
  SolveOptions one = options;
  one.steps = 1;
  one.cut_backs = 0;
  try
  {
    const auto run = [&](std::span<const double> goal)
    {
      solve::Increment increment = newton.run(goal);
      found = control.omega(); // a load step ends with the rates that it began with
      return increment;
    };
    const solve::LoadStepReport added = _equilibrium->solve(run, one, events.steps);
    append(report.iterations, added.iterations);
    append(report.residual_norms, added.residual_norms);
    append(report.active_set_sizes, added.active_set_sizes);
    append(report.contact_changes, added.contact_changes);
    append(report.unsettled, added.unsettled);
    append(report.fractions, added.fractions);
  }
  catch (...)
  {
    control.set_omega(before);
    _flow->mark_reached();
    newton.control = nullptr;
    throw;
  }
  control.set_omega(found);
  _flow->mark_reached();
  newton.control = nullptr;
}

/// Why the present state is not stable; empty if it is. Collective.
std::string RollingProblem::beyond_critical_speed()
{
  const solve::EquilibriumProblem& p = bodies();
  const std::vector<double> rates = _flow->rates(), sizes = moduli(rates);
  if (p.body->properties().linear)
  {
    // W grows with the rates: slower bodies with the same stiffness are stable as well.
    if (!_safe.empty() && std::ranges::equal(sizes, _safe, std::less_equal<double>()))
      return "";
    _flow->set_rates(scaled(rates, ahead));
    const bool beyond = negative_directions() > 0;
    _flow->set_rates(rates);
    if (!beyond)
    {
      _safe = scaled(sizes, ahead);
      return "";
    }
  }
  const int negative = negative_directions();
  if (negative > 0)
    return "the spin or the speed is beyond the critical one: stiffness minus W is not positive definite, " +
           std::to_string(negative) + " of its eigenvalues are negative";
  _safe = sizes;
  return "";
}

void RollingProblem::mark_reached()
{
  for (const solve::Ramp& load : _equilibrium->loads())
    std::ranges::copy(load.value, load.reached.begin());
}

double RollingProblem::torque(const rolling::Motion& spin) const
{
  const rolling::Torque torque(_equilibrium->equilibrium(), *_flow, spin);
  double out = 0.0;
  for (const auto& contact : bodies().contacts)
    out += torque.of(contact->contact_forces());
  return out;
}

std::array<double, 3> RollingProblem::axle(const rolling::Motion& spin) const
{
  return rolling::Torque(_equilibrium->equilibrium(), *_flow, spin).axle();
}

PowerBalance RollingProblem::power_balance()
{
  if (_contacts.empty())
    throw std::invalid_argument("no contact has friction: steady rolling takes no power");
  const solve::EquilibriumProblem& p = bodies();
  std::vector<double> rigid = _flow->at_nodes();
  for (const rolling::Motion& motion : _flow->motions())
    if (motion.spin())
      rolling::Torque(_equilibrium->equilibrium(), *_flow, motion).set_rigid_velocities(rigid);
  PowerBalance out;
  const int g = _flow->gdim();
  // Forces f act on nodes that move with V = w + (Grad u) w, and, as parts of rigid bodies, with R. The driving power
  // is minus the sum of f R; deformation takes the sum of f (V - R), and from it what the pressure does on the normal
  // part of the velocity jump; friction takes the tangential part.
  for (rolling::RollingContact* contact : _contacts)
  {
    contact->update_flow();
    contact->update(p.u->x()->array());
    const std::vector<double> forces = contact->contact_forces(), traction = contact->traction();
    const std::vector<double> velocity = contact->material_velocity(p.u->x()->array());
    const std::vector<double> jump = contact->relative_velocity(p.u->x()->array());
    const std::vector<double> imposed = contact->imposed_velocity();
    const auto& now = contact->geometry().now();
    for (std::size_t k = 0; k < velocity.size(); ++k)
    {
      out.driving -= forces[k] * rigid[k];
      out.rolling += forces[k] * (velocity[k] - rigid[k]);
    }
    for (std::size_t i = 0; i < now.gap.size(); ++i)
      if (now.participates[i])
      {
        out.driving -= now.cover[i] * dot(&traction[i * g], &imposed[i * g], g);
        out.rolling -=
            now.cover[i] * dot(&now.normal[i * g], &traction[i * g], g) * dot(&now.normal[i * g], &jump[i * g], g);
      }
    out.friction += contact->friction_power();
  }
  out.driving = common::sum(p.comm(), out.driving);
  out.rolling = common::sum(p.comm(), out.rolling);
  return out;
}

int RollingProblem::negative_directions() const
{
  return rolling::negative_directions(bodies());
}

double RollingProblem::critical_factor(Mat W) const
{
  const solve::EquilibriumProblem& p = bodies();
  const std::vector<std::string> loose = solve::unconstrained_modes(p.space(), p.fixed, {}, p.u->x()->array());
  if (!loose.empty())
    throw std::invalid_argument("there is no critical speed, as nothing resists rigid motion: " +
                                common::joined(loose));
  return rolling::critical_factor(p, W);
}

rolling::Frequencies RollingProblem::frequencies(rolling::VibrationMatrices matrices, int count, double tolerance) const
{
  const solve::EquilibriumProblem& p = bodies();
  if (std::ranges::any_of(p.contacts, [](const auto& contact) { return contact->has_multipliers(); }))
    throw std::invalid_argument("frequencies are those of bodies with contact by penalty, not by multipliers");
  double fastest = 0.0;
  for (const rolling::Motion& motion : _flow->motions())
    if (motion.spin())
      fastest = std::max(fastest, std::abs(motion.rate->value[0]));
  const operators::OwnedMatrix K = rolling::held_tangent(p);
  matrices.K = K.get();
  return rolling::frequencies(matrices, count, 0.5 * fastest, tolerance);
}
} // namespace dolfinx_impact::problems
