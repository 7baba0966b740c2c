// SPDX-License-Identifier: MIT
#include "ExplicitProblem.h"
#include "../common/OnAllRanks.h"
#include "../common/agree.h"
#include "../common/dolfinx_api.h"
#include "../common/gather.h"
#include "../common/text.h"
#include "../enforcement/general/GeneralContact.h"
#include "../enforcement/mortar/tied_nodes.h"
#include "../enforcement/node_to_surface/KinematicContact.h"
#include "../enforcement/node_to_surface/NodePenalty.h"
#include "../enforcement/node_to_surface/TrialSprings.h"
#include "../enforcement/node_to_surface/nodal_compliances.h"
#include "../integrators/assembled_step.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace dolfinx_impact::problems
{
namespace
{
/// Of the bodies' size: what static solutions leave of the conditions of ties.
constexpr double tied_start = 1e-9;
/// Rigid bodies of contacts, each once.
std::vector<std::shared_ptr<RigidBodyInTime>> bodies_of(const std::vector<ContactInTime>& contacts)
{
  std::vector<std::shared_ptr<RigidBodyInTime>> out;
  for (const ContactInTime& c : contacts)
    if (c.body && std::ranges::find(out, c.body) == out.end())
      out.push_back(c.body);
  for (std::size_t i = 0; i < out.size(); ++i) // and those that they meet
  {
    const std::vector<RigidBodyInTime::Meeting> meetings = out[i]->meetings;
    for (const RigidBodyInTime::Meeting& meeting : meetings)
      if (meeting.master && std::ranges::find(out, meeting.master) == out.end())
        out.push_back(meeting.master);
  }
  return out;
}

/// The integrator's view of a rigid body, which keeps all of it.
std::shared_ptr<integrators::RigidBody> in_integrator(const std::shared_ptr<RigidBodyInTime>& body)
{
  return {body, &body->body};
}

/// Add a function of time with three components.
std::array<int, 3> add_vector(FunctionsOfTime& functions, const std::optional<FunctionOfTime>& function,
                              const std::string& what)
{
  if (!function)
    return {-1, -1, -1};
  if (function->size() != 3)
    throw std::invalid_argument(what + " has three components");
  const int first = functions.add(*function);
  return {first, first + 1, first + 2};
}

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
    if ((c.motion || c.rotation) && c.body)
      throw std::invalid_argument(c.name + ": a rigid body moves by forces, not as a function of time");
    const auto columns = add_vector(problem.functions(), c.motion, c.name + ": the motion of a rigid master");
    const auto rotation = add_vector(problem.functions(), c.rotation, c.name + ": the rotation of a rigid master");
    if (c.body)
      out.add_rigid_body_contact(c.contact, in_integrator(c.body));
    else
      out.add_contact(c.contact, columns, rotation);
  }
  for (const auto& rigid : bodies_of(contacts))
  {
    out.add_body(in_integrator(rigid));
    const auto force = add_vector(problem.functions(), rigid->force, "the force on a rigid body");
    const auto torque = add_vector(problem.functions(), rigid->torque, "the torque on a rigid body");
    out.set_body_loads(rigid->body, force, torque);
  }
  for (const auto& rigid : bodies_of(contacts))
    for (const RigidBodyInTime::Meeting& meeting : rigid->meetings)
      out.add_rigid_contact(meeting.contact);
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

/// Masses of the nodes that this rank owns.
std::vector<double> nodal_masses(const ExplicitBody& body, const dolfinx::fem::FunctionSpace<double>& V)
{
  const std::size_t bs = V.dofmap()->index_map_bs();
  std::vector<double> out(V.dofmap()->index_map->size_local());
  for (std::size_t node = 0; node < out.size(); ++node)
    out[node] = body.mass[node * bs];
  return out;
}

integrators::CellSteps cell_steps(const ExplicitBody& body, const std::vector<ContactInTime>& contacts,
                                  const dolfinx::fem::FunctionSpace<double>& V, integrators::Scheme scheme)
{
  const std::vector<double> mass = nodal_masses(body, V);
  double square = 0.0, rate = 0.0;
  for (const ContactInTime& c : contacts)
  {
    const double frequency = c.contact.spring_frequency(mass);
    square += frequency * frequency;
    rate += c.contact.damping_rate(mass);
  }
  return {body.damping, scheme, std::sqrt(square), rate};
}

/// Springs without a given penalty get the stiffness that the bodies offer at rest. Collective.
std::vector<ContactInTime> with_stiffness(std::vector<ContactInTime> contacts, const ExplicitBody& body,
                                          dolfinx::fem::Function<double>& u)
{
  /// The displacement that kernels read is zero meanwhile.
  struct Rest
  {
    explicit Rest(std::span<double> u) : values(u), kept(u.begin(), u.end()) { std::ranges::fill(u, 0.0); }
    ~Rest() { std::ranges::copy(kept, values.begin()); }
    Rest(const Rest&) = delete;
    Rest& operator=(const Rest&) = delete;
    std::span<double> values;
    std::vector<double> kept;
  };
  const auto frequency_stiffness = [&](std::span<const std::int8_t> nodes)
  {
    const Rest rest(common::array(*u.x()));
    return body.frequencies->nodal_stiffness(nodes);
  };
  for (const auto& rigid : bodies_of(contacts))
  {
    std::vector<const enforcement::NodalPair*> pairs;
    for (const ContactInTime& c : contacts)
      if (c.body == rigid)
        pairs.push_back(&c.contact);
    const auto bodies = bodies_of(contacts);
    const bool meets =
        std::ranges::any_of(bodies,
                            [&](const auto& body)
                            {
                              return std::ranges::any_of(body->meetings, [&](const RigidBodyInTime::Meeting& meeting)
                                                         { return body == rigid || meeting.master == rigid; });
                            });
    set_mobility(u.function_space()->mesh()->comm(), rigid->body, pairs, meets);
  }
  std::optional<std::span<const double>> moduli;
  if (body.elasticity)
    moduli = body.elasticity->moduli;
  for (const ContactInTime& c : contacts)
  {
    const auto& directions = c.contact.directions();
    if (auto* general = dynamic_cast<enforcement::GeneralContact*>(directions.front().get());
        general && general->lacks_compliances())
      general->set_nodal_compliances(enforcement::nodal_compliances(
          *u.function_space(), general->facets(), moduli, frequency_stiffness, general->options().axisymmetric));
    const auto* first = dynamic_cast<const enforcement::NodePenalty*>(directions.front().get());
    if (!first || !first->lacks_compliances())
      continue;
    enforcement::NodalCompliances found =
        enforcement::nodal_compliances(*u.function_space(), *first, moduli, frequency_stiffness);
    for (const auto& direction : directions)
    {
      if (auto* springs = dynamic_cast<enforcement::NodePenalty*>(direction.get()))
        springs->set_nodal_compliances(found);
      std::swap(found.slave, found.master); // the other direction has both surfaces exchanged
    }
  }
  return contacts;
}

/// Ties of a problem, in the order of its contacts.
std::vector<enforcement::ExplicitTie*> ties_of(const std::vector<ContactInTime>& contacts)
{
  std::vector<enforcement::ExplicitTie*> out;
  for (const ContactInTime& c : contacts)
    if (auto* const tie = dynamic_cast<enforcement::ExplicitTie*>(c.contact.directions().front().get()))
      out.push_back(tie);
  return out;
}

/// Contacts whose ties know each other. Collective.
std::vector<ContactInTime> with_ties(std::vector<ContactInTime> contacts)
{
  enforcement::connect(ties_of(contacts));
  return contacts;
}

/// Calls a function of the user after each step, or some of them, all ranks together.
class CallingObserver : public RunObserver
{
public:
  CallingObserver(ExplicitProblem& problem, const ExplicitProblem::Callback& callback, std::int64_t every,
                  MPI_Comm comm)
      : _problem(problem), _callback(callback), _every(every), _state(problem.state()), _comm(comm)
  {
    if (every < 1)
      throw common::BadValue("callback_every is " + std::to_string(every) + ": give a positive number of steps");
  }
  std::int64_t room() override { return _every - _problem.step() % _every; }
  void after_steps() override
  {
    if (_problem.step() % _every != 0)
      return;
    _problem.update_motion();
    common::agree(_comm, [this] { _callback(_problem.time(), _state); });
  }

private:
  ExplicitProblem& _problem;
  const ExplicitProblem::Callback& _callback;
  std::int64_t _every;
  state::State _state;
  MPI_Comm _comm;
};
} // namespace

