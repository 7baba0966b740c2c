// SPDX-License-Identifier: MIT
#include "StaticProblem.h"
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

void StaticProblem::add_load(std::span<double> forces)
{
  _loads.push_back(forces);
  _reached.emplace_back(forces.size(), 0.0);
}

void StaticProblem::move_obstacle(std::size_t contact, const std::array<double, 3>& displacement)
{
  if (!_obstacles.at(contact))
    throw std::invalid_argument(_equilibrium->contacts[contact]->name() + " has no obstacle that could be moved");
  _obstacles[contact] = displacement;
}

solve::LoadStepReport StaticProblem::solve(const SolveOptions& options)
{
  const solve::EquilibriumProblem& p = *_equilibrium;
  if (options.steps < 1 || options.max_iterations < 1 || options.cut_backs.value_or(0) < 0)
    throw std::invalid_argument("a solve has one step and one iteration at least, and no negative number of cut_backs");
  if (!(options.rtol >= 0.0 && options.rtol < 1.0) || !(options.atol >= 0.0))
    throw std::invalid_argument("tolerances are rtol from 0 to 1 and atol not negative");
  p.u->x()->scatter_fwd(); // a state that was assigned has owned values only
  const std::span<const double> u = p.u->x()->array();
  std::vector<double> target(u.begin(), u.end());
  for (const auto& bc : _bcs)
    bc->set(target, std::nullopt, 1.0);
  std::vector<solve::Ramp> ramps;
  for (std::size_t i = 0; i < _loads.size(); ++i)
    ramps.push_back({_loads[i], _reached[i]});
  for (const auto& contact : p.contacts)
    contact->check_parameters();
  solve::NewtonOptions newton;
  newton.rtol = options.rtol;
  newton.atol = options.atol;
  newton.max_iterations = options.max_iterations;
  solve::Newton solver(_equilibrium, newton.with_database(p.linear_solver->prefix()));
  solve::LoadSteps steps(_equilibrium, std::move(target), std::move(ramps), _obstacles);
  const int several = p.contacts.empty() && options.steps == 1 ? 0 : 8;
  return steps.run([&solver](std::span<const double> goal) { return solver.run(goal); },
                   {options.steps, options.cut_backs.value_or(several)});
}

state::State StaticProblem::state()
{
  state::State out("static problem");
  const auto u = _equilibrium->u->x();
  const std::size_t bs = _equilibrium->space().dofmap()->index_map_bs();
  out.add("displacement", state::Place::node, state::View(u->mutable_array().subspan(0, _equilibrium->num_owned())),
          bs);
  out.add(_equilibrium->body->state());
  for (std::size_t i = 0; i < _reached.size(); ++i)
    out.add("load " + std::to_string(i), state::Place::rank, _reached[i]);
  for (std::size_t i = 0; i < _equilibrium->contacts.size(); ++i)
  {
    state::State part("contact " + std::to_string(i));
    part.add(_equilibrium->contacts[i]->state());
    out.add(std::move(part));
  }
  return out;
}
} // namespace dolfinx_impact::problems
