// SPDX-License-Identifier: MIT
#pragma once
#include "../integrators/newmark/ImplicitStepper.h"
#include "../solve/Newton.h"
#include "RunHistory.h"
#include "TransientProblem.h"
#include "implicit_body.h"
#include "make_equilibrium.h"
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace dolfinx_impact::problems
{
/// A contact of implicit steps, made with prescribed_dofs of the same supports.
struct ImplicitContact
{
  std::shared_ptr<enforcement::StaticContact> contact;
  /// Displacement of a rigid master, beside that which it has at the start; nothing: it stays there [L].
  std::optional<FunctionOfTime> motion = std::nullopt;
};

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
  double rtol = 1e-10;     ///< of the free residual, relative to the largest force in the step [1]
  double atol = 0.0;       ///< of the free residual [F]
  int max_iterations = 25; ///< of Newton's method, per step
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
  /// @throws std::invalid_argument for what does not fit; common::BadValue on all ranks if a prescribed displacement
  /// jumps at the start
  NewmarkProblem(std::shared_ptr<Function> u, std::shared_ptr<Function> v, ImplicitBody body,
                 std::vector<PrescribedMotion> supports = {}, std::vector<LoadInTime> loads = {},
                 std::vector<ImplicitContact> contacts = {}, const NewmarkOptions& options = {});
  ~NewmarkProblem() override;

  /// Advance to a time; a step ends there. A step that does not converge is repeated with half its length. Collective.
  /// @param[in] callback is called after each step; may be empty
  /// @throws common::BadValue a time that has passed, or a value out of its range
  /// @throws common::Failure a step did not converge with the smallest length; the problem is in its last converged
  /// state then, as after exceptions of the callback
  void advance(double until, const ImplicitAdvance& options, const Callback& callback = {});

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

  const solve::EquilibriumProblem& equilibrium() const { return *_equilibrium; }
  const integrators::ImplicitStepper& stepper() const { return *_stepper; }

private:
  class TimeExcitation;
  void add_row();

  NewmarkOptions _options;
  ImplicitBody _body;
  std::shared_ptr<solve::EquilibriumProblem> _equilibrium;
  std::unique_ptr<integrators::ImplicitStepper> _stepper;
  std::optional<integrators::StepControl> _control; ///< of the last call of `advance`
  RunHistory _history;
};
} // namespace dolfinx_impact::problems
