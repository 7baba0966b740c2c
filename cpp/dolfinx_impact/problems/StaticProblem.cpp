// SPDX-License-Identifier: MIT
#include "StaticProblem.h"
#include "../common/dolfinx_api.h"
#include "../operators/body_size.h"
#include "../operators/petsc_check.h"
#include "OneCall.h"
#include <algorithm>
#include <stdexcept>

namespace dolfinx_impact::problems
{
std::vector<std::int8_t> prescribed_dofs(const dolfinx::fem::FunctionSpace<double>& V, const BoundaryConditions& bcs)
{
  const auto& dofmap = *V.dofmap();
  std::vector<std::int8_t> fixed(
      (dofmap.index_map->size_local() + dofmap.index_map->num_ghosts()) * dofmap.index_map_bs(), 0);
  for (const auto& bc : bcs)
    for (std::int32_t dof : bc->dof_indices().first)
      fixed[dof] = 1;
  return fixed;
}

StaticProblem::StaticProblem(std::shared_ptr<dolfinx::fem::Function<double>> u, std::shared_ptr<solve::Body> body,
                             BoundaryConditions bcs, std::vector<std::shared_ptr<enforcement::StaticContact>> contacts,
                             const SolverOptions& options)
    : _bcs(std::move(bcs))
{
  std::vector<std::int8_t> fixed = prescribed_dofs(*u->function_space(), _bcs);
  _equilibrium =
      make_equilibrium(std::move(u), std::move(body), std::move(contacts), std::move(fixed), options, "impact_static_");
  for (const auto& contact : _equilibrium->contacts)
    _obstacles.push_back(contact->displacement());
}

void StaticProblem::share_linear_solver(const StaticProblem& other)
{
  solve::EquilibriumProblem& mine = *_equilibrium;
  const solve::EquilibriumProblem& theirs = *other._equilibrium;
  const auto &here = *mine.space().dofmap(), &there = *theirs.space().dofmap();
  if (here.index_map != there.index_map || here.index_map_bs() != there.index_map_bs())
    throw std::invalid_argument("problems that share a linear solver have displacements on one space");
  if (mine.keeps_multipliers || theirs.keeps_multipliers)
    throw std::invalid_argument("problems whose multipliers stay in the linear systems have linear solvers of their "
                                "own");
  mine.linear_solver = theirs.linear_solver;
  mine.linear_solver->begin_problem();
  mine.exact_tangent = theirs.exact_tangent;
}

void StaticProblem::add_load(std::span<double> forces)
{
  _reached.push_back(std::make_unique<std::vector<double>>(forces.size(), 0.0));
  add_load({forces, *_reached.back()});
}

void StaticProblem::add_load(solve::Ramp load)
{
  if (load.value.size() != load.reached.size())
    throw std::invalid_argument("a load has " + std::to_string(load.value.size()) + " values, and has reached " +
                                std::to_string(load.reached.size()));
  _loads.push_back(load);
}

void StaticProblem::move_obstacle(std::size_t contact, const std::array<double, 3>& displacement)
{
  if (!_obstacles.at(contact))
    throw std::invalid_argument(_equilibrium->contacts[contact]->name() + " has no obstacle that could be moved");
  _obstacles[contact] = displacement;
}

void StaticProblem::turn_obstacle(std::size_t contact, solve::Ramp angle)
{
  const enforcement::StaticContact& turned = *_equilibrium->contacts.at(contact);
  if (!turned.rotation() || angle.value.size() != 3)
    throw std::invalid_argument(turned.name() + " has no rigid master that turns by three components");
  add_load(angle);
  _angles.emplace_back(contact, angle.value);
}

void StaticProblem::add_rigid_body(std::vector<std::size_t> contacts, const std::array<bool, 6>& fixed,
                                   std::span<const double> force, std::span<const double> torque)
{
  if (contacts.empty())
    throw std::invalid_argument("a rigid body of a problem is the master of a contact");
  const auto body =
      std::make_shared<StaticRigidBody>(fixed, force, torque, _equilibrium->contacts.at(contacts.front())->centre(),
                                        operators::body_size(*_equilibrium->space().mesh()));
  RigidEquilibrium(_equilibrium, {{body, contacts}});
  _rigid_bodies.push_back({body, std::move(contacts)});
}

void StaticProblem::check(const SolveOptions& options) const
{
  if (options.steps < 1 || options.max_iterations < 1 || options.cut_backs.value_or(0) < 0)
    throw std::invalid_argument("a solve has one step and one iteration at least, and no negative number of cut_backs");
  if (!(options.rtol >= 0.0 && options.rtol < 1.0) || !(options.atol >= 0.0))
    throw std::invalid_argument("tolerances are rtol from 0 to 1 and atol not negative");
}

solve::LoadStepReport StaticProblem::solve(const SolveOptions& options, const SolveEvents& events)
{
  check(options);
  const OneCall call(_solving, "solve");
  solve::NewtonOptions newton;
  newton.rtol = options.rtol;
  newton.atol = options.atol;
  newton.max_iterations = options.max_iterations;
  _solver = std::make_unique<solve::IncrementSolver>(_equilibrium, newton, events.newton);
  solve::LoadStepReport report;
  try
  {
    report = solve([this](std::span<const double> goal) { return _solver->run(goal); }, options, events.steps);
  }
  catch (...)
  {
    _solver->tell_nobody();
    throw;
  }
  report.seconds = _solver->seconds();
  _solver->free();
  _solver.reset();
  return report;
}

solve::LoadStepReport StaticProblem::solve(const solve::LoadSteps::Solver& solver, const SolveOptions& options,
                                           const solve::LoadStepEvents& events)
{
  const solve::EquilibriumProblem& p = *_equilibrium;
  check(options);
  // Rigid bodies begin where they are.
  for (const Rigid& body : _rigid_bodies)
    for (std::size_t k : body.contacts)
      _obstacles[k] = p.contacts[k]->displacement();
  for (const auto& contact : p.contacts)
  {
    contact->check_without_time();
    contact->check_parameters();
  }
  dolfinx::la::Vector<double> target(*p.u->x());
  for (const auto& bc : _bcs)
    bc->set(common::array(target), std::nullopt, 1.0);
  target.scatter_fwd();
  solve::LoadSteps steps(_equilibrium, {target.array().begin(), target.array().end()}, _loads, _obstacles, events);
  for (const auto& [contact, angle] : _angles)
    steps.turn(contact, angle);
  const int several = p.contacts.empty() && options.steps == 1 ? 0 : 8;
  const solve::LoadStepOptions limits{options.steps, options.cut_backs.value_or(several), options.brings_together};
  if (!_rigid_bodies.empty())
  {
    std::vector<RigidMember> members;
    for (const Rigid& body : _rigid_bodies)
      members.push_back({body.body, body.contacts});
    RigidEquilibrium rigid(_equilibrium, members, events.log);
    const auto solve = [&](std::span<const double> goal)
    {
      for (const Rigid& body : _rigid_bodies)
      {
        const enforcement::StaticContact& contact = *p.contacts[body.contacts.front()];
        body.body->begin({*contact.displacement(), contact.rotation().value_or(gap::identity)});
      }
      return rigid.run(solver, goal);
    };
    return steps.run(solve, limits);
  }
  return steps.run(solver, limits);
}

void StaticProblem::resume()
{
  _equilibrium->u->x()->scatter_fwd();
}

void StaticProblem::forget()
{
  _equilibrium->linear_solver->reset();
  for (const auto& contact : _equilibrium->contacts)
    contact->forget();
}

std::vector<double> StaticProblem::reactions()
{
  Vec b = _equilibrium->body->residual();
  for (const auto& contact : _equilibrium->contacts)
    contact->add_residual(b);
  return operators::values_of(b, _equilibrium->num_owned());
}

state::State StaticProblem::state()
{
  state::State out("static problem");
  const auto u = _equilibrium->u->x();
  const std::size_t bs = _equilibrium->space().dofmap()->index_map_bs();
  out.add("displacement", state::Place::node, state::View(common::array(*u).subspan(0, _equilibrium->num_owned())), bs);
  out.add(_equilibrium->body->state());
  for (std::size_t i = 0; i < _loads.size(); ++i)
    out.add("load " + std::to_string(i), state::Place::rank, state::View(_loads[i].reached));
  for (std::size_t i = 0; i < _equilibrium->contacts.size(); ++i)
  {
    state::State part("contact " + std::to_string(i));
    part.add(_equilibrium->contacts[i]->state());
    out.add(std::move(part));
  }
  return out;
}
} // namespace dolfinx_impact::problems
