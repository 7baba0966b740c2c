// SPDX-License-Identifier: MIT
#pragma once
#include "../gap/RigidMotion.h"
#include "../state/State.h"
#include "RigidInertia.h"
#include "energy.h"
#include <array>
#include <string>
#include <vector>

namespace dolfinx_impact::integrators
{
/// What a rigid body is made with.
struct RigidBodyOptions
{
  double mass = 0.0;                    ///< [M]
  gap::Matrix3 inertia{};               ///< about the centre, at the start [M L^2]
  std::array<double, 3> centre{};       ///< of mass, before the displacement [L]
  std::array<double, 3> displacement{}; ///< at the start [L]
  std::array<double, 3> velocity{};     ///< at the start [L/T]
  std::array<double, 3> spin{};         ///< angular velocity at the start [1/T]
  std::array<bool, 3> fixed_velocity{}; ///< components of the velocity that stay as they are
  std::array<bool, 3> fixed_spin{};     ///< components of the spin that stay as they are
};

/// What a rigid body's motion has of itself; all of it is the same on all ranks.
struct RigidBodyState
{
  std::array<double, 3> displacement{};               ///< of the centre [L]
  std::array<double, 4> rotation{1.0, 0.0, 0.0, 0.0}; ///< unit quaternion, since the start [1]
  std::array<double, 3> momentum{};                   ///< half a step ago [M L/T]
  std::array<double, 3> angular_momentum{};           ///< about the centre, half a step ago [M L^2/T]
  std::array<double, 3> increment{};                  ///< of the displacement in the last step [L]
  std::array<double, 3> angle{};                      ///< rotation vector of the last step [1]
  gap::Matrix3 turn{};                                ///< see RigidMotion [1]
  std::array<double, 3> force{};                      ///< of contact, on the slaves, at the present time level [F]
  gap::Matrix3 force_moment{};                        ///< see NodalContact::force_moment [F L]
  Work work;                                          ///< of loads, and of contact forces where the motion is fixed
  std::vector<double> meetings; ///< what contacts with other rigid bodies remember, see RigidContact

  /// As named arrays, views.
  state::State state(const std::string& name);
};

/// A rigid body that moves under the forces of contacts and loads, by steps as those of the nodes: momenta half a step
/// after a time level from forces at it, then the place at the next one. The angular momentum in space is the variable
/// of the rotation, so that a free body conserves it exactly; a free rotation is split into rotations of a top and
/// about an axis of inertia, which are exact both: symplectic, the energy stays within a bound (Dullweber, Leimkuhler
/// and McLachlan 1997; Fasso 2003). docs/rigid_bodies.md has the equations.
class RigidBody
{
public:
  /// @throws std::invalid_argument for a mass or inertia that is not positive where motion is not fixed, or a spin with
  /// some fixed components that are not zero
  explicit RigidBody(const RigidBodyOptions& options);

  // --- the step -------------------------------------------------------------------------------------------------

  /// Works count from here, at the present place; the momenta are those of the time level, nothing moved before.
  void begin();
  /// External force and torque at the present time level.
  void set_loads(const std::array<double, 3>& force, const std::array<double, 3>& torque);
  /// Contact forces at the present time level are known: sums over all ranks and contacts.
  /// @param[in] force on the slaves, moment: see NodalContact::force_moment
  void set_contact_forces(const std::array<double, 3>& force, const gap::Matrix3& moment);
  /// Go on to the next time level.
  /// @param[in] dt step [T]
  /// @param[in] h mean of the steps before and after the time level [T]
  /// @param[in] starts the momenta are those of the time level: nothing moved before
  void advance(double dt, double h, bool starts);
  /// Energies at the present time level, with a step that is not made.
  void measure(double h, bool starts);
  /// The step is complete: works of the step go into the sums.
  void commit();

  // --- the present time level -----------------------------------------------------------------------------------

  /// For contacts.
  gap::RigidMotion motion() const;
  const RigidBodyOptions& options() const { return _options; }
  /// State, with momenta half a step before the present time level.
  const RigidBodyState& state() const { return _now; }
  RigidBodyState& state() { return _now; }
  /// Position of the centre [L].
  std::array<double, 3> position() const;
  /// Rotation since the start, a matrix [1].
  gap::Matrix3 rotation() const;
  /// Momentum at the present time level [M L/T].
  /// @param[in] dt step that led here; 0 at the start [T]
  std::array<double, 3> momentum(double dt) const;
  std::array<double, 3> angular_momentum(double dt) const;
  std::array<double, 3> velocity(double dt) const;
  std::array<double, 3> spin(double dt) const;
  /// Force and torque about the centre of all contacts on the body [F], [F L].
  std::array<double, 3> contact_force() const;
  std::array<double, 3> contact_torque() const;
  /// Kinetic energy with the momenta of the time level; without that of a rotation whose components are all fixed [F
  /// L].
  double kinetic_energy(double dt) const;

  /// Energies of the time level of the last `advance` or `measure`.
  struct Energies
  {
    double kinetic = 0.0; ///< at the time level [F L]
    double after = 0.0;   ///< with the momenta half a step later [F L]
    double before = 0.0;  ///< with those half a step earlier [F L]
  };
  const Energies& energies() const { return _energies; }
  /// Work of loads, and of contact forces on what is fixed, up to the time level, and up to half a step before [F L].
  double external_work() const { return _now.work.value(); }
  double half_external_work() const { return _now.work.done; }

  /// Is the translation, are all components of the spin fixed?
  bool translates() const;
  bool rotates() const { return _inertia.rotates(); }
  /// Upper bound of what a unit force accelerates the body by, at a point at a distance from the centre [1/M].
  double mobility(double arm) const;

private:
  std::array<double, 3> force() const;
  std::array<double, 3> torque() const;
  double kinetic(const RigidBodyState& at, const std::array<double, 3>& momentum,
                 const std::array<double, 3>& angular) const;
  void rotate(double dt);
  double half_work(const RigidBodyState& motion) const;

  RigidBodyOptions _options;
  RigidInertia _inertia;
  RigidBodyState _now;
  std::array<double, 3> _load{}, _load_torque{};
  Energies _energies;
  double _work_after = 0.0; ///< of the step that was made last, by the forces before it [F L]
};
} // namespace dolfinx_impact::integrators
