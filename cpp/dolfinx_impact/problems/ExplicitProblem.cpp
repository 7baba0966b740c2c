// SPDX-License-Identifier: MIT
#include "ExplicitProblem.h"
#include "../common/OnAllRanks.h"
#include "../common/agree.h"
#include "../common/gather.h"
#include "../common/text.h"
#include "../enforcement/node_to_surface/KinematicContact.h"
#include "../enforcement/node_to_surface/NodePenalty.h"
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace dolfinx_impact::problems
{
namespace
{
/// Bodies with scheme, supports, loads and contacts: what steps.
std::unique_ptr<integrators::CentralDifference> make_integrator(const ExplicitBody& body, TransientProblem& problem,
                                                                const std::vector<LoadInTime>& loads,
                                                                const std::vector<ContactInTime>& contacts,
                                                                const ExplicitOptions& options)
{
  if (options.scheme == integrators::Scheme::classical)
    for (const ExplicitBody::Term& term : body.terms)
      if (term.kind == integrators::WorkKind::damping)
        throw std::invalid_argument(
            "the classical scheme takes mass-proportional damping only, its matrix must be diagonal");
  auto integrator =
      std::make_unique<integrators::CentralDifference>(problem.displacement()->function_space(), body.internal,
                                                       body.linear, body.mass, body.damping.alpha, options.scheme);
  integrators::CentralDifference& out = *integrator;
  int column = 0; // loads have the first ones, see functions_of
  for (const ExplicitBody::Term& term : body.terms)
    out.add_term(term.forces, term.kind);
  for (const Supports::Part& part : problem.supports().parts())
    out.prescribe(part.dofs, part.values, part.column);
  for (const LoadInTime& load : loads)
    out.add_load(load.dofs, load.values, load.amplitude ? column++ : -1);
  for (const ContactInTime& c : contacts)
  {
    const int first = c.motion ? problem.functions().add(*c.motion) : -1;
    if (c.motion && c.motion->size() != 3)
      throw std::invalid_argument(c.name + ": the motion of a rigid master has three components");
    out.add_contact(c.contact, first < 0 ? std::array{-1, -1, -1} : std::array{first, first + 1, first + 2});
  }
  out.set_release_limit(options.release_limit);
  return integrator;
}

/// Amplitudes of loads, which the functions of time begin with.
FunctionsOfTime functions_of(const std::vector<LoadInTime>& loads)
{
  FunctionsOfTime out;
  for (const LoadInTime& load : loads)
    if (load.amplitude)
    {
      if (load.amplitude->size() != 1)
        throw std::invalid_argument("the amplitude of a load is a number");
      out.add(*load.amplitude);
    }
  return out;
}

integrators::CellSteps cell_steps(const ExplicitBody& body, const std::vector<ContactInTime>& contacts,
                                  integrators::Scheme scheme)
{
  double square = 0.0;
  for (const ContactInTime& c : contacts)
    square += c.spring_frequency * c.spring_frequency;
  return {body.damping, scheme, std::sqrt(square)};
}

/// Calls f(name, history) for the internal variables of each integral.
void each_history(const ExplicitBody& body, const auto& f)
{
  int number = 0;
  for (const auto& operation : {body.internal.inner, body.internal.outer})
    for (std::size_t i = 0; i < operation->num_integrals(); ++i)
      if (const auto& history = operation->history(i))
        f("integral " + std::to_string(number++), *history);
}

/// Calls a function of the user after each step, all ranks together.
class CallingObserver : public RunObserver
{
public:
  CallingObserver(ExplicitProblem& problem, const ExplicitProblem::Callback& callback, MPI_Comm comm)
      : _problem(problem), _callback(callback), _state(problem.state()), _comm(comm)
  {
  }
  std::int64_t room() override { return 1; }
  void after_steps() override
  {
    _problem.update_motion();
    common::agree(_comm, [this] { _callback(_problem.time(), _state); });
  }

private:
  ExplicitProblem& _problem;
  const ExplicitProblem::Callback& _callback;
  state::State _state;
  MPI_Comm _comm;
};
} // namespace

ExplicitProblem::ExplicitProblem(std::shared_ptr<Function> u, std::shared_ptr<Function> v, ExplicitBody body,
                                 std::vector<PrescribedMotion> supports, std::vector<LoadInTime> loads,
                                 std::vector<ContactInTime> contacts, const ExplicitOptions& options,
                                 std::shared_ptr<Function> a)
    : TransientProblem(std::move(u), std::move(v), std::move(supports), functions_of(loads), std::move(a)),
      _body(std::move(body)), _contacts(std::move(contacts)),
      _integrator(make_integrator(_body, *this, loads, _contacts, options)),
      _safe(_u, _body.frequencies, cell_steps(_body, _contacts, options.scheme), _body.kind, *_integrator),
      _history(_contacts.size()), _stepper(system(), _time, _step)
{
  RunObserver nobody;
  if (options.start)
    start(nobody);
}

ExplicitStepper::System ExplicitProblem::system()
{
  std::vector<std::string> names;
  for (const ContactInTime& c : _contacts)
    names.push_back(c.name);
  return {_u->function_space(),
          *_integrator,
          _safe,
          _history,
          std::move(names),
          [this] { update_motion(); },
          [this] { check_overlap(); },
          [this](std::span<const double> times)
          {
            std::vector<double> out;
            common::agree(comm(), [&] { out = _functions.table(times); });
            return out;
          },
          [this]
          {
            for (const auto& operation : {_body.internal.inner, _body.internal.outer})
              if (operation->has_history())
                operation->store_snapshot();
          },
          [this] { go_back(); },
          [this] { return unsolved(); }};
}

void ExplicitProblem::go_back()
{
  for (const auto& operation : {_body.internal.inner, _body.internal.outer})
    if (operation->has_history())
      operation->restore_snapshot();
  for (const ContactInTime& c : _contacts)
    for (const auto& direction : c.contact.directions())
      direction->reset();
}

std::string ExplicitProblem::unsolved() const
{
  const long long here = (long long)_body.internal.num_unsolved(), all = common::sum(comm(), here);
  return all == 0 ? "" : "the local equations of the material were not solved at " + std::to_string(all) + " points";
}

/// Nodes in the master by more than half a facet stay open: the bodies would pass through each other.
void ExplicitProblem::check_overlap()
{
  for (const ContactInTime& c : _contacts)
  {
    long long deep = 0;
    for (const auto& direction : c.contact.directions())
      if (const auto* contact = dynamic_cast<const enforcement::NodeToSurface*>(direction.get()))
        deep += (_step == 0 ? contact->too_deep(_integrator->displacement()) : std::nullopt)
                    .value_or(contact->implausible());
    deep = common::sum(comm(), deep);
    if (deep > 0)
      throw common::BadValue(c.name + ": " + std::to_string(deep) +
                             " slave nodes lie deeper in the master than half a facet: the bodies overlap at the "
                             "start; move them apart");
  }
}

void ExplicitProblem::advance(double until, const AdvanceOptions& options, const Callback& callback)
{
  if (callback)
  {
    CallingObserver observer(*this, callback, comm());
    advance(until, options, observer);
  }
  else
  {
    RunObserver nobody;
    advance(until, options, nobody);
  }
  update_motion();
}

void ExplicitProblem::advance(double until, const AdvanceOptions& options, RunObserver& observer)
{
  if (_advances)
    throw common::Failure("advance was called while it runs, by a callback: let the callback return, and call advance "
                          "again after");
  if (!(until >= _time))
    throw common::BadValue("until is " + common::text("%g", until) + ", but the time is " + common::text("%g", _time) +
                           " already");
  struct Running
  {
    explicit Running(bool& flag) : on(flag) { on = true; }
    ~Running() { on = false; }
    bool& on;
  } const running(_advances);
  _stepper.advance(until, options, observer);
}

double ExplicitProblem::stable_step()
{
  update_motion();
  return _safe.compute();
}

state::State ExplicitProblem::state()
{
  state::State out("explicit problem");
  const std::size_t bs = _u->function_space()->dofmap()->index_map_bs();
  const auto add = [&](const char* name, Function& f)
  { out.add(name, state::Place::node, state::View(f.x()->mutable_array().first(num_owned())), bs); };
  add("displacement", *_u);
  add("velocity", *_v);
  add("acceleration", *_a);
  return out;
}

void ExplicitProblem::update_motion()
{
  std::vector<double> v(num_owned()), a(num_owned());
  _integrator->motion(v, a);
  set_motion(_integrator->displacement(), v, a);
}

void ExplicitProblem::start(RunObserver& observer)
{
  const std::size_t owned = num_owned();
  _stepper.start(_u->x()->array().first(owned), _v->x()->array().first(owned), observer);
  update_motion();
}

state::State ExplicitProblem::saved_state()
{
  state::State out("explicit problem");
  const auto add = [](state::State& to, std::string name, state::Place place, std::vector<double> values)
  { to.add_own(std::move(name), place, std::move(values)); };
  const auto& schedule = _stepper.schedule();
  const integrators::SafeStep::Saved safe = _safe.saved();
  out.add(_integrator->saved_state());
  add(out, "time", state::Place::all, {_time, _stepper.next_time(), double(_step)});
  if (schedule)
    add(out, "schedule", state::Place::all,
        {schedule->begin, schedule->until, double(schedule->first), double(schedule->last),
         double(schedule->automatic)});
  else
    add(out, "schedule", state::Place::all, {});
  add(out, "stable step", state::Place::all,
      {safe.value, _stepper.nominal_step(), double(safe.check_step), double(safe.check_interval), double(safe.deformed),
       double(_safe.changes.stale), _safe.changes.total, _safe.changes.allowed});
  add(out, "energies", state::Place::all,
      {double(_history.total_start().has_value()), _history.total_start().value_or(0.0), _history.largest()});
  if (const integrators::StableStepWatch* watch = _safe.watch())
  {
    state::State part("watch");
    const auto& seen = watch->seen();
    add(part, "squares", state::Place::cell, seen.squares);
    add(part, "rates", state::Place::cell, seen.rates);
    add(part, "since", state::Place::cell, seen.since);
    add(part, "reference", state::Place::node,
        {seen.reference.begin(), seen.reference.begin() + std::ptrdiff_t(num_owned())});
    add(part, "sensitivity", state::Place::all, {seen.sensitivity});
    out.add(std::move(part));
  }
  for (std::size_t k = 0; k < _contacts.size(); ++k)
  {
    state::State part("contact " + std::to_string(k));
    std::vector<state::State> directions = _contacts[k].contact.saved_states();
    for (std::size_t d = 0; d < directions.size(); ++d)
    {
      directions[d].rename("direction " + std::to_string(d));
      part.add(std::move(directions[d]));
    }
    out.add(std::move(part));
  }
  each_history(_body,
               [&](const std::string& name, const operators::PointHistory& history)
               {
                 state::State part(name);
                 for (std::size_t f = 0; f < history.num_fields(); ++f)
                   if (history.is_history(f))
                     add(part, history.name(f), state::Place::rank, history.values(f));
                 out.add(std::move(part));
               });
  return out;
}

void ExplicitProblem::resume(const state::State& saved)
{
  const auto numbers = [&](const char* name) { return saved.values<double>(name); };
  const auto copied = [](const state::State& part, const char* name)
  {
    const std::span<double> values = part.values<double>(name);
    return std::vector<double>(values.begin(), values.end());
  };
  each_history(_body,
               [&](const std::string& name, operators::PointHistory& history)
               {
                 const state::State& part = saved.part(name);
                 for (std::size_t f = 0; f < history.num_fields(); ++f)
                   if (history.is_history(f))
                     history.set_values(f, part.values<double>(history.name(f)));
               });
  for (std::size_t k = 0; k < _contacts.size(); ++k)
    _contacts[k].contact.resume(saved.part("contact " + std::to_string(k)).parts());
  const auto safe = numbers("stable step"), energies = numbers("energies"), time = numbers("time"),
             steps = numbers("schedule");
  if (integrators::StableStepWatch* watch = _safe.watch())
  {
    const state::State& part = saved.part("watch");
    watch->restore({copied(part, "squares"), copied(part, "rates"), copied(part, "since"), copied(part, "reference"),
                    part.values<double>("sensitivity")[0]});
  }
  _safe.restore({safe[0], std::int64_t(safe[2]), std::int64_t(safe[3]), safe[4] != 0.0});
  _safe.changes = {safe[5] != 0.0, safe[6], safe[7]};
  _integrator->resume(saved.part(_integrator->empty_state().name()));
  std::optional<integrators::StepSchedule> schedule;
  if (!steps.empty())
    schedule = {steps[0], steps[1], std::int64_t(steps[2]), std::int64_t(steps[3]), steps[4] != 0.0};
  RunObserver nobody;
  resume(time[0], std::int64_t(time[2]), time[1], safe[1], schedule, nobody);
  _history.resume(energies[0] != 0.0 ? std::optional(energies[1]) : std::nullopt, energies[2]);
  update_motion();
}

void ExplicitProblem::resume(double time, std::int64_t step, double next_time, double nominal,
                             const std::optional<integrators::StepSchedule>& schedule, RunObserver& observer)
{
  _time = time;
  _step = step;
  _stepper.resume(next_time, nominal, schedule, observer);
}
} // namespace dolfinx_impact::problems
