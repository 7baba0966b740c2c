// SPDX-License-Identifier: MIT
#pragma once
#include "../solve/EquilibriumProblem.h"
#include "ExplicitProblem.h"
#include "RunObserver.h"

namespace dolfinx_impact::problems
{
/// Begin an explicit run from an equilibrium: internal variables become those of its bodies, bodies that press are
/// moved against their master until the springs bear the static force, and springs begin with the static forces of the
/// nodes; docs/explicit/penalty.md. Collective.
///
/// Penalty springs of the equilibrium are compressed like those of the run: for them the approach is enough, and nodes
/// that roll into the contact later find the same springs as those that are in it. Where supports hold the bodies
/// against each other there is no approach, and nodal forces are handed over as those of multipliers are.
/// @param[in,out] problem in the displacement of the equilibrium, no step made; its contacts are NodePenalty
/// @param[in] equilibrium of the same materials, its contacts in the order of the problem's
/// @param[in] observer as of ExplicitProblem::start
/// @throws std::invalid_argument for another number of contacts, contacts of another kind, other internal variables
/// @throws common::Failure if springs do not bear the static force
void start_from_equilibrium(ExplicitProblem& problem, const solve::EquilibriumProblem& equilibrium,
                            RunObserver& observer);
/// The same without an observer.
void start_from_equilibrium(ExplicitProblem& problem, const solve::EquilibriumProblem& equilibrium);
} // namespace dolfinx_impact::problems
