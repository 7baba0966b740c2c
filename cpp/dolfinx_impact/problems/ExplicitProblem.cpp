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

void ExplicitProblem::resume(double time, std::int64_t step, double next_time, double nominal,
                             const std::optional<integrators::StepSchedule>& schedule, RunObserver& observer)
{
  _time = time;
  _step = step;
  _stepper.resume(next_time, nominal, schedule, observer);
}
} // namespace dolfinx_impact::problems
