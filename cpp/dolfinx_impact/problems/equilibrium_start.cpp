// SPDX-License-Identifier: MIT
#include "equilibrium_start.h"
#include "../common/dolfinx_api.h"
#include "../common/gather.h"
#include "../enforcement/mortar/Tie.h"
#include "../operators/saved_history.h"
#include "SpringStart.h"
#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace dolfinx_impact::problems
{
namespace
{
/// Internal variables of the bodies.
operators::Histories histories_of(const ExplicitBody& body)
{
  operators::Histories out;
  for (operators::InternalForce* force : body.internal.parts())
    for (std::size_t i = 0; i < force->num_integrals(); ++i)
      if (auto history = force->history(i))
        out.push_back(std::move(history));
  return out;
}
} // namespace

void start_from_equilibrium(ExplicitProblem& problem, const solve::EquilibriumProblem& equilibrium,
                            RunObserver& observer)
{
  const auto& contacts = equilibrium.contacts;
  if (contacts.size() != problem.contacts().size())
    throw std::invalid_argument("the equilibrium has " + std::to_string(contacts.size()) +
                                " contacts, the explicit problem " + std::to_string(problem.contacts().size()));
  operators::resume_history(histories_of(problem.body()), equilibrium.body->saved_state());
  MPI_Comm comm = problem.displacement()->function_space()->mesh()->comm();
  const auto u = problem.displacement();
  std::vector<SpringStart> starts;
  for (std::size_t k = 0; k < contacts.size(); ++k)
  {
    if (dynamic_cast<const enforcement::Tie*>(contacts[k].get()))
      continue; // every step solves for the forces of ties
    const bool presses = std::ranges::any_of(contacts[k]->pressure(), [](double p) { return p > 0.0; });
    if (common::largest(comm, presses ? 1.0 : 0.0) == 0.0)
      continue;
    SpringStart start(contacts[k], problem, k, false);
    start.move(common::array(*u->x()), start.approach());
    if (contacts[k]->has_multipliers() || !start.can_approach())
      starts.push_back(std::move(start));
  }
  for (const ContactInTime& c : problem.contacts())
    for (const auto& direction : c.contact.directions())
      direction->reset();
  problem.start(observer);
  if (starts.empty())
    return;
  bool closes = false;
  for (SpringStart& start : starts)
    closes = start.close_nodes() || closes;
  if (closes)
    problem.start(observer);
  for (SpringStart& start : starts)
    start.hand_over();
  problem.start(observer);
}

void start_from_equilibrium(ExplicitProblem& problem, const solve::EquilibriumProblem& equilibrium)
{
  RunObserver nobody;
  start_from_equilibrium(problem, equilibrium, nobody);
}
} // namespace dolfinx_impact::problems
