// SPDX-License-Identifier: MIT
#include "RollingNewton.h"
#include "../common/dolfinx_api.h"
#include "../common/gather.h"
#include "../common/text.h"
#include "../common/vectors.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace dolfinx_impact::rolling
{
namespace
{
/// Gap of an active node over the size of the bodies; slip velocity of a stuck one over the speed. The option
/// contact_tolerance sets another one.
constexpr double violation = 1e-9;
constexpr double still = 1e-11; ///< relative change of the tractions at which the linearised problem is solved
constexpr double nearly = 1e-8; ///< and this one, if corrections do not make it smaller
constexpr int max_corrections = 16;
constexpr int poor = 7; ///< corrections after which the compliance is that of a state too far away
constexpr const char* held_by_contact =
    "a body is held by nothing but contact and friction: prescribe its displacement somewhere";

std::vector<RollingContact*> rolling_contacts(const solve::EquilibriumProblem& p)
{
  std::vector<RollingContact*> out;
  for (const auto& contact : p.contacts)
    if (auto* rolling = dynamic_cast<RollingContact*>(contact.get()))
      out.push_back(rolling);
    else
      throw std::invalid_argument(contact->name() + " is no RollingContact: with friction, all contacts must be");
  if (out.empty())
    throw std::invalid_argument("steady rolling with friction needs a contact");
  return out;
}

double tolerance(const std::string& prefix)
{
  PetscReal out = violation;
  operators::check(PetscOptionsGetReal(nullptr, prefix.c_str(), "-contact_tolerance", &out, nullptr),
                   "options are read");
  return out;
}

} // namespace

RollingNewton::RollingNewton(std::shared_ptr<const solve::EquilibriumProblem> problem,
                             const solve::NewtonOptions& options, ReducedContacts& reduced, solve::NewtonEvents events)
    : _problem(problem), _options(options.with_database(problem->linear_solver->prefix())), _events(std::move(events)),
      _reduced(reduced), _contacts(rolling_contacts(*problem)), _frictionless(problem, _options, _events),
      _violation(tolerance(problem->linear_solver->prefix()))
{
}

void RollingNewton::log(const std::string& text) const
{
  if (_events.log)
    _events.log(text);
}

std::int64_t RollingNewton::num_active() const
{
  std::int64_t out = 0;
  for (const RollingContact* c : _contacts)
    out += c->num_active();
  return out;
}

solve::Increment RollingNewton::run(std::span<const double> target)
{
  for (RollingContact* c : _contacts)
    c->update_flow();
  if (num_active() == 0)
  {
    log("  without friction");
    solve::Increment result = _frictionless.run(target);
    if (!result.fault.empty())
      return result;
    log("  with friction");
  }
  return with_friction(target);
}

solve::Increment RollingNewton::with_friction(std::span<const double> target)
{
  const solve::EquilibriumProblem& p = *_problem;
  const std::span<const std::int32_t> fixed = _frictionless.prescribed();
  const std::span<double> u = common::array(*p.u->x());
  solve::Increment result;
  double first = 0.0, scale = 0.0; // forces at the start of the increment, and the largest of these and the present
  int changes = 0;
  Mat K = nullptr;
  for (int iteration = 0;; ++iteration)
  {
    const std::vector<double> residual = operators::values_of(p.body->residual());
    if (!std::isfinite(norm(residual)))
      return result.failed("the residual is nan in Newton iteration " + std::to_string(iteration));
    for (RollingContact* c : _contacts)
      c->update(u);
    if (!K || !p.body->properties().linear || control) // with a control, W changes with the spin
      K = p.body->tangent();
    std::vector<double> equilibrium(residual);
    for (RollingContact* c : _contacts)
    {
      c->update_nodal_stiffness(K);
      const std::vector<double> forces = c->contact_forces();
      for (std::size_t k = 0; k < forces.size(); ++k)
        equilibrium[k] -= forces[k];
    }
    scale = std::max(norm(equilibrium), norm(residual));
    first = iteration == 0 ? scale : first;
    scale = std::max(scale, first);
    std::vector<double> jump(fixed.size());
    for (std::size_t k = 0; k < fixed.size(); ++k)
    {
      equilibrium[fixed[k]] = 0.0;
      jump[k] = target[fixed[k]] - u[fixed[k]];
    }
    const double free = norm(equilibrium);
    const bool moved = common::largest(p.comm(), common::largest_modulus(jump)) == 0.0;
    double wrong = 0.0;
    for (const RollingContact* c : _contacts)
      wrong = std::max(wrong, c->steady_violation());
    const double off = control ? control->error(_contacts) : 0.0;
    result.add(free, num_active(), changes);
    if (_events.iteration)
      _events.iteration(iteration, free, scale, result.active_set_sizes.back(), changes);
    log("    violation of contact and friction " + common::text("%.2e", wrong) +
        (off != 0.0 ? ", torque off " + common::text("%.2e", off) : ""));
    if (moved && iteration > 0 && wrong < _violation && off < _violation &&
        free <= std::max(_options.atol, _options.rtol * scale))
      return result.converged();
    if (iteration == _options.max_iterations)
    {
      result.advice = "Approach the load, the creep or the friction in smaller steps";
      return result.failed("steady rolling did not converge in " + std::to_string(iteration) +
                           " iterations: residual " + common::text("%.1e", free) + " of " +
                           common::text("%.1e", scale) + ", violation of contact and friction " +
                           common::text("%.1e", wrong));
    }
    const auto [fault, corrections] = solve_linearised(K, residual, jump);
    changes = corrections;
    ++result.iterations;
    if (fault.empty())
      continue;
    if (control && (fault == out_of_reach || fault == no_friction))
      return result.failed("the torque " + common::text("%.4g", control->target()) +
                               " was not reached at omega = " + common::text("%.6g", control->omega()) + ": " + fault,
                           true);
    return result.failed("steady rolling was not solved: " + fault, fault == held_by_contact);
  }
}

/// Update u and multipliers by the linearised problem. The compliance of the candidates is that of an earlier geometry;
/// what it leaves is corrected with the present one. Collective.
/// @returns what went wrong, empty if nothing did; and the number of corrections
std::pair<std::string, int> RollingNewton::solve_linearised(Mat K, std::span<const double> residual,
                                                            std::span<const double> jump)
{
  const solve::EquilibriumProblem& p = *_problem;
  BodyResponse& response = _reduced.response();
  const ContactOperators operators(_contacts, p.num_owned());
  std::vector<Mat> extra;
  for (RollingContact* c : _contacts)
    if (Mat tangent = c->tangent())
      extra.push_back(tangent);
  response.update(K, extra);
  if (response.null_pivots() > 0)
    return {held_by_contact, 0};
  const Candidates::ByContact weights = operators.weights();
  std::unique_ptr<ReducedTorque> torque;
  if (control)
  {
    torque = std::make_unique<ReducedTorque>(*control, _contacts, response);
    if (!torque->fault().empty())
      return {torque->fault(), 0};
  }
  Candidates::ByContact forces;
  for (std::size_t k = 0; k < _contacts.size(); ++k)
  {
    const std::size_t g = operators.gdim();
    std::vector<double>& f = forces.emplace_back(_contacts[k]->traction());
    for (std::size_t i = 0; i < f.size(); ++i)
      f[i] *= weights[k][i / g];
  }
  double best = std::numeric_limits<double>::infinity(), spin = 0.0;
  std::vector<double> moved;
  Trial at;
  int corrections = 0;
  for (;; ++corrections)
  {
    std::vector<double> load = operators.nodal_forces(forces);
    for (std::size_t k = 0; k < load.size(); ++k)
      load[k] -= residual[k] + (torque ? spin * torque->load()[k] : 0.0);
    BodyResponse::Solution found = response.solve(std::move(load), jump);
    if (!found.fault.empty())
      return {found.fault, corrections};
    moved = std::move(found.displacements);
    Candidates::ByContact multipliers(forces);
    for (std::size_t k = 0; k < multipliers.size(); ++k)
      for (std::size_t i = 0; i < multipliers[k].size(); ++i)
        if (const double w = weights[k][i / operators.gdim()]; w > 0.0)
          multipliers[k][i] /= w;
    at = trial(moved, std::move(multipliers), spin, torque.get());
    const double off = std::max(at.off, torque ? torque->missing(operators, forces, moved) : 0.0);
    if (corrections > 0 && (off < still || (off < nearly && off > 0.5 * best)))
      break;
    if (corrections == max_corrections)
      break;
    if (corrections == poor)
    {
      _reduced.renew();
      response.update(K, extra);
    }
    best = std::min(best, off);
    if (torque)
      torque->count_from(operators, forces, moved);
    ReducedContacts::Solution next = _reduced.forces(operators, near(at), {forces, at.gaps, at.slips}, torque.get());
    forces = std::move(next.forces);
    spin += next.change;
    if (!next.fault.empty())
      return {next.fault, corrections};
  }
  for (std::size_t k = 0; k < _contacts.size(); ++k)
    _contacts[k]->set_tractions(at.multipliers[k], at.laws[k]);
  const std::span<double> u = common::array(*p.u->x());
  for (std::size_t k = 0; k < moved.size(); ++k)
    u[k] += moved[k];
  p.u->x()->scatter_fwd();
  if (control)
  {
    control->set_omega(control->omega() + spin);
    for (RollingContact* c : _contacts)
      c->update_flow();
  }
  return {"", corrections};
}

/// Nodes that touch, or have a facet in common with one that does. Collective.
std::vector<std::vector<std::int8_t>> RollingNewton::near(const Trial& trial) const
{
  std::vector<std::vector<std::int8_t>> out;
  for (std::size_t k = 0; k < _contacts.size(); ++k)
  {
    const RollingContact& c = *_contacts[k];
    const std::size_t g = c.geometry().gdim();
    const std::vector<std::int8_t> carriers = c.carriers();
    std::vector<std::int8_t> touch(carriers.size(), 0);
    for (std::size_t i = 0; i < touch.size(); ++i)
      touch[i] = carriers[i] && (trial.laws[k].active[i] ||
                                 common::largest_modulus(std::span(trial.multipliers[k]).subspan(i * g, g)) > 0.0);
    std::vector<std::int8_t>& mask = out.emplace_back(c.with_neighbours(touch));
    for (std::size_t i = 0; i < mask.size(); ++i)
      mask[i] = mask[i] && carriers[i];
  }
  return out;
}

/// Gaps, slip velocities and law of the linearised problem. Collective.
RollingNewton::Trial RollingNewton::trial(std::span<const double> moved, Candidates::ByContact multipliers,
                                          double change, const ReducedTorque* torque) const
{
  Trial out;
  out.multipliers = std::move(multipliers);
  for (std::size_t k = 0; k < _contacts.size(); ++k)
  {
    const RollingContact& c = *_contacts[k];
    std::vector<double>& gap = out.gaps.emplace_back(c.gap_change(moved));
    for (std::size_t i = 0; i < gap.size(); ++i)
      gap[i] += c.geometry().now().gap[i];
    std::vector<double>& slip = out.slips.emplace_back(c.slip_change(moved));
    for (std::size_t i = 0; i < slip.size(); ++i)
      slip[i] += c.slip_velocity()[i] + (torque ? change * torque->slopes()[k][i] : 0.0);
    out.laws.push_back(c.law(gap, slip, out.multipliers[k]));
  }
  out.off = this->change(out);
  return out;
}

/// How far multipliers are from what the law makes of them, relative to the largest. Collective.
double RollingNewton::change(const Trial& trial) const
{
  double off = 0.0, size = 0.0;
  for (std::size_t k = 0; k < _contacts.size(); ++k)
    for (std::size_t i = 0; i < trial.multipliers[k].size(); ++i)
    {
      off = std::max(off, std::abs(trial.laws[k].target[i] - trial.multipliers[k][i]));
      size = std::max(size, std::abs(trial.multipliers[k][i]));
    }
  off = common::largest(_problem->comm(), off);
  size = common::largest(_problem->comm(), size);
  return size > 0.0 ? off / size : off;
}
} // namespace dolfinx_impact::rolling
