// SPDX-License-Identifier: MIT
#pragma once
#include "../../common/dolfinx_api.h"
#include "../../solve/EquilibriumProblem.h"
#include "../../solve/Increment.h"
#include "../../solve/force_on_master.h"
#include "../energy.h"
#include "Excitation.h"
#include "ImplicitEnergyBalance.h"
#include "ImplicitRigidBody.h"
#include "ImplicitScheme.h"
#include "MovingBody.h"
#include "StepControl.h"
#include <functional>
#include <memory>
#include <string>

namespace dolfinx_impact::integrators
{
/// Whom implicit steps tell what they do; functions may be empty. They are called on all ranks, and may throw.
struct ImplicitEvents
{
  std::function<void(const std::string&)> log; ///< a line of the log
  /// The values of a time are asked for: before a step that ends then is solved, and of the present time after one that
  /// was given up.
  std::function<void(double)> update;
};

/// Implicit steps of bodies in contact: one after the other, repeated with half the length where one fails.
class ImplicitStepper
{
public:
  typedef dolfinx::fem::Function<double> Function;
  /// Solves from the present displacements to prescribed ones, owned and ghosts. Collective.
  typedef std::function<solve::Increment(std::span<const double>)> Solver;

  /// @param[in] equations a step as Newton's method sees it, with `body` as its bodies
  /// @param[in] total_mass lumped mass per owned degree of freedom, by which errors are weighted [M]
  /// @param[in] velocity, acceleration functions that show the motion [L/T], [L/T^2]
  ImplicitStepper(std::shared_ptr<const solve::EquilibriumProblem> equations, std::shared_ptr<MovingBody> body,
                  const ImplicitScheme& scheme, std::shared_ptr<Excitation> excitation, std::vector<double> total_mass,
                  std::shared_ptr<Function> velocity, std::shared_ptr<Function> acceleration);

  /// A rigid body that moves, the master of some contacts; to be added before the start.
  void add_body(std::shared_ptr<ImplicitRigidBody> body, std::vector<std::size_t> contacts);
  /// Evaluate contacts at the start. Collective.
  void enter_contact();
  /// Begin with the present functions: accelerations are in equilibrium with bodies, loads and springs of contact.
  /// Collective.
  /// @param[in] step over which prescribed motion can be differentiated; nothing: it is not known [T]
  /// @throws common::Failure if the accelerations are not found
  void start(std::optional<double> step);
  /// Continue from a motion, time, step, works and forces that have been set: compute what follows from them.
  /// Collective.
  void resume();
  /// Motion, forces, works, contacts and the time as named arrays: assigned, they are what `resume` goes on from. Not
  /// collective.
  state::State state();
  /// Take one step on the way to a time. Collective.
  /// @throws common::Failure a step did not converge with the smallest length; the problem is in its last converged
  /// state then, as after exceptions of `solver` and events, after which `update_gaps` is to be called if all ranks can
  void take_step(double goal, StepControl& control, const Solver& solver, const ImplicitEvents& events = {});
  /// Compute the gaps of the present displacement anew. Collective.
  void update_gaps();
  /// Energies at the present time. Collective.
  Energies energies();

  double time() const { return _time; }         ///< present [T]
  std::int64_t step() const { return _number; } ///< number of the present step
  void set_time(double time, std::int64_t step) { _time = time, _number = step; }
  const Motion& motion() const { return _motion; } ///< at the present time
  void set_motion(Motion motion) { _motion = std::move(motion); }
  /// Velocity and acceleration as the functions show them, ghosts included. Collective.
  void show_motion();
  ImplicitEnergyBalance& energy_balance() { return _energy_balance; }
  /// Displacement at the start, owned [L].
  std::vector<double>& start_displacement() { return _start_displacement; }
  /// Largest displacement so far, which errors are relative to: root of a mass-weighted mean square [L].
  double& largest_displacement() { return _largest_displacement; }
  int iterations() const { return _iterations; } ///< of the last step
  int cut_backs() const { return _cut_backs; }   ///< steps so far that were repeated with half the length
  int rejected() const { return _rejected; }     ///< steps so far that were repeated because of their error

private:
  struct Before;
  std::vector<double> body_residual(std::span<const double> factors);
  Forces forces(const Motion& motion, const TimeValues& values);
  solve::Increment attempt(double step, const TimeValues& values, const Solver& solver);
  std::optional<double> error(const Motion& motion, double step, const StepControl& control);
  double size(std::span<const double> values) const;
  void go_back(const Before& before);
  /// Values of functions of time, with bodies where they are.
  TimeValues sample(std::optional<double> step, double time);
  void begin_contacts(const TimeValues& values, double step, std::span<const double> target);
  solve::MasterForce force_on(std::size_t body) const;
  void accept(Motion motion, const TimeValues& values);
  std::size_t num_owned() const { return _total_mass.size(); }
  std::span<double> u() const { return common::array(*_equations->u->x()); }

  std::shared_ptr<const solve::EquilibriumProblem> _equations;
  std::shared_ptr<MovingBody> _body;
  ImplicitScheme _scheme;
  std::shared_ptr<Excitation> _excitation;
  std::vector<double> _total_mass;
  std::shared_ptr<Function> _velocity, _acceleration;
  Motion _motion;
  double _time = 0.0;
  std::int64_t _number = 0;
  ImplicitEnergyBalance _energy_balance;
  struct Rigid
  {
    std::shared_ptr<ImplicitRigidBody> body;
    std::vector<std::size_t> contacts;
  };
  std::vector<Rigid> _bodies;
  std::vector<std::array<double, 3>> _places; ///< displacements of rigid masters at the present time [L]
  std::vector<std::array<double, 3>> _angles; ///< their rotation vectors [1]
  std::vector<double> _start_displacement;
  double _largest_displacement = 0.0;
  int _iterations = 0, _cut_backs = 0, _rejected = 0;
};
} // namespace dolfinx_impact::integrators
