// SPDX-License-Identifier: MIT
#pragma once
#include "../gap/Rigid.h"
#include "RigidBody.h"
#include <array>
#include <memory>
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
/// What a contact of a rigid body with another one, or with an obstacle, is made with.
struct RigidContactOptions
{
  std::vector<double> points; ///< of the body's surface at the start, before the displacement, [3*i + c] [L]
  std::vector<double> areas;  ///< that belong to the points [L^2]
  double radius = 0.0;        ///< distance of the surface from the points: of a ball, its centre is the point [L]
  gap::Rigid master = {};     ///< what the points meet, at the start
  double friction = 0.0;      ///< coefficient [1]
};

/// Contact of two rigid bodies in explicit steps, by springs between points of one and the surface of the other; see
/// docs/rigid_bodies.md, "Two rigid bodies". All ranks have all of it.
class RigidContact
{
public:
  /// @param[in] slave has the points
  /// @param[in] master null: an obstacle that stays
  /// @throws std::invalid_argument for points and areas that do not fit, or a slave that cannot move
  RigidContact(RigidContactOptions options, std::shared_ptr<RigidBody> slave, std::shared_ptr<RigidBody> master);

  /// Stiffnesses for a step, far below those that it bears [T].
  void set_step(double dt);
  /// Update the forces at the present places of the bodies, after a step or at the start. No allocation.
  void evaluate();

  const std::shared_ptr<RigidBody>& slave() const { return _slave; }
  const std::shared_ptr<RigidBody>& master() const { return _master; }
  /// Force on the slave [F], and its moments about the centres of slave and master, see NodalContact::force_moment [F
  /// L].
  const gap::Vector3& force() const { return _force; }
  const gap::Matrix3& moment_on_slave() const { return _slave_moment; }
  const gap::Matrix3& moment_on_master() const { return _master_moment; }
  /// Energy in the springs, and work of friction so far [F L].
  double stored() const { return memory()[0]; }
  double dissipated() const { return memory()[1]; }
  /// Smallest gap of the points [L].
  double gap() const { return _gap; }
  /// Sum of the springs' stiffnesses along the normal [F/L].
  double stiffness() const { return _stiffness; }

private:
  /// Stored energy, work of friction, friction forces on the slave, [2 + 3*i + c]: in the slave's state.
  std::span<double> memory() const;
  double largest_arm() const;

  RigidContactOptions _options;
  std::shared_ptr<RigidBody> _slave, _master;
  gap::Rigid _surface; ///< of the master, where it is
  double _area = 0.0, _stiffness = 0.0;
  gap::Vector3 _force{};
  gap::Matrix3 _slave_moment{}, _master_moment{};
  std::size_t _memory; ///< where the memory begins
  double _gap = 0.0;   ///< smallest [L]
};
} // namespace dolfinx_impact::integrators
