// SPDX-License-Identifier: MIT
#pragma once
#include "../../solve/RigidEquations.h"
#include "../../state/State.h"
#include "../RigidBody.h"
#include "StepMotion.h"
#include <optional>
#include <string>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Motion of a rigid body at one time, and the forces on it there; the same on all ranks.
struct ImplicitRigidState
{
  gap::Vector3 displacement{};                  ///< of the centre [L]
  gap::Quaternion rotation{1.0, 0.0, 0.0, 0.0}; ///< since the start [1]
  /// Velocity and angular momentum [L/T], [M L^2/T].
  std::array<double, 6> rate{};
  /// Acceleration and the torque that changes the angular momentum [L/T^2], [F L].
  std::array<double, 6> change{};
  /// The scheme's means of them, see Motion::mean.
  std::array<double, 6> mean{};
  gap::Vector3 force{}, torque{};     ///< of contacts on the body, about its centre [F], [F L]
  gap::Vector3 load{}, load_torque{}; ///< external [F], [F L]
  double work = 0.0;                  ///< of loads, and of contact forces where the motion is fixed, so far [F L]

  /// As named arrays, views.
  state::State state(const std::string& name);
};

/// A rigid body in implicit steps, in the same scheme as the nodes: its velocity as theirs, its angular momentum L in
/// the place of a velocity with the torque in the place of an acceleration. Over a step it turns as a free body with
/// the angular momentum that the scheme's displacement is the integral of, exactly for balls and tops: a free body
/// keeps L. docs/rigid_bodies.md has the equations.
class ImplicitRigidBody : public solve::RigidEquations
{
public:
  /// @param[in] length by which torques become forces where the body has no mass [L]
  /// @throws std::invalid_argument as RigidBody
  ImplicitRigidBody(const RigidBodyOptions& options, double length);

  /// Loads and contact forces at the start: accelerations follow from them.
  void start(const gap::Vector3& load, const gap::Vector3& load_torque, const gap::Vector3& force,
             const gap::Vector3& torque);
  /// A step begins, with the loads at its end.
  /// @param[in] step its length [T]
  void begin_step(const ImplicitScheme& scheme, double step, const gap::Vector3& load, const gap::Vector3& load_torque);
  /// The step is accepted with values of the unknowns, and contact forces there.
  void accept(std::span<const double> q, const gap::Vector3& force, const gap::Vector3& torque);
  /// Values of the unknowns of the step's solution, which `accept` takes.
  std::vector<double> solution;

  std::size_t size() const override { return _free.size(); }
  std::string component(std::size_t unknown) const override;
  std::vector<double> first_guess() const override;
  solve::RigidPlace place(std::span<const double> q) const override;
  gap::Vector3 centre() const override { return _options.centre; }
  solve::RigidBalance balance(std::span<const double> q, const gap::Vector3& force,
                              const gap::Vector3& torque) const override;
  std::vector<double> derivatives() const override;
  bool needs_contact() const override { return false; }
  bool turns() const override { return _turns; }

  // --- the present time --------------------------------------------------------------------------------------------
  /// Where it is at the present time.
  solve::RigidPlace place() const { return {_now.displacement, rotation()}; }
  gap::Vector3 position() const;
  gap::Matrix3 rotation() const { return gap::matrix_of(_now.rotation); }
  gap::Vector3 velocity() const;
  gap::Vector3 spin() const;
  gap::Vector3 momentum() const;
  gap::Vector3 angular_momentum() const;
  /// Without that of a rotation whose components are all fixed [F L].
  double kinetic_energy() const;
  const ImplicitRigidState& state() const { return _now; }
  ImplicitRigidState& state() { return _now; }

private:
  std::array<double, 6> increments(std::span<const double> q) const;
  gap::Quaternion turned(const std::array<double, 6>& increments) const;

  RigidBodyOptions _options;
  RigidInertia _inertia;
  std::vector<int> _free; ///< components
  bool _turns;
  double _length; ///< by which torques become forces [L]
  double _scale;  ///< integral of the angular momentum per unknown [M L]
  ImplicitRigidState _now;
  double _step = 0.0;
  std::optional<StepMotion> _motion; ///< increments of the step
  gap::Vector3 _load{}, _load_torque{};
};
} // namespace dolfinx_impact::integrators