ExplicitProblem::ExplicitProblem(std::shared_ptr<Function> u, std::shared_ptr<Function> v, ExplicitBody body,
                                 std::vector<PrescribedMotion> supports, std::vector<LoadInTime> loads,
                                 std::vector<ContactInTime> contacts, const ExplicitOptions& options,
                                 std::shared_ptr<Function> a)
    : TransientProblem(std::move(u), std::move(v), std::move(supports), functions_of(loads), std::move(a)),
      _body(std::move(body)), _contacts(with_stiffness(with_ties(std::move(contacts)), _body, *_u)),
      _integrator(make_integrator(_body, *this, loads, _contacts, options)),
      _safe(_u, _body.frequencies, cell_steps(_body, _contacts, *_u->function_space(), options.scheme), _body.kind,
            *_integrator),
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
            for (operators::InternalForce* operation : _body.internal.parts())
              if (operation->has_history())
                operation->store_snapshot();
            keep_bodies();
          },
          [this] { go_back(); },
          [this] { return unsolved(); }};
}

void ExplicitProblem::go_back()
{
  for (operators::InternalForce* operation : _body.internal.parts())
    if (operation->has_history())
      operation->restore_snapshot();
  for (const ContactInTime& c : _contacts)
    for (const auto& direction : c.contact.directions())
      direction->reset();
  const auto bodies = rigid_bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i)
    bodies[i]->body.state() = _kept_bodies[i];
}

