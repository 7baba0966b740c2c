// SPDX-License-Identifier: MIT
#pragma once
#include "StaticProblem.h"

namespace dolfinx_impact::problems
{
/// What the next solve of a static problem starts from, values of its own: displacement, loads that were reached, and
/// as parts internal variables ("material") and contacts (contact0, contact1, ...). Collective.
state::State saved_state(StaticProblem& problem);

/// Go on from what `saved_state` has returned, perhaps on other ranks. Collective.
/// @throws std::out_of_range for the state of another problem
void resume(StaticProblem& problem, const state::State& saved);
} // namespace dolfinx_impact::problems
