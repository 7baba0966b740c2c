// SPDX-License-Identifier: MIT
#include "implicit_state.h"
#include "../common/dolfinx_api.h"
#include "../state/numbers.h"
#include "contact_states.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

using dolfinx_impact::state::add_number;
using dolfinx_impact::state::number;
using dolfinx_impact::state::Place;
using dolfinx_impact::state::State;
using dolfinx_impact::state::vector;

namespace dolfinx_impact::problems
{
namespace
{
constexpr double none = std::numeric_limits<double>::quiet_NaN(); // of step lengths

std::optional<integrators::StepControl> control_of(const State& saved)
{
  const double length = number<double>(saved, "step length"), tolerance = number<double>(saved, "step tolerance");
  if (std::isnan(length))
    return {};
  return integrators::StepControl(number<double>(saved, "step largest"), number<double>(saved, "step smallest"),
                                  std::isnan(tolerance) ? std::nullopt : std::optional(tolerance), length,
                                  number<double>(saved, "step last"));
}
} // namespace

State saved_state(NewmarkProblem& problem)
{
  const solve::EquilibriumProblem& p = *problem.equilibrium();
  integrators::ImplicitStepper& stepper = problem.stepper();
  const integrators::Motion& motion = stepper.motion();
  const integrators::Forces& forces = stepper.energy_balance().forces();
  const integrators::Works& works = stepper.energy_balance().works();
  const std::optional<integrators::StepControl>& control = problem.control();
  const std::size_t bs = p.space().dofmap()->index_map_bs();
  State out("implicit problem");
  out.add_own("displacement", Place::node, motion.displacement, bs);
  out.add_own("velocity", Place::node, motion.velocity, bs);
  out.add_own("acceleration", Place::node, motion.acceleration, bs);
  out.add_own("mean", Place::node, motion.mean, bs);
  out.add_own("force internal", Place::node, forces.internal, bs);
  out.add_own("force external", Place::node, forces.external, bs);
  out.add_own("force damping", Place::node, forces.damping, bs);
  out.add_own("force support", Place::node, forces.support, bs);
  out.add_own("start", Place::node, stepper.start_displacement(), bs);
  if (State bodies = p.body->saved_state(); !bodies.fields().empty())
    out.add(std::move(bodies));
  add_number(out, "time", stepper.time());
  add_number(out, "step", stepper.step());
  add_number(out, "largest", problem.history().largest());
  add_number(out, "total_start", problem.history().total_start().value_or(0.0));
  add_number(out, "largest_displacement", stepper.largest_displacement());
  add_number(out, "work internal", works.internal);
  add_number(out, "work external", works.external);
  add_number(out, "work damping", works.damping);
  add_number(out, "step length", control ? control->length() : none);
  add_number(out, "step largest", control ? control->largest() : none);
  add_number(out, "step smallest", control ? control->smallest() : none);
  add_number(out, "step last", control ? control->last() : none);
  add_number(out, "step tolerance", control ? control->tolerance().value_or(none) : none);
  std::vector<double> obstacles;
  for (const auto& force : forces.obstacles)
    obstacles.insert(obstacles.end(), force.begin(), force.end());
  out.add_own("obstacles", Place::all, std::move(obstacles));
  if (std::ranges::any_of(p.contacts, [](const auto& contact) { return contact->rotation().has_value(); }))
  {
    std::vector<double> torques;
    for (const auto& torque : forces.torques)
      torques.insert(torques.end(), torque.begin(), torque.end());
    out.add_own("torques", Place::all, std::move(torques));
  }
  if (const RigidEquilibrium* const rigid = problem.rigid_equilibrium())
    out.add_own("rigid stiffness", Place::all, rigid->stiffness());
  for (std::size_t b = 0; b < problem.rigid_bodies().size(); ++b)
    out.add(problem.rigid_bodies()[b].body->state().state("rigid body " + std::to_string(b)).copy());
  add_contacts(out, p.contacts);
  return out;
}

void resume(NewmarkProblem& problem, const State& saved)
{
  const solve::EquilibriumProblem& p = *problem.equilibrium();
  integrators::ImplicitStepper& stepper = problem.stepper();
  const auto obstacles = saved.values<double>("obstacles");
  const auto displacement = saved.values<double>("displacement");
  if (obstacles.size() != 3 * p.contacts.size() || displacement.size() != p.num_owned())
    throw std::invalid_argument("the state of an implicit problem with other contacts or degrees of freedom");
  stepper.start_displacement() = vector(saved, "start");
  std::ranges::copy(displacement, common::array(*p.u->x()).begin());
  p.u->x()->scatter_fwd();
  if (const State bodies = p.body->saved_state(); !bodies.fields().empty())
    p.body->resume(saved.part("material"));
  stepper.set_motion(
      {vector(saved, "displacement"), vector(saved, "velocity"), vector(saved, "acceleration"), vector(saved, "mean")});
  stepper.set_time(number<double>(saved, "time"), saved.values<std::int64_t>("step")[0]);
  stepper.largest_displacement() = number<double>(saved, "largest_displacement");
  problem.set_control(control_of(saved));
  resume_contacts(saved, p.contacts, p.u->x()->array());
  stepper.energy_balance().set_works({number<double>(saved, "work internal"), number<double>(saved, "work external"),
                                      number<double>(saved, "work damping")});
  integrators::Forces forces{vector(saved, "force internal"),
                             vector(saved, "force external"),
                             vector(saved, "force damping"),
                             vector(saved, "force support"),
                             {}};
  for (std::size_t k = 0; k < p.contacts.size(); ++k)
    forces.obstacles.push_back({obstacles[3 * k], obstacles[3 * k + 1], obstacles[3 * k + 2]});
  forces.torques.resize(p.contacts.size());
  if (std::ranges::any_of(p.contacts, [](const auto& contact) { return contact->rotation().has_value(); }))
  {
    const auto torques = saved.values<double>("torques");
    for (std::size_t k = 0; k < 3 * p.contacts.size(); ++k)
      forces.torques[k / 3][k % 3] = torques[k];
  }
  if (problem.rigid_equilibrium())
    problem.rigid_equilibrium()->set_stiffness(vector(saved, "rigid stiffness"));
  for (std::size_t b = 0; b < problem.rigid_bodies().size(); ++b)
  {
    const std::string name = "rigid body " + std::to_string(b);
    problem.rigid_bodies()[b].body->state().state(name).assign(saved.part(name));
  }
  stepper.energy_balance().set_forces(std::move(forces));
  problem.history().resume(number<double>(saved, "total_start"), number<double>(saved, "largest"));
  stepper.resume();
  problem.set_time();
}
} // namespace dolfinx_impact::problems
