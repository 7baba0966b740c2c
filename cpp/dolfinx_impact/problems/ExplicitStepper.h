// SPDX-License-Identifier: MIT
#pragma once
#include "../integrators/SafeStep.h"
#include "../integrators/StepSchedule.h"
#include "FunctionsOfTime.h"
#include "RunHistory.h"
#include "RunObserver.h"
#include <cstdint>
#include <dolfinx/fem/FunctionSpace.h>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::problems
{
struct AdvanceOptions
{
  std::optional<double> dt = std::nullopt; ///< largest step; nothing: 0.9 of the stable step. All steps are equal [T]
  bool unsafe = false;                     ///< accept a dt beyond the stable step, with a warning
  double gain_warning = 0.1; ///< gained energy over the energies so far at which the run warns; infinite: never [1]
  double gain_limit = 0.5;   ///< and at which it stops [1]
  std::int64_t callback_every = 1; ///< steps between calls of a callback, after steps with multiples of it [1]
};

/// Time stepping of an explicit problem: how many steps the integrator takes and how long they are, what happens
/// between them, and the way back of a run that failed.
class ExplicitStepper
{
public:
  /// What the steps act on; all of it outlives the stepper.
  struct System
  {
    std::shared_ptr<const dolfinx::fem::FunctionSpace<double>> space;
    integrators::CentralDifference& integrator;
    integrators::SafeStep& safe;
    RunHistory& history;
    std::vector<std::string> contacts;   ///< their names
    std::function<void()> update_motion; ///< the functions get the present motion. Collective
    std::function<void()> check_start;   ///< throws on all ranks alike if bodies overlap. Collective
    /// Rows of the functions of time at times; throws on all ranks alike.
    std::function<std::vector<double>(std::span<const double>)> table;
    std::function<void()> keep_history, go_back; ///< internal variables; `go_back` opens contacts, too
    std::function<std::string()> unsolved; ///< which local equations were not solved, or an empty text. Collective
  };

  /// @param[in,out] time, step the present ones
  ExplicitStepper(System system, double& time, std::int64_t& step);

  /// Find the stable step of the present displacement, for another start at time zero. Collective.
  void begin_anew();
  /// Start at time zero: compute forces. Collective.
  /// @param[in] u, v owned entries [L], [L/T]
  void start(std::span<const double> u, std::span<const double> v, RunObserver& observer);
  /// Advance to a later time. Collective.
  /// @throws common::BadValue dt beyond the stable step, or so small that the time cannot be reached; nothing limits it
  /// @throws common::Failure the run went unstable or gained energy beyond the limit; the motion is the last good one
  void advance(double until, const AdvanceOptions& options, RunObserver& observer);

  /// Steps of the present `advance`; nothing outside one that was left.
  const std::optional<integrators::StepSchedule>& schedule() const { return _schedule; }
  /// Upper bound of the steps of the present schedule [T].
  double nominal_step() const { return _nominal; }
  /// Time of the next step; the integrator knows the functions of time up to it [T].
  double next_time() const { return _next_time; }
  /// Has the present run warned of gained energy?
  bool warned() const { return _warned; }

  /// Go on from a checkpoint; the integrator must have been restored before. Collective.
  void resume(double next_time, double nominal, const std::optional<integrators::StepSchedule>& schedule,
              RunObserver& observer);

private:
  /// State that a failed run returns to.
  struct GoodState
  {
    std::int64_t step;
    double time; ///< [T]
    std::vector<double> u, v;
  };

  MPI_Comm comm() const { return _system.space->mesh()->comm(); }
  std::vector<double> table(std::span<const double> times, RunObserver& observer) const;
  void restart(RunObserver& observer);
  void take_steps(double until, const AdvanceOptions& options, RunObserver& observer);
  void run(std::int64_t count, RunObserver& observer);
  void choose_schedule(double until, const AdvanceOptions& options, RunObserver& observer);
  void recheck(double until, const AdvanceOptions& options, RunObserver& observer);
  void warn(RunObserver& observer, const std::string& text) const;
  [[noreturn]] void fail(double time, const std::string& fault, RunObserver& observer);

  System _system;
  double& _time;
  std::int64_t& _step;
  double _next_time = 0.0, _nominal;
  std::optional<integrators::StepSchedule> _schedule;
  std::optional<GoodState> _good;
  double _gain_warning = std::numeric_limits<double>::infinity();
  bool _warned = false;
  std::vector<double> _lengths, _times, _rows;
};
} // namespace dolfinx_impact::problems
