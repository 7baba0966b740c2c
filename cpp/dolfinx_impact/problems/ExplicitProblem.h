// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/node_to_surface/NodalPair.h"
#include "../integrators/CentralDifference.h"
#include "../integrators/SafeStep.h"
#include "../state/State.h"
#include "ExplicitBody.h"
#include "ExplicitStepper.h"
#include "RigidBodyInTime.h"
#include "TransientProblem.h"
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dolfinx_impact::problems
{
/// How `stable_step` finds the largest stable step; docs/explicit/stable_step.md.
enum class StableStepMethod
{
  length,    ///< shortest edge over the speed of waves, (3.79), (3.80): an estimate
  element,   ///< from the highest frequencies of the cells: never more than the limit
  eigenvalue ///< from the highest frequency of the assembled bodies: the limit itself
};

/// A contact of a problem in time. The stable step is lowered by springs of a given penalty. Springs without one get
/// the stiffness that the bodies offer, unless they follow the step (NodePenaltyOptions::by_step) or were given theirs.
struct ContactInTime
{
  enforcement::NodalPair contact;                      ///< one direction, or both of balanced contact
  std::string name = "contact";                        ///< for messages
  std::optional<FunctionOfTime> motion = std::nullopt; ///< displacement of a rigid master; nothing: it stays [L]
  std::shared_ptr<RigidBodyInTime> body{};             ///< the master moves by forces; null: it does not
  /// Rotation vector of a rigid master about its centre; nothing: it does not turn [1].
  std::optional<FunctionOfTime> rotation = std::nullopt;
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

  /// Largest stable step at the present state; infinite where nothing limits it. Collective [T].
  ///
  /// Contact springs of given stiffness lower it: by a bound that holds wherever the bodies meet (`length`, `element`),
  /// or by the springs of all slave nodes that have a master now, closed or not (`eigenvalue`).
  /// @throws common::BadValue if the stiffness of a cell is not finite, or `length` is asked for bodies whose wave
  /// speed is not known
  /// @throws common::Failure if the eigenvalue solver does not converge
  double stable_step(StableStepMethod method = StableStepMethod::element);
  /// The same of the displacement that the function has, which may be another one than that of the steps.
  double stable_step_of_function(StableStepMethod method);
  /// Energies at the present time, sums over ranks. Collective [F L].
  integrators::Energies energies() { return _integrator->energies(); }
  const RunHistory& history() const { return _history; }
  RunHistory& history() { return _history; }
  /// Displacement, velocity and acceleration as named arrays, views of the problem's functions.
  state::State state();
  /// Set displacement, velocity and acceleration to those of the present time. Collective.
  void update_motion();
  /// Take another displacement for the start, that of the function now: its stable step is found, and contacts are
  /// open. `start` or `start_from_equilibrium` come next. Collective.
  /// @throws common::BadValue steps have been made
  void begin_anew();
  /// Compute the forces of the start, from the functions of displacement and velocity: for the first time, or because
  /// contacts have got a history. Collective.
  /// @throws common::BadValue if bodies overlap
  void start(RunObserver& observer);
  /// Kinetic energy of the velocity at the start that ties have taken, as it contradicts them [F L].
  double lost_at_start() const { return _lost_at_start; }
  /// Go on from a checkpoint; integrator and `safe_step` must have been restored. Collective.
  void resume(double time, std::int64_t step, double next_time, double nominal,
              const std::optional<integrators::StepSchedule>& schedule, RunObserver& observer);

  integrators::CentralDifference& integrator() { return *_integrator; }
  integrators::SafeStep& safe_step() { return _safe; }
  const ExplicitStepper& stepper() const { return _stepper; }
  const ExplicitBody& body() const { return _body; }
  const std::vector<ContactInTime>& contacts() const { return _contacts; }
  /// Rigid bodies, each once, in the order of the contacts.
  std::vector<std::shared_ptr<RigidBodyInTime>> rigid_bodies() const;
  /// Which local equations, of materials or of laws of the interface, the last step could not solve; empty: all were.
  /// Collective.
  std::string unsolved() const;

private:
  ExplicitStepper::System system();
  void keep_bodies();
  void check_overlap();
  void start_tied();
  void go_back();
  double assembled_stable_step();

  ExplicitBody _body;
  std::vector<ContactInTime> _contacts;
  std::unique_ptr<integrators::CentralDifference> _integrator;
  integrators::SafeStep _safe;
  RunHistory _history;
  ExplicitStepper _stepper;
  double _lost_at_start = 0.0;
  std::vector<integrators::RigidBodyState> _kept_bodies; ///< of the state that a failed run goes back to
  bool _advances = false;                                ///< a call of `advance` is running
};
} // namespace dolfinx_impact::problems
