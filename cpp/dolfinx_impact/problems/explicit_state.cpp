// SPDX-License-Identifier: MIT
#include "explicit_state.h"
#include "../operators/saved_history.h"
#include "../state/numbers.h"
#include <algorithm>

using dolfinx_impact::state::add_number;
using dolfinx_impact::state::number;
using dolfinx_impact::state::Place;
using dolfinx_impact::state::State;
using dolfinx_impact::state::vector;

namespace dolfinx_impact::problems
{
namespace
{
operators::Histories histories_of(const ExplicitBody& body)
{
  operators::Histories out;
  for (operators::InternalForce* operation : body.internal.parts())
    for (std::size_t i = 0; i < operation->num_integrals(); ++i)
      if (const auto& history = operation->history(i))
        out.push_back(history);
  return out;
}

State with(ExplicitProblem& problem, State integrator)
{
  integrators::SafeStep& safe = problem.safe_step();
  const integrators::SafeStep::Saved step = safe.saved();
  const integrators::StableStepWatch* watch = safe.watch();
  const RunHistory& history = problem.history();
  State out("explicit problem");
  add_number(out, "time", problem.time());
  add_number(out, "next_time", problem.stepper().next_time());
  add_number(out, "step", problem.step());
  add_number(out, "safe_step", step.value);
  add_number(out, "nominal_step", problem.stepper().nominal_step());
  add_number(out, "check_step", step.check_step);
  add_number(out, "check_interval", step.check_interval);
  add_number(out, "largest", history.largest());
  add_number(out, "total_start", history.total_start().value_or(0.0));
  add_number(out, "deformed", std::int64_t(step.deformed));
  add_number(out, "input_change", safe.changes.stale ? safe.changes.total : -1.0);
  add_number(out, "allowed_change", safe.changes.allowed);
  add_number(out, "sensitivity", watch ? watch->seen().sensitivity : 0.0);
  if (watch)
  {
    const integrators::StableStepWatch::Seen& seen = watch->seen();
    const auto reference = std::span(seen.reference).first(problem.integrator().displacement().size());
    out.add_own("watch", Place::node, std::vector<double>(reference.begin(), reference.end()),
                problem.displacement()->function_space()->dofmap()->index_map_bs());
    out.add_own("watch squares", Place::cell, seen.squares).add_own("watch rates", Place::cell, seen.rates);
    out.add_own("watch since", Place::cell, seen.since);
  }
  out.add(std::move(integrator));
  for (std::size_t k = 0; k < problem.contacts().size(); ++k)
  {
    std::vector<State> directions = problem.contacts()[k].contact.saved_states();
    for (std::size_t j = 0; j < directions.size(); ++j)
      out.add(std::move(directions[j].rename("contact" + std::to_string(k) + "_" + std::to_string(j))));
  }
  const auto& topology = *problem.displacement()->function_space()->mesh()->topology();
  if (const operators::Histories histories = histories_of(problem.body()); !histories.empty())
    out.add(operators::saved_history(histories, topology.index_map(topology.dim())->size_local()));
  return out;
}
} // namespace

State saved_state(ExplicitProblem& problem)
{
  return with(problem, problem.integrator().saved_state());
}

State empty_state(ExplicitProblem& problem)
{
  return with(problem, problem.integrator().empty_state());
}

void resume(ExplicitProblem& problem, const State& saved, const std::optional<integrators::StepSchedule>& schedule,
            RunObserver& observer)
{
  if (const operators::Histories histories = histories_of(problem.body()); !histories.empty())
    operators::resume_history(histories, saved.part("material"));
  for (std::size_t k = 0; k < problem.contacts().size(); ++k)
  {
    enforcement::NodalPair pair = problem.contacts()[k].contact;
    std::vector<State> directions;
    for (std::size_t j = 0; j < pair.directions().size(); ++j)
      directions.push_back(saved.part("contact" + std::to_string(k) + "_" + std::to_string(j)));
    pair.resume(directions);
  }
  integrators::SafeStep& safe = problem.safe_step();
  const double change = number<double>(saved, "input_change");
  safe.changes.stale = change >= 0.0;
  safe.changes.total = std::max(change, 0.0);
  safe.changes.allowed = number<double>(saved, "allowed_change");
  if (safe.watch())
    safe.watch()->restore({vector(saved, "watch squares"), vector(saved, "watch rates"), vector(saved, "watch since"),
                           vector(saved, "watch"), number<double>(saved, "sensitivity")});
  problem.integrator().resume(saved.part("integrator"));
  safe.restore({number<double>(saved, "safe_step"), number<std::int64_t>(saved, "check_step"),
                number<std::int64_t>(saved, "check_interval"), number<std::int64_t>(saved, "deformed") != 0});
  // Loads and prescribed motion, which acceleration and velocity depend on, are those of the time.
  const std::int64_t step = number<std::int64_t>(saved, "step");
  problem.resume(number<double>(saved, "time"), step, number<double>(saved, "next_time"),
                 number<double>(saved, "nominal_step"), schedule, observer);
  problem.history().resume(step > 0 ? std::optional(number<double>(saved, "total_start")) : std::nullopt,
                           number<double>(saved, "largest"));
}

void resume(ExplicitProblem& problem, const State& saved, const std::optional<integrators::StepSchedule>& schedule)
{
  RunObserver nobody;
  resume(problem, saved, schedule, nobody);
  problem.update_motion();
}
} // namespace dolfinx_impact::problems
