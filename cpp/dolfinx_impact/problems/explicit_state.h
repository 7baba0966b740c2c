// SPDX-License-Identifier: MIT
#pragma once
#include "ExplicitProblem.h"

namespace dolfinx_impact::problems
{
/// What an explicit problem goes on from, values of its own: times, steps, energies, stable step, and as parts the
/// integrator and the directions of the contacts (contact0_0, contact0_1, contact1_0, ...). Not: internal variables of
/// materials (operators::PointHistory::state), and the schedule of an `advance` that was left. Collective.
state::State saved_state(ExplicitProblem& problem);

/// A state of that structure whose values do not matter; nothing is computed.
state::State empty_state(ExplicitProblem& problem);

/// Go on from what `saved_state` has returned, perhaps on other ranks. Internal variables must have been set before.
/// Collective.
/// @param[in] schedule steps of an `advance` that was left; nothing: there was none
/// @throws std::invalid_argument for the state of another problem
void resume(ExplicitProblem& problem, const state::State& saved,
            const std::optional<integrators::StepSchedule>& schedule, RunObserver& observer);
} // namespace dolfinx_impact::problems