std::vector<std::shared_ptr<RigidBodyInTime>> ExplicitProblem::rigid_bodies() const
{
  return bodies_of(_contacts);
}

/// Places and momenta at the present time level: a run that goes back starts from them.
void ExplicitProblem::keep_bodies()
{
  _kept_bodies.clear();
  for (const auto& rigid : rigid_bodies())
  {
    const double dt = _integrator->last_step();
    integrators::RigidBodyState& kept = _kept_bodies.emplace_back(rigid->body.state());
    kept.momentum = rigid->body.momentum(dt);
    kept.angular_momentum = rigid->body.angular_momentum(dt);
  }
}

std::string ExplicitProblem::unsolved() const
{
  const long long here = (long long)_body.internal.num_unsolved(), all = common::sum(comm(), here);
  if (all > 0)
    return "the local equations of the material were not solved at " + std::to_string(all) + " points";
  for (const ContactInTime& c : _contacts)
  {
    long long points = 0;
    for (const auto& direction : c.contact.directions())
      points += direction->num_unsolved();
    if (points = common::sum(comm(), points); points > 0)
      return c.name + ": the local equations of the law of the interface were not solved at " + std::to_string(points) +
             " points";
  }
  return "";
}

/// Slave nodes in the master by more than half a facet stay open: the bodies would pass through each other. Of balanced
/// contact the slave of the pair decides.
void ExplicitProblem::check_overlap()
{
  for (const ContactInTime& c : _contacts)
  {
    const enforcement::NodalContact* slaves = c.contact.directions().front().get();
    const auto* contact = dynamic_cast<const enforcement::NodeToSurface*>(slaves);
    long long deep = contact ? contact->implausible() : 0;
    if (const auto* general = dynamic_cast<const enforcement::GeneralContact*>(slaves))
    {
      deep = common::sum(comm(), (long long)(general->implausible()));
      if (deep > 0)
        throw common::BadValue(c.name + ": " + std::to_string(deep) +
                               " nodes lie deeper in another body than a twentieth of a cell: the bodies overlap at "
                               "the start; move them apart");
      continue;
    }
    if (_step == 0 && contact && contact->obstacle())
      deep = contact->too_deep(_integrator->displacement()).value_or(0);
    else if (_step == 0 && dynamic_cast<const enforcement::KinematicContact*>(slaves))
    {
      // Kinematic contact evaluates gaps inside steps only: springs find the nodes.
      enforcement::TrialSprings trial(*_u->function_space(), c.contact, _integrator->displacement());
      trial.force(1.0);
      deep = trial.implausible();
    }
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
    CallingObserver observer(*this, callback, options.callback_every, comm());
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

double ExplicitProblem::stable_step(StableStepMethod method)
{
  update_motion();
  return stable_step_of_function(method);
}

double ExplicitProblem::stable_step_of_function(StableStepMethod method)
{
  if (method == StableStepMethod::element)
    return _safe.compute();
  if (method == StableStepMethod::eigenvalue)
    return assembled_stable_step();
  if (!_body.elasticity)
    throw common::BadValue("L/c_d needs a material: use method 'element' or 'eigenvalue'");
  const auto V = _u->function_space();
  const std::vector<double> sizes = integrators::cell_sizes(*V->mesh());
  const double degree = V->element()->basix_element().degree();
  double shortest = std::numeric_limits<double>::infinity(); // time that a wave takes through a cell
  for (std::size_t cell = 0; cell < sizes.size(); ++cell)
    shortest = std::min(shortest, sizes[cell] / degree / _body.elasticity->wave_speeds[cell]);
  const double omega = 2.0 / -common::largest(comm(), -shortest);
  return _safe.steps()(std::array{omega * omega}, std::array{0.0})[0];
}

/// The limit of the assembled bodies, with the springs of given stiffness of all slave nodes that have a master now.
double ExplicitProblem::assembled_stable_step()
{
  if (!_body.stiffness)
    throw common::BadValue("the stiffness of these bodies cannot be assembled: use method 'element'");
  if (!rigid_bodies().empty())
    throw common::BadValue("rigid bodies are not part of the assembled system: use method 'element'");
  std::vector<double> inverse(num_owned());
  for (std::size_t i = 0; i < inverse.size(); ++i)
    inverse[i] = _supports.mask()[i] ? 0.0 : 1.0 / _body.mass[i];
  const auto K = _body.stiffness();
  for (const ContactInTime& c : _contacts)
    if (const auto* springs = dynamic_cast<const enforcement::NodePenalty*>(c.contact.directions().front().get());
        springs && springs->penalty() > 0.0)
      enforcement::TrialSprings(*_u->function_space(), c.contact, _u->x()->array()).add_to(K->matrix());
  const integrators::CellSteps& steps = _safe.steps();
  if (_body.cell_damping)
    return integrators::assembled_step(K->matrix(), _body.cell_damping()->matrix(), inverse, steps.uniform,
                                       _safe.compute());
  const double omega = integrators::highest_frequency(K->matrix(), inverse);
  return integrators::stable_step(omega * omega, 0.0, steps.uniform, steps.scheme);
}

state::State ExplicitProblem::state()
{
  state::State out("explicit problem");
  const std::size_t bs = _u->function_space()->dofmap()->index_map_bs();
  const auto add = [&](const char* name, Function& f)
  { out.add(name, state::Place::node, state::View(common::array(*f.x()).first(num_owned())), bs); };
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

void ExplicitProblem::begin_anew()
{
  if (_step != 0)
    throw common::BadValue("the problem has made " + std::to_string(_step) + " steps: make another one");
  for (const ContactInTime& c : _contacts)
    for (const auto& direction : c.contact.directions())
      direction->reset();
  _stepper.begin_anew();
}

void ExplicitProblem::start(RunObserver& observer)
{
  const std::size_t owned = num_owned();
  start_tied();
  _stepper.start(common::array(*_u->x()).first(owned), common::array(*_v->x()).first(owned), observer);
  update_motion();
}

/// Refuse a displacement that contradicts the ties; remove from the velocity what they forbid. Collective.
void ExplicitProblem::start_tied()
{
  std::vector<const enforcement::TieConditions*> ties;
  for (const enforcement::ExplicitTie* tie : ties_of(_contacts))
    ties.push_back(&tie->conditions());
  _lost_at_start = 0.0;
  if (ties.empty())
    return;
  std::vector<double> inverse(num_owned());
  for (std::size_t i = 0; i < inverse.size(); ++i)
    inverse[i] = _supports.mask()[i] ? 0.0 : 1.0 / _body.mass[i];
  const double size = ties[0]->size();
  enforcement::TieSystem system(std::move(ties), inverse);
  const double apart = system.largest_jump(common::array(*_u->x()).first(num_owned()));
  if (apart > tied_start * size)
    throw common::BadValue("the displacement at the start moves tied surfaces apart by " + common::text("%.3e", apart) +
                           ": ties hold from the reference configuration on; start from "
                           "zero, or from a static problem with the same ties");
  const std::span<double> v = common::array(*_v->x()).first(num_owned());
  const std::vector<double> allowed = system.project(v);
  for (std::size_t i = 0; i < v.size(); ++i)
    _lost_at_start += 0.5 * _body.mass[i] * (v[i] * v[i] - allowed[i] * allowed[i]);
  _lost_at_start = common::sum(comm(), _lost_at_start);
  std::ranges::copy(allowed, v.begin());
  _v->x()->scatter_fwd();
}

void ExplicitProblem::resume(double time, std::int64_t step, double next_time, double nominal,
                             const std::optional<integrators::StepSchedule>& schedule, RunObserver& observer)
{
  _time = time;
  _step = step;
  _stepper.resume(next_time, nominal, schedule, observer);
}
} // namespace dolfinx_impact::problems
