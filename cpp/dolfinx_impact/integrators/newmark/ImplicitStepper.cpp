// SPDX-License-Identifier: MIT
#include "ImplicitStepper.h"
#include "../../common/OnAllRanks.h"
#include "../../common/dolfinx_api.h"
#include "../../common/text.h"
#include "../../operators/petsc_check.h"
#include "tied_rates.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

using dolfinx_impact::common::text;

namespace dolfinx_impact::integrators
{
/// State of this rank before a step, ghosts included.
struct ImplicitStepper::Before
{
  std::vector<double> displacement, velocity, acceleration;
  std::vector<state::State> contacts;
};

namespace
{
std::vector<double> copy_of(std::span<const double> values)
{
  return {values.begin(), values.end()};
}

std::vector<double> copy_of(const ImplicitStepper::Function& f)
{
  return copy_of(f.x()->array());
}

double sum(MPI_Comm comm, std::span<const double> a, std::span<const double> b)
{
  double out = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    out += a[i] * b[i];
  MPI_Allreduce(MPI_IN_PLACE, &out, 1, MPI_DOUBLE, MPI_SUM, comm);
  return out;
}
} // namespace

ImplicitStepper::ImplicitStepper(std::shared_ptr<const solve::EquilibriumProblem> equations,
                                 std::shared_ptr<MovingBody> body, const ImplicitScheme& scheme,
                                 std::shared_ptr<Excitation> excitation, std::vector<double> total_mass,
                                 std::shared_ptr<Function> velocity, std::shared_ptr<Function> acceleration)
    : _equations(std::move(equations)), _body(std::move(body)), _scheme(scheme), _excitation(std::move(excitation)),
      _total_mass(std::move(total_mass)), _velocity(std::move(velocity)), _acceleration(std::move(acceleration))
{
  if (_total_mass.size() != _equations->num_owned() || _body->inertia().massless().size() != _total_mass.size())
    throw std::invalid_argument("implicit steps: masses of another number than owned degrees of freedom");
  const std::span<const double> u = common::array(*_equations->u->x());
  _start_displacement.assign(u.begin(), u.begin() + num_owned());
  _motion.displacement = _start_displacement;
}

void ImplicitStepper::add_body(std::shared_ptr<ImplicitRigidBody> body, std::vector<std::size_t> contacts)
{
  for (std::size_t k : contacts)
    if (body->turns() && !_equations->contacts.at(k)->rotation())
      throw std::invalid_argument(_equations->contacts[k]->name() + " has no rigid master that could turn");
  _bodies.push_back({std::move(body), std::move(contacts)});
}

TimeValues ImplicitStepper::sample(std::optional<double> step, double time)
{
  TimeValues out = _excitation->sample(step, time);
  for (const Rigid& rigid : _bodies)
    for (std::size_t k : rigid.contacts)
      out.places[k] = rigid.body->state().displacement;
  return out;
}

/// Contacts begin an increment, with rigid masters where they are prescribed, and bodies where they are.
void ImplicitStepper::begin_contacts(const TimeValues& values, double step, std::span<const double> target)
{
  const auto& contacts = _equations->contacts;
  for (std::size_t k = 0; k < contacts.size(); ++k)
    if (contacts[k]->rotation())
      contacts[k]->set_rotation(gap::matrix_of(gap::quaternion_of(values.angles[k])));
  for (const Rigid& rigid : _bodies)
    for (std::size_t k : rigid.contacts)
      if (contacts[k]->rotation())
        contacts[k]->set_rotation(rigid.body->rotation());
  for (std::size_t k = 0; k < contacts.size(); ++k)
  {
    contacts[k]->set_time_step(step);
    contacts[k]->begin_step(u(), contacts[k]->displacement() ? std::optional(values.places[k]) : std::nullopt, target);
  }
}

/// Contact forces on a body where the contacts have it. Collective.
solve::MasterForce ImplicitStepper::force_on(std::size_t body) const
{
  const std::vector<std::size_t>& contacts = _bodies[body].contacts;
  return solve::force_on_master(*_equations, contacts,
                                solve::centre_of_master(*_equations->contacts[contacts.front()]));
}

void ImplicitStepper::enter_contact()
{
  const TimeValues values = sample({}, 0.0);
  _equations->u->x()->scatter_fwd();
  const auto& contacts = _equations->contacts;
  begin_contacts(values, 0.0, {});
  for (const auto& contact : contacts)
  {
    contact->update_gap(u());
    if (!contact->has_multipliers())
      contact->update_active_set(true);
    contact->accept_step();
  }
}

/// Internal minus external forces of the bodies at the present displacement, owned [F]. Collective.
std::vector<double> ImplicitStepper::body_residual(std::span<const double> factors)
{
  const Scaled scaled(*_excitation, factors);
  operators::Entries b(_body->body().residual());
  std::vector<double> out(num_owned());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = b[i];
  return out;
}

/// All forces at a time; those of supports balance the others. Collective.
Forces ImplicitStepper::forces(const Motion& motion, const TimeValues& values)
{
  Forces out;
  const std::vector<double> residual = body_residual(values.factors);
  {
    const Scaled scaled(*_excitation, values.factors);
    out.external = _excitation->external_forces();
  }
  out.damping = _body->damping_forces(motion);
  std::vector<double> balance = _body->inertia().times(motion.acceleration);
  for (std::size_t i = 0; i < balance.size(); ++i)
    balance[i] += out.damping[i] + residual[i];
  const auto is_body = [this](std::size_t k)
  { return std::ranges::any_of(_bodies, [k](const Rigid& b) { return std::ranges::count(b.contacts, k) > 0; }); };
  for (std::size_t k = 0; k < _equations->contacts.size(); ++k)
  {
    const auto& contact = _equations->contacts[k];
    const std::vector<double> pressed = contact->contact_forces();
    for (std::size_t i = 0; i < balance.size(); ++i)
      balance[i] -= pressed[i];
    const bool moves = contact->displacement() && !is_body(k);
    out.obstacles.push_back(contact->displacement() ? contact->force().value_or(std::array<double, 3>{})
                                                    : std::array<double, 3>{});
    out.torques.push_back(
        moves && contact->rotation()
            ? solve::force_on_master(*_equations, std::array{k}, solve::centre_of_master(*contact)).torque
            : std::array<double, 3>{});
  }
  out.internal = residual;
  for (std::size_t i = 0; i < balance.size(); ++i)
  {
    out.internal[i] += out.external[i];
    balance[i] = _equations->fixed[i] ? balance[i] : 0.0;
  }
  out.support = std::move(balance);
  return out;
}

void ImplicitStepper::show_motion()
{
  std::ranges::copy(_motion.velocity, common::array(*_velocity->x()).begin());
  std::ranges::copy(_motion.acceleration, common::array(*_acceleration->x()).begin());
  _velocity->x()->scatter_fwd();
  _acceleration->x()->scatter_fwd();
}

void ImplicitStepper::start(std::optional<double> step)
{
  const TimeValues values = sample(step, 0.0);
  _equations->u->x()->scatter_fwd();
  _velocity->x()->scatter_fwd();
  const std::size_t n = num_owned();
  const std::span<const double> v = common::array(*_velocity->x());
  _motion.displacement.assign(u().begin(), u().begin() + n);
  _motion.velocity.assign(v.begin(), v.begin() + n);
  for (std::size_t i = 0; i < n; ++i)
    if (_equations->fixed[i])
      _motion.velocity[i] = values.velocity[i];
  std::vector<enforcement::Tie*> ties;
  for (const auto& contact : _equations->contacts)
    if (auto* const tie = dynamic_cast<enforcement::Tie*>(contact.get()))
      ties.push_back(tie);
  _motion.velocity = tied_rates(_body->inertia(), ties, _equations->fixed, _motion.velocity).rates;
  std::vector<double> rest = body_residual(values.factors);
  const std::vector<double> damping = _body->damping_forces(_motion);
  for (std::size_t i = 0; i < n; ++i)
    rest[i] = -(rest[i] + damping[i]);
  for (const auto& contact : _equations->contacts)
    if (!contact->has_multipliers())
    {
      const std::vector<double> pressed = contact->contact_forces();
      for (std::size_t i = 0; i < n; ++i)
        rest[i] += pressed[i];
    }
  TiedRates tied = tied_rates(_body->inertia(), ties, _equations->fixed,
                              _body->inertia().accelerations(rest, _equations->fixed, values.acceleration));
  for (std::size_t k = 0; k < ties.size(); ++k)
    ties[k]->assign(tied.multipliers[k]);
  _motion.acceleration = std::move(tied.rates);
  _motion.mean = _motion.acceleration;
  show_motion();
  for (std::size_t b = 0; b < _bodies.size(); ++b)
  {
    const auto [force, torque] = force_on(b);
    _bodies[b].body->start(values.body_forces[b], values.body_torques[b], force, torque);
  }
  _places = values.places;
  _angles = values.angles;
  _energy_balance.set_forces(forces(_motion, values));
}

state::State ImplicitStepper::state()
{
  const std::size_t bs = _equations->space().dofmap()->index_map_bs();
  state::State out("implicit problem");
  out.add("time", state::Place::all, _time);
  out.add("step", state::Place::all, _number);
  out.add("start", state::Place::node, _start_displacement, bs);
  out.add("largest displacement", state::Place::all, _largest_displacement);
  out.add(_motion.state(bs));
  out.add(_energy_balance.state(bs));
  out.add(_body->state());
  for (std::size_t b = 0; b < _bodies.size(); ++b)
    out.add(_bodies[b].body->state().state("rigid body " + std::to_string(b)));
  for (std::size_t k = 0; k < _equations->contacts.size(); ++k)
  {
    state::State part("contact " + std::to_string(k));
    part.add(_equations->contacts[k]->state());
    out.add(std::move(part));
  }
  return out;
}

void ImplicitStepper::resume()
{
  std::ranges::copy(_motion.displacement, u().begin());
  _equations->u->x()->scatter_fwd();
  show_motion();
  const TimeValues values = sample({}, _time);
  _places = values.places;
  _angles = values.angles;
  body_residual(values.factors); // stresses and energies of a restored history
}

void ImplicitStepper::update_gaps()
{
  for (const auto& contact : _equations->contacts)
    contact->update_gap(u());
}

/// Displacement, functions and contacts are those before a step that is given up; without communication, as an
/// exception may have come on one rank alone.
void ImplicitStepper::go_back(const Before& before)
{
  std::ranges::copy(before.displacement, u().begin());
  for (std::size_t k = 0; k < before.contacts.size(); ++k)
    _equations->contacts[k]->state().assign(before.contacts[k]);
  std::ranges::copy(before.velocity, common::array(*_velocity->x()).begin());
  std::ranges::copy(before.acceleration, common::array(*_acceleration->x()).begin());
}

/// Solve the equations of one step. Collective.
solve::Increment ImplicitStepper::attempt(double step, const TimeValues& values, const Solver& solver)
{
  const std::size_t n = num_owned();
  const auto& contacts = _equations->contacts;
  StepMotion motion(_scheme, step, _motion, _body->inertia().massless(), _equations->fixed, values);
  Function target(_equations->u->function_space());
  const std::span<double> goal = common::array(*target.x());
  for (std::size_t i = 0; i < n; ++i)
    goal[i] = _equations->fixed[i] ? values.displacement[i] : u()[i];
  target.x()->scatter_fwd();
  const Scaled scaled(*_excitation, values.factors);
  for (std::size_t b = 0; b < _bodies.size(); ++b)
    _bodies[b].body->begin_step(_scheme, step, values.body_forces[b], values.body_torques[b]);
  begin_contacts(values, step, goal);
  const std::vector<double> guess = motion.predictor();
  _body->begin_step(std::move(motion));
  if (contacts.empty()) // bodies that may touch begin where they are: contact is searched for from there
  {
    for (std::size_t i = 0; i < n; ++i)
      if (!_equations->fixed[i])
        u()[i] = guess[i];
    _equations->u->x()->scatter_fwd();
  }
  return solver(goal);
}

double ImplicitStepper::size(std::span<const double> values) const
{
  std::array<double, 2> sums{};
  for (std::size_t i = 0; i < values.size(); ++i)
  {
    sums[0] += _total_mass[i] * values[i] * values[i];
    sums[1] += _total_mass[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_DOUBLE, MPI_SUM, _equations->comm());
  return std::sqrt(sums[0] / sums[1]);
}

/// Estimate of the local error of the displacement, relative to the largest displacement so far [1]; nothing without a
/// tolerance. Collective.
std::optional<double> ImplicitStepper::error(const Motion& motion, double step, const StepControl& control)
{
  if (!control.tolerance())
    return {};
  const std::size_t n = num_owned();
  std::vector<double> change(n), moved(n), travel(n);
  for (std::size_t i = 0; i < n; ++i)
  {
    change[i] = _scheme.error_constant() * step * step * (motion.mean[i] - _motion.mean[i]);
    moved[i] = motion.displacement[i] - _start_displacement[i];
    travel[i] = step * motion.velocity[i];
  }
  _largest_displacement = std::max({_largest_displacement, size(moved), size(travel)});
  return _largest_displacement > 0.0 ? size(change) / _largest_displacement : 0.0;
}

/// Take over a converged step: history, contacts, works, functions. Collective.
void ImplicitStepper::accept(Motion motion, const TimeValues& values)
{
  for (const auto& contact : _equations->contacts)
    contact->accept_step();
  Forces present = forces(motion, values);
  _body->accept_step();
  for (std::size_t b = 0; b < _bodies.size(); ++b)
  {
    ImplicitRigidBody& body = *_bodies[b].body;
    const auto [force, torque] = force_on(b);
    body.accept(body.solution, force, torque);
  }
  std::vector<std::array<double, 3>> turned;
  for (std::size_t k = 0; k < _angles.size(); ++k)
    turned.push_back(gap::angle_of(
        gap::product(gap::quaternion_of(values.angles[k]), gap::inverse(gap::quaternion_of(_angles[k])))));
  _energy_balance.add_step(_equations->comm(), std::move(present), _motion.displacement, motion.displacement, _places,
                           values.places, turned);
  _places = values.places;
  for (const Rigid& rigid : _bodies) // their own account has their work
    for (std::size_t k : rigid.contacts)
      _places[k] = rigid.body->state().displacement;
  _angles = values.angles;
  _motion = std::move(motion);
  show_motion();
  _time = values.time;
  ++_number;
}

void ImplicitStepper::take_step(double goal, StepControl& control, const Solver& solver, const ImplicitEvents& events)
{
  const auto log = [&](const std::string& line)
  {
    if (events.log)
      events.log(line);
  };
  const auto update = [&](double time)
  {
    if (events.update)
      events.update(time);
  };
  for (;;)
  {
    const auto [step, end] = control.next(_time, goal);
    goal = end; // shorter steps lead to the end of one that was given up
    log("step " + std::to_string(_number + 1) + ": to the time " + text("%.6g", end) + ", length " +
        text("%.3e", step));
    // What others wrote into the displacement function since the last step does not count.
    std::ranges::copy(_motion.displacement, u().begin());
    _equations->u->x()->scatter_fwd();
    Before before{copy_of(*_equations->u), copy_of(*_velocity), copy_of(*_acceleration), {}};
    for (const auto& contact : _equations->contacts)
      before.contacts.push_back(contact->state().copy());
    update(end);
    TimeValues values = sample(step, end);
    solve::Increment increment;
    try
    {
      increment = attempt(step, values, solver);
      if (increment.fault.empty())
      {
        std::vector<std::string> overlaps;
        for (const auto& contact : _equations->contacts)
          overlaps.push_back(contact->prescribed_overlap());
        if (const std::string found = common::joined(overlaps); !found.empty())
          increment.failed(found, true);
      }
    }
    catch (const common::OnAllRanks&)
    {
      go_back(before);
      update_gaps();
      throw;
    }
    catch (...) // an interrupt, a user's function on one rank alone: return to the last converged state
    {
      go_back(before);
      throw;
    }
    _iterations = increment.iterations;
    if (increment.fault.empty())
    {
      Motion motion = _body->end_of_step();
      const std::optional<double> found = error(motion, step, control);
      if (control.accepts(step, found))
      {
        accept(std::move(motion), values);
        control.choose_next_step(step, _iterations, found);
        return;
      }
      ++_rejected;
      log("  the local error is " + text("%.1e", *found) + ": repeated with a step of " +
          text("%.3e", control.length()));
      go_back(before);
      update_gaps();
      continue;
    }
    go_back(before);
    update_gaps();
    const bool hopeless = increment.hopeless;
    if (hopeless || !control.failed(step))
    {
      update(_time);
      throw common::Failure(increment.fault +
                            (hopeless ? " (at the time " + text("%.6g", end) + ")"
                                      : " in the step to the time " + text("%.6g", end) + ", of length " +
                                            text("%.3e", step) + "; the problem is at the time " + text("%.6g", _time) +
                                            ". Take a smaller step, or pass more iterations"));
    }
    ++_cut_backs;
    log("  cut back to a step of " + text("%.3e", control.length()) + ": " + increment.fault);
  }
}

Energies ImplicitStepper::energies()
{
  Energies out;
  out.kinetic = 0.5 * sum(_equations->comm(), _motion.velocity, _body->inertia().times(_motion.velocity));
  const Works& works = _energy_balance.works();
  const std::optional<double> stored = _body->stored_energy();
  out.internal = stored.value_or(works.internal);
  if (_body->properties().inelastic)
    out.plastic = works.internal - out.internal;
  for (const auto& contact : _equations->contacts)
  {
    out.contact += contact->stored_energy();
    out.friction += contact->dissipated();
  }
  out.damping = works.damping;
  out.external = works.external;
  for (const Rigid& rigid : _bodies)
  {
    out.kinetic += rigid.body->kinetic_energy();
    out.external += rigid.body->state().work;
  }
  return out;
}
} // namespace dolfinx_impact::integrators
