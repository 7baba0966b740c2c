// SPDX-License-Identifier: MIT
#pragma once
#include "ExplicitProblem.h"

namespace dolfinx_impact::problems
{
/// What an explicit problem goes on from, values of its own: times, steps, energies, stable step, and as parts the
/// integrator, the directions of the contacts (contact0_0, contact0_1, contact1_0, ...) and internal variables
/// (operators/saved_history.h). Not: constants, loads and functions of time, and the schedule of an `advance` that was
/// left, which `stepper().schedule()` is. Contact is searched anew in the next step. Collective.
state::State saved_state(ExplicitProblem& problem);

/// A state of that structure whose values do not matter; nothing is computed.
state::State empty_state(ExplicitProblem& problem);

/// Go on from what `saved_state` has returned, perhaps on other ranks. Collective.
/// @param[in] schedule steps of an `advance` that was left; nothing: there was none
/// @throws std::logic_error for the state of another problem: std::invalid_argument or std::out_of_range
void resume(ExplicitProblem& problem, const state::State& saved,
            const std::optional<integrators::StepSchedule>& schedule, RunObserver& observer);
/// The same, for those who do not look between the steps: displacement, velocity and acceleration are set.
void resume(ExplicitProblem& problem, const state::State& saved,
            const std::optional<integrators::StepSchedule>& schedule = {});
} // namespace dolfinx_impact::problems
