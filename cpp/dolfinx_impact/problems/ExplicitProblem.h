// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/node_to_surface/NodalPair.h"
#include "../integrators/CentralDifference.h"
#include "../integrators/SafeStep.h"
#include "../state/State.h"
#include "ExplicitBody.h"
#include "ExplicitStepper.h"
#include "TransientProblem.h"
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dolfinx_impact::problems
{
/// A contact of a problem in time.
struct ContactInTime
{
  enforcement::NodalPair contact;                      ///< one direction, or both of balanced contact
  std::string name = "contact";                        ///< for messages
  std::optional<FunctionOfTime> motion = std::nullopt; ///< displacement of a rigid master; nothing: it stays [L]
  /// Upper bound of the angular frequency that its springs of given stiffness add; springs by the step or the bodies
  /// add none [1/T].
  double spring_frequency = 0.0;
};

struct ExplicitOptions
{
  integrators::Scheme scheme = integrators::Scheme::half_step;
  /// Energy that a residual of one's own may give beside that of the start; infinite: all [F L].
  double release_limit = std::numeric_limits<double>::infinity();
  bool start = true; ///< compute the forces of the start at once; else by `start`
};

/// Motion of bodies with lumped mass by central differences; docs/explicit/scheme.md.
class ExplicitProblem : public TransientProblem
{
public:
  /// Is called with the present time and state; see `state`. An exception on one rank is thrown on all.
  typedef std::function<void(double time, const state::State& state)> Callback;

  /// Collective. Forces of the start are computed.
  /// @param[in] u displacement at the start, becomes that of the present time [L]
  /// @param[in] v velocity at the start, becomes that of the present time; null: at rest [L/T]
  /// @param[in] a becomes the acceleration; null: a new function [L/T^2]
  /// @throws std::invalid_argument for what does not fit; common::BadValue on all ranks if bodies overlap, or a
  ///   prescribed displacement jumps at the start
  ExplicitProblem(std::shared_ptr<Function> u, std::shared_ptr<Function> v, ExplicitBody body,
                  std::vector<PrescribedMotion> supports = {}, std::vector<LoadInTime> loads = {},
                  std::vector<ContactInTime> contacts = {}, const ExplicitOptions& options = {},
                  std::shared_ptr<Function> a = nullptr);

  /// Advance to a time. Collective. After an exception of the callback the problem has the state of the last step, and
  /// `advance` to the same time goes on with the remaining steps.
  /// @param[in] callback is called after each step; empty: none, then many steps are one call of the integrator
  /// @throws common::BadValue a time that has passed, a step that does not fit; common::Failure as
  ///   ExplicitStepper::advance
  void advance(double until, const AdvanceOptions& options = {}, const Callback& callback = {});
  /// The same, for those who look between the steps. The functions of displacement, velocity and acceleration are then
  /// set by `update_motion` alone.
  void advance(double until, const AdvanceOptions& options, RunObserver& observer);

  /// Largest stable step at the present state, from the highest frequencies of the cells; with contact springs of given
  /// stiffness. Collective [T].
  double stable_step();
  /// Energies at the present time, sums over ranks. Collective [F L].
  integrators::Energies energies() { return _integrator->energies(); }
  const RunHistory& history() const { return _history; }
  RunHistory& history() { return _history; }
  /// Displacement, velocity and acceleration as named arrays, views of the problem's functions.
  state::State state();
  /// Set displacement, velocity and acceleration to those of the present time. Collective.
  void update_motion();
  /// Compute the forces of the start, from the functions of displacement and velocity: for the first time, or because
  /// contacts have got a history. Collective.
  /// @throws common::BadValue if bodies overlap
  void start(RunObserver& observer);
  /// Go on from a checkpoint; integrator and `safe_step` must have been restored. Collective.
  void resume(double time, std::int64_t step, double next_time, double nominal,
              const std::optional<integrators::StepSchedule>& schedule, RunObserver& observer);

  integrators::CentralDifference& integrator() { return *_integrator; }
  integrators::SafeStep& safe_step() { return _safe; }
  const ExplicitStepper& stepper() const { return _stepper; }
  const ExplicitBody& body() const { return _body; }
  const std::vector<ContactInTime>& contacts() const { return _contacts; }

private:
  ExplicitStepper::System system();
  void check_overlap();
  void go_back();
  std::string unsolved() const;

  ExplicitBody _body;
  std::vector<ContactInTime> _contacts;
  std::unique_ptr<integrators::CentralDifference> _integrator;
  integrators::SafeStep _safe;
  RunHistory _history;
  ExplicitStepper _stepper;
  bool _advances = false; ///< a call of `advance` is running
};
} // namespace dolfinx_impact::problems
