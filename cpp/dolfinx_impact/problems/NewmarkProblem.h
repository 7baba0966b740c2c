// SPDX-License-Identifier: MIT
#pragma once
#include "../integrators/newmark/ImplicitStepper.h"
#include "../solve/IncrementSolver.h"
#include "RigidEquilibrium.h"
#include "RunHistory.h"
#include "TimeExcitation.h"
#include "implicit_body.h"
#include "make_equilibrium.h"
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace dolfinx_impact::problems
{
struct NewmarkOptions
{
  integrators::ImplicitScheme scheme = {}; ///< by default the trapezoidal rule
  SolverOptions solver = {};
};

struct ImplicitAdvance
{
  double dt = 0.0; ///< largest step; without `tolerance` all steps are equal unless one fails [T]
  /// Local error of a step's displacement, relative to the largest displacement so far, by which steps are chosen;
  /// nothing: they are not [1].
  std::optional<double> tolerance = std::nullopt;
  std::optional<double> smallest = std::nullopt; ///< smallest step; nothing: a thousandth of dt [T]
  double rtol = 1e-10;             ///< of the free residual, relative to the largest force in the step [1]
  double atol = 0.0;               ///< of the free residual [F]
  int max_iterations = 25;         ///< of Newton's method, per step
  std::int64_t callback_every = 1; ///< steps between calls of a callback, after steps with multiples of it [1]
};

/// Whom a run tells and asks; functions may be empty. They are called on all ranks, and may throw.
struct ImplicitRunEvents
{
  solve::NewtonEvents newton = {};
  /// The values of a time are asked for: before a step that ends then is solved, of the start, and of the present time
  /// after a step that was given up.
  std::function<void(double)> update = {};
  /// Accelerations of the start were computed anew, and are in the history.
  std::function<void()> started = {};
  /// The first step of the call begins.
  std::function<void()> begins = {};
  /// Is asked before each step: time at which one must end, at latest [T].
  std::function<double()> goal = {};
  /// A step has been taken, and is in the history.
  std::function<void()> accepted = {};
};

/// Motion of bodies by Newmark's method or generalised-alpha, in contact or not; docs/implicit/scheme.md.
class NewmarkProblem : public TransientProblem
{
public:
  /// Is called with the present time and state; see `state`. An exception on one rank is thrown on all.
  typedef std::function<void(double time, const state::State& state)> Callback;

  /// Collective. Accelerations of the start are in equilibrium with the forces.
  /// @param[in] u displacement at the start, becomes that of the present time [L]
  /// @param[in] v velocity at the start, becomes that of the present time; where motion is prescribed, its own counts.
  /// Null: at rest, for bodies whose damping reads none [L/T]
  /// @param[in] body as implicit_body makes it, or composed of one's own residual (FormBody) and mass
  /// @param[in] a becomes the acceleration; null: a new function [L/T^2]
  /// @param[in] source samples all functions of time in the constructor, in place of them; may be empty
  /// @param[in] bodies rigid ones that contacts and loads move
  /// @throws std::invalid_argument for what does not fit; common::BadValue on all ranks if a prescribed displacement
  /// jumps at the start
  NewmarkProblem(std::shared_ptr<Function> u, std::shared_ptr<Function> v, ImplicitBody body,
                 std::vector<PrescribedMotion> supports = {}, std::vector<LoadInTime> loads = {},
                 std::vector<ImplicitContact> contacts = {}, const NewmarkOptions& options = {},
                 std::shared_ptr<Function> a = nullptr, const FunctionsOfTime::Source& source = {},
                 std::vector<ImplicitBodyInTime> bodies = {});
  ~NewmarkProblem() override;

  /// Advance to a time; a step ends there. A step that does not converge is repeated with half its length. Collective.
  /// @param[in] callback is called after each step, or some of them; may be empty
  /// @throws common::BadValue a time that has passed, or a value out of its range
  /// @throws common::Failure a step did not converge with the smallest length; the problem is in its last converged
  /// state then, as after exceptions of the callback and of events; or the call came from one of these
  void advance(double until, const ImplicitAdvance& options, const Callback& callback = {},
               const ImplicitRunEvents& events = {});

  /// Energies at the present time, sums over ranks. Collective [F L].
  integrators::Energies energies() { return _stepper->energies(); }
  /// Energies and contact forces at the start and after every step.
  const RunHistory& history() const { return _history; }
  /// Motion, forces, works and contacts as named arrays: copied and assigned, the problem can be brought back to it.
  state::State state() { return _stepper->state(); }
  /// Compute what follows from a state that was assigned. Collective.
  void resume();
  /// Largest step with which nothing grows; infinite for schemes that are stable with any step. Collective.
  /// @throws common::Failure if the highest frequency is not found
  double stable_step();
  /// Lengths of the steps of the last call of `advance`; nothing before the first.
  const std::optional<integrators::StepControl>& control() const { return _control; }
  void set_control(std::optional<integrators::StepControl> control) { _control = control; }
  /// Forget what `state` does not have, factors and candidates of the search: a problem that was copied and one that
  /// was brought back go on alike. Collective.
  void forget();
  /// Take over the time and the step of the stepper.
  void set_time();

  const std::shared_ptr<solve::EquilibriumProblem>& equilibrium() const { return _equilibrium; }
  integrators::ImplicitStepper& stepper() { return *_stepper; }
  RunHistory& history() { return _history; }
  const ImplicitBody& body() const { return _body; }
  /// Rigid bodies that contacts and loads move.
  const std::vector<ImplicitBodyInTime>& rigid_bodies() const { return _bodies; }
  /// Their equilibrium in a step; null: there are none.
  RigidEquilibrium* rigid_equilibrium() { return _rigid.get(); }

private:
  void add_row();
  solve::Increment solve_step(std::span<const double> target);
  void take_steps(double until, const Callback& callback, std::int64_t every, const ImplicitRunEvents& events);

  NewmarkOptions _options;
  ImplicitBody _body;
  std::vector<ImplicitBodyInTime> _bodies;
  std::shared_ptr<solve::EquilibriumProblem> _equilibrium;
  std::unique_ptr<integrators::ImplicitStepper> _stepper;
  std::optional<integrators::StepControl> _control; ///< of the last call of `advance`
  /// Of the present call. After an exception, which may be that of one rank, it stays until ranks are together again.
  std::unique_ptr<solve::IncrementSolver> _solver;
  std::unique_ptr<RigidEquilibrium> _rigid; ///< null: there are no rigid bodies
  bool _advancing = false;
  RunHistory _history;
};
} // namespace dolfinx_impact::problems
