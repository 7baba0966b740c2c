// SPDX-License-Identifier: MIT
#include "NewmarkProblem.h"
#include "../common/OnAllRanks.h"
#include "../common/agree.h"
#include "../common/text.h"
#include "../integrators/newmark/highest_frequency.h"
#include "OneCall.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

using dolfinx_impact::common::text;

namespace dolfinx_impact::problems
{
namespace
{
constexpr double smallest_part = 1e-3; // of the largest step: ten cut-backs

/// Functions of time of the loads that the residual contains, which come first.
FunctionsOfTime functions_of(const BodyLoads& loads)
{
  FunctionsOfTime out;
  for (const BodyLoads::Scaled& load : loads.scaled)
  {
    if (load.amplitude.size() != 1)
      throw std::invalid_argument("the amplitude of a load is a number");
    out.add(load.amplitude);
  }
  return out;
}
} // namespace

NewmarkProblem::NewmarkProblem(std::shared_ptr<Function> u, std::shared_ptr<Function> v, ImplicitBody body,
                               std::vector<PrescribedMotion> supports, std::vector<LoadInTime> loads,
                               std::vector<ImplicitContact> contacts, const NewmarkOptions& options,
                               std::shared_ptr<Function> a, const FunctionsOfTime::Source& source,
                               std::vector<ImplicitBodyInTime> bodies)
    : TransientProblem(std::move(u), std::move(v), std::move(supports), functions_of(body.loads), std::move(a)),
      _options(options), _body(std::move(body)), _bodies(std::move(bodies)), _history(contacts.size())
{
  auto loaded = std::make_shared<LoadedBody>(_body.body, num_owned());
  auto moving = std::make_shared<integrators::MovingBody>(loaded, _u, _v, _body.inertia, _body.alpha, _body.damping);
  std::vector<std::shared_ptr<enforcement::StaticContact>> pairs;
  for (const ImplicitContact& c : contacts)
    pairs.push_back(c.contact);
  _equilibrium = make_equilibrium(_u, moving, std::move(pairs), _supports.mask(), options.solver, "impact_implicit_");
  std::shared_ptr<TimeExcitation> excitation;
  common::agree(comm(),
                [&]
                {
                  excitation = std::make_shared<TimeExcitation>(comm(), _functions, _supports, _body.loads, loaded,
                                                                std::move(loads), contacts, _bodies);
                });
  _stepper = std::make_unique<integrators::ImplicitStepper>(_equilibrium, moving, options.scheme, excitation,
                                                            _body.mass, _v, _a);
  std::vector<RigidMember> members;
  for (const ImplicitBodyInTime& rigid : _bodies)
  {
    _stepper->add_body(rigid.body, rigid.contacts);
    members.push_back({rigid.body, rigid.contacts});
  }
  if (!members.empty())
    _rigid = std::make_unique<RigidEquilibrium>(_equilibrium, std::move(members));
  _functions.set_source(source);
  _stepper->enter_contact();
  _stepper->start({});
  _functions.set_source({});
  add_row();
}

NewmarkProblem::~NewmarkProblem() = default;

/// Add the present energies and contact forces to the history. Collective.
void NewmarkProblem::add_row()
{
  const auto energies = _stepper->energies().values();
  std::vector<double> row(energies.begin(), energies.end());
  for (const auto& contact : _equilibrium->contacts)
  {
    const auto force = contact->force().value_or(std::array<double, 3>{});
    row.insert(row.end(), force.begin(), force.end());
  }
  _history.add({&_time, 1}, row);
}

void NewmarkProblem::resume()
{
  _u->x()->scatter_fwd();
  _stepper->resume();
  set_time();
  _history.begin_anew();
  add_row();
}

void NewmarkProblem::set_time()
{
  _time = _stepper->time();
  _step = _stepper->step();
}

void NewmarkProblem::forget()
{
  _equilibrium->linear_solver->reset();
  if (_solver)
    _solver->forget();
  for (const auto& contact : _equilibrium->contacts)
    contact->forget();
}

double NewmarkProblem::stable_step()
{
  const double product = _options.scheme.stable_frequency();
  if (std::isinf(product))
    return product;
  std::vector<std::int8_t> held(_supports.mask().begin(), _supports.mask().begin() + std::ptrdiff_t(num_owned()));
  for (std::size_t i = 0; i < held.size(); ++i)
    held[i] = held[i] || _body.inertia->massless()[i];
  const double omega = integrators::highest_frequency(_body.body->tangent(), _body.inertia->matrix(), held);
  return omega > 0.0 ? product / omega : std::numeric_limits<double>::infinity();
}

void NewmarkProblem::advance(double until, const ImplicitAdvance& options, const Callback& callback,
                             const ImplicitRunEvents& events)
{
  const OneCall call(_advancing, "advance");
  const double smallest = options.smallest.value_or(smallest_part * options.dt);
  if (!(until >= _time) || !std::isfinite(until))
    throw common::BadValue("the time " + text("%.6g", until) + " has passed: the problem is at " + text("%.6g", _time));
  if (!(options.dt > 0.0) || !(smallest > 0.0 && smallest <= options.dt))
    throw common::BadValue("dt and smallest are steps, positive and smallest not greater than dt");
  if ((options.tolerance && !(*options.tolerance > 0.0)) || !(options.rtol >= 0.0 && options.rtol < 1.0) ||
      !(options.atol >= 0.0) || options.max_iterations < 1)
    throw common::BadValue("tolerances are positive, and there is one iteration at least");
  if (options.callback_every < 1)
    throw common::BadValue("callback_every is " + std::to_string(options.callback_every) +
                           ": give a positive number of steps");
  common::agree(comm(), [this] { _supports.check(); });
  for (const auto& contact : _equilibrium->contacts)
    contact->check_parameters();
  if (until == _time)
    return;
  const auto moves = [](const Supports::Part& part) { return part.column >= 0; };
  if (_step == 0 && (events.update || std::ranges::any_of(_supports.parts(), moves)))
  {
    // Only now is there a step over which prescribed motion can be differentiated.
    if (events.update)
      events.update(0.0);
    _stepper->start(options.dt);
    _history.begin_anew();
    add_row();
    if (events.started)
      events.started();
  }
  const double round_off = std::nextafter(until, std::numeric_limits<double>::infinity()) - until;
  integrators::StepControl control(options.dt, std::max(smallest, round_off), options.tolerance);
  if (_control && _control->largest() == options.dt && _control->tolerance() == options.tolerance)
    control = {options.dt, control.smallest(), options.tolerance, _control->length(), _control->last()};
  _control = control;
  solve::NewtonOptions newton;
  newton.rtol = options.rtol;
  newton.atol = options.atol;
  newton.max_iterations = options.max_iterations;
  _solver = std::make_unique<solve::IncrementSolver>(_equilibrium, newton, events.newton);
  if (_rigid)
    _rigid->set_log(events.newton.log);
  try
  {
    if (events.begins)
      events.begins();
    take_steps(until, callback, options.callback_every, events);
  }
  catch (...)
  {
    _solver->tell_nobody();
    if (_rigid)
      _rigid->set_log({});
    throw;
  }
  if (_rigid)
    _rigid->set_log({});
  _solver->free();
  _solver.reset();
}

/// Solve the equations of a step, those of rigid bodies with them. Collective.
solve::Increment NewmarkProblem::solve_step(std::span<const double> target)
{
  const auto solver = [this](std::span<const double> goal) { return _solver->run(goal); };
  if (!_rigid)
    return solver(target);
  solve::Increment out = _rigid->run(solver, target);
  out.iterations = _rigid->most_iterations(); // the next step's length depends on how hard this one was for the bodies
  for (std::size_t b = 0; out.fault.empty() && b < _bodies.size(); ++b)
    _bodies[b].body->solution = _rigid->solution(b);
  return out;
}

void NewmarkProblem::take_steps(double until, const Callback& callback, std::int64_t every,
                                const ImplicitRunEvents& events)
{
  const integrators::ImplicitEvents told{events.newton.log, events.update};
  while (_time < until)
  {
    const double goal = events.goal ? std::min(until, events.goal()) : until;
    _stepper->take_step(goal, *_control, [this](std::span<const double> target) { return solve_step(target); }, told);
    set_time();
    add_row();
    if (events.accepted)
      events.accepted();
    if (callback && _step % every == 0)
    {
      const state::State now = state();
      common::agree(comm(), [&] { callback(_time, now); });
    }
  }
}
} // namespace dolfinx_impact::problems
