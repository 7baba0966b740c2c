// SPDX-License-Identifier: MIT
#pragma once
#include "../rolling/RollingNewton.h"
#include "../rolling/frequencies.h"
#include "StaticProblem.h"

namespace dolfinx_impact::problems
{
/// What a steady state was found by, and what is to be said of it.
struct RollingReport
{
  solve::LoadStepReport steps;
  /// That the bodies without what contacts by multipliers hold are beyond the critical speed; empty if they are not.
  std::string warning;
};

/// Powers of a steady state; driving = friction + rolling, to the solver's tolerance [F L/T].
struct PowerBalance
{
  double driving = 0.0;  ///< torques times spins, and forces that hold bodies in translation times their velocities
  double friction = 0.0; ///< that slip takes
  double rolling = 0.0;  ///< that deformation takes; of elastic bodies the error of the derivative along the flow
};

/// Bodies through whose meshes the material flows steadily, in contact or not: equilibrium, with the forces of inertia
/// of the flow; docs/rolling.md.
class RollingProblem
{
public:
  /// @param[in] equilibrium bodies, whose residual has the forces of inertia of the flow with the constants of its
  /// motions, and contacts: with friction all of them rolling::RollingContact, of the same flow, else any without
  /// @param[in] flow of the bodies; its rates, and velocities of rigid masters, become loads of `equilibrium`
  /// (views of this object's and the flow's, so that `equilibrium` is not solved once this is gone)
  /// @throws std::invalid_argument for other contacts beside RollingContacts, or a contact of another flow
  RollingProblem(std::shared_ptr<StaticProblem> equilibrium, std::shared_ptr<rolling::Flow> flow);

  /// Find the steady state for the present rates, loads, boundary conditions and obstacles, in steps from those of the
  /// last solve. Collective.
  /// @param[in] torque that drives the body of the first Spin: its rate is then an unknown, found from the present one
  /// on, and zero is free rolling; nothing: rates are given [F L]
  /// @throws std::runtime_error no convergence, also because friction cannot bear the torque, or a speed beyond the
  /// critical one: the tangent is not positive definite; the problem is then in its last converged state, or in that
  /// before the call
  /// @throws std::invalid_argument bodies that move against each other at a contact, friction between bodies that do
  /// not move, a torque without friction or without a Spin, and what StaticProblem::solve refuses
  /// @throws common::Failure if a solve is under way, that has called an event
  RollingReport solve(const SolveOptions& options = {}, const SolveEvents& events = {},
                      std::optional<double> torque = {});

  StaticProblem& equilibrium() { return *_equilibrium; }
  rolling::Flow& flow() { return *_flow; }
  /// Contacts with friction against the slip velocity, all of the problem or none.
  const std::vector<rolling::RollingContact*>& contacts() const { return _contacts; }

  /// Torque that drives the body of a motion: minus the moment of the contact forces about its axis, at deformed
  /// places, positive along the axis [F L]. The axis moves with the body's supports. Collective.
  /// @param[in] spin one of the flow's motions, a Spin
  double torque(const rolling::Motion& spin) const;
  /// Displacement of that axis: in each component the mean of what its body's supports prescribe [L]. Collective.
  std::array<double, 3> axle(const rolling::Motion& spin) const;
  /// Power that drives the bodies, and where it goes, in the present state. Collective.
  /// @throws std::invalid_argument without friction
  PowerBalance power_balance();

  /// Largest rates at which the last solves have found stiffness minus W to be positive definite, those of all motions
  /// one after the other; empty before the first. A linear problem looks beyond its rates, and not again up to these.
  const std::vector<double>& stable_rates() const { return _safe; }
  /// Number of negative eigenvalues of stiffness minus W at the present state. Collective.
  int negative_directions() const;
  /// Factor on the present rates at which stiffness minus W becomes singular: rolling::critical_factor. Collective.
  /// @param[in] W at the present rates, zero at supports [F/L]
  /// @throws std::invalid_argument for a body that is not held against rigid motion
  double critical_factor(Mat W) const;
  /// Signed frequencies of small vibrations about the present state: rolling::frequencies. Collective.
  /// @param[in] matrices without K, which is that of the problem
  /// @throws std::invalid_argument for contacts by multipliers
  rolling::Frequencies frequencies(rolling::VibrationMatrices matrices, int count, double tolerance) const;

  /// State that a solve starts from, as StaticProblem::state; rates of the motions are among its loads.
  state::State state() { return _equilibrium->state(); }
  /// Take the present rates and loads as those that the last solve has reached.
  void mark_reached();

private:
  const solve::EquilibriumProblem& bodies() const { return *_equilibrium->equilibrium(); }
  void solve_with_friction(RollingReport& report, const SolveOptions& options, const SolveEvents& events,
                           std::optional<double> torque);
  void find_spin(rolling::RollingNewton& newton, solve::LoadStepReport& report, const SolveOptions& options,
                 const SolveEvents& events, double torque);
  std::string beyond_critical_speed();

  std::shared_ptr<StaticProblem> _equilibrium;
  std::shared_ptr<rolling::Flow> _flow;
  std::vector<rolling::RollingContact*> _contacts;
  std::vector<std::vector<double>> _reached; ///< velocities of rigid masters, of the last solve
  std::optional<rolling::ReducedContacts> _reduced;
  std::vector<double> _safe; ///< largest rates at which stiffness minus W was found positive definite
  bool _solving = false;
};
} // namespace dolfinx_impact::problems
