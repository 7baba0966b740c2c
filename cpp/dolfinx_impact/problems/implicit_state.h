// SPDX-License-Identifier: MIT
#pragma once
#include "NewmarkProblem.h"

namespace dolfinx_impact::problems
{
/// What an implicit problem goes on from, values of its own: motion, forces, works, lengths of steps, energies of the
/// start, and as parts internal variables ("material") and contacts (contact0, contact1, ...). Collective.
state::State saved_state(NewmarkProblem& problem);

/// Go on from what `saved_state` has returned, perhaps on other ranks. The history of steps begins anew. Collective.
/// @throws std::out_of_range for the state of another problem
void resume(NewmarkProblem& problem, const state::State& saved);
} // namespace dolfinx_impact::problems
