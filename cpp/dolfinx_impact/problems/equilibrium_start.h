// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/StaticContact.h"
#include "ExplicitProblem.h"
#include "RunObserver.h"
#include <memory>
#include <vector>

namespace dolfinx_impact::problems
{
/// Begin an explicit run from an equilibrium with contact: bodies that press are moved against their master until the
/// springs bear the static force, and springs begin with the static forces of the nodes; docs/explicit/penalty.md, "A
/// start under load". Collective.
///
/// Penalty springs of the equilibrium are compressed like those of the run: for them the approach is enough. Internal
/// variables are the caller's to hand over, before.
/// @param[in,out] problem in the displacement of the equilibrium, no step made; its contacts are NodePenalty
/// @param[in] contacts of the equilibrium, in the order of the problem's
/// @param[in] observer as of ExplicitProblem::start
/// @throws std::invalid_argument for another number of contacts, or contacts of another kind
/// @throws common::Failure if springs do not bear the static force
void start_from_equilibrium(ExplicitProblem& problem,
                            const std::vector<std::shared_ptr<const enforcement::StaticContact>>& contacts,
                            RunObserver& observer);
/// The same without an observer.
void start_from_equilibrium(ExplicitProblem& problem,
                            const std::vector<std::shared_ptr<const enforcement::StaticContact>>& contacts);
} // namespace dolfinx_impact::problems
