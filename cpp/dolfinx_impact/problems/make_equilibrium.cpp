// SPDX-License-Identifier: MIT
#include "make_equilibrium.h"
#include "../enforcement/mortar/MortarContact.h"
#include "../enforcement/mortar/shared_nodes.h"
#include <algorithm>

namespace dolfinx_impact::problems
{
std::shared_ptr<solve::EquilibriumProblem>
make_equilibrium(std::shared_ptr<dolfinx::fem::Function<double>> u, std::shared_ptr<solve::Body> body,
                 std::vector<std::shared_ptr<enforcement::StaticContact>> contacts, std::vector<std::int8_t> fixed,
                 const SolverOptions& options, const std::string& prefix)
{
  const auto V = u->function_space();
  auto out = std::make_shared<solve::EquilibriumProblem>();
  solve::EquilibriumProblem& p = *out;
  p.u = std::move(u);
  p.body = std::move(body);
  p.contacts = std::move(contacts);
  p.fixed = std::move(fixed);
  p.axisymmetric = options.axisymmetric;
  // Only multipliers with the dual basis can be condensed, and only one constraint at a node.
  std::vector<enforcement::MortarContact*> multipliers;
  for (const auto& contact : p.contacts)
    if (auto* mortar = dynamic_cast<enforcement::MortarContact*>(contact.get()))
      multipliers.push_back(mortar);
  p.keeps_multipliers = enforcement::connect(multipliers) ||
                        std::ranges::any_of(multipliers, [](const enforcement::MortarContact* contact)
                                            { return contact->options().basis != gap::Multipliers::dual; });
  p.linear_solver = std::make_shared<solve::LinearSolver>(
      *V, options.petsc, options.prefix.empty() ? prefix : options.prefix, p.keeps_multipliers);
  // The tangent of multiplier forces between deformable bodies is not symmetric, and conjugate gradients do not
  // converge with it: their product with the last guess is on the right-hand side then.
  p.exact_tangent = p.linear_solver->direct();
  return out;
}
} // namespace dolfinx_impact::problems
