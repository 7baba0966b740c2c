// SPDX-License-Identifier: MIT
#include "make_equilibrium.h"
#include "../enforcement/mortar/MortarContact.h"
#include "../enforcement/mortar/shared_nodes.h"
#include "../enforcement/mortar/tied_nodes.h"
#include "../operators/PetscErrorText.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <stdexcept>

namespace dolfinx_impact::problems
{
namespace
{
/// Owned degrees of freedom of every field of a mixed space; none for other spaces.
std::vector<std::vector<std::int32_t>> field_dofs(const dolfinx::fem::FunctionSpace<double>& V)
{
  std::vector<std::vector<std::int32_t>> out;
  if (!V.element()->is_mixed())
    return out;
  const auto cells = V.dofmap()->map();
  const std::int32_t num_owned = V.dofmap()->index_map->size_local(); // the block size of mixed spaces is 1
  std::size_t first = 0;
  for (const auto& element : V.element()->sub_elements())
  {
    std::vector<std::int32_t>& dofs = out.emplace_back();
    const std::size_t size = element->space_dimension();
    for (std::size_t cell = 0; cell < cells.extent(0); ++cell)
      for (std::size_t i = first; i < first + size; ++i)
        if (cells(cell, i) < num_owned)
          dofs.push_back(cells(cell, i));
    std::ranges::sort(dofs);
    dofs.erase(std::ranges::unique(dofs).begin(), dofs.end());
    first += size;
  }
  return out;
}

/// Whether multipliers are condensed where they can be: the option contact_condense, on the command line or given.
/// @throws std::invalid_argument if its value is neither true nor false
bool condenses(const SolverOptions& options, const std::string& prefix)
{
  const operators::PetscErrorText error;
  PetscBool found = PETSC_TRUE, given = PETSC_FALSE;
  PetscErrorCode code = PetscOptionsGetBool(nullptr, prefix.c_str(), "-contact_condense", &found, &given);
  const auto own = options.petsc.find("contact_condense");
  if (!code && !given && own != options.petsc.end() && !own->second.empty()) // without a value it is true
    code = PetscOptionsStringToBool(own->second.c_str(), &found);
  if (code)
    throw std::invalid_argument("the option contact_condense of " + prefix + " is true or false: " + error.text());
  return found == PETSC_TRUE;
}

/// Tell PETSc's database that the option has been read. The linear solver has copied it to a prefix of its own.
void mark_as_read(const std::string& prefix)
{
  PetscBool found = PETSC_TRUE;
  operators::check(PetscOptionsGetBool(nullptr, prefix.c_str(), "-contact_condense", &found, nullptr),
                   "options are read");
}
} // namespace

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
    if (enforcement::MortarContact* mortar = contact->mortar())
      multipliers.push_back(mortar);
  std::vector<enforcement::Tie*> ties;
  for (const auto& contact : p.contacts)
    if (auto* const tie = dynamic_cast<enforcement::Tie*>(contact.get()))
      ties.push_back(tie);
  const std::string common = options.prefix.empty() ? prefix : options.prefix;
  const bool shared = enforcement::connect(multipliers), tied = enforcement::connect(ties, multipliers);
  const bool condense = condenses(options, common);
  p.keeps_multipliers = shared || tied || ((!multipliers.empty() || !ties.empty()) && !condense) ||
                        std::ranges::any_of(multipliers, [](const enforcement::MortarContact* contact)
                                            { return contact->options().basis != gap::Multipliers::dual; }) ||
                        std::ranges::any_of(ties, [](const enforcement::Tie* tie)
                                            { return tie->conditions().options().basis != gap::Multipliers::dual; });
  p.linear_solver = std::make_shared<solve::LinearSolver>(*V, options.petsc, common, p.keeps_multipliers,
                                                          options.limits, options.warn);
  mark_as_read(p.linear_solver->prefix());
  // The tangent of multiplier forces between deformable bodies is not symmetric, and conjugate gradients do not
  // converge with it: their product with the last guess is on the right-hand side then.
  p.exact_tangent = p.linear_solver->direct();
  p.fields = field_dofs(*V);
  return out;
}
} // namespace dolfinx_impact::problems
