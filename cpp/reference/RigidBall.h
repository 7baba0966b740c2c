// SPDX-License-Identifier: MIT
#pragma once
#include "Dual.h"
#include "contact_rigid.h"

namespace impact_reference
{
/// A rigid ball, in the plane a disc, that contact and a constant force move: docs/rigid_bodies.md for a body whose
/// inertia is the same about all axes, which needs no rotation of its own; points are turned by Rodrigues' formula.
class RigidBall
{
public:
  /// @param centre, velocity, spin at the start [L], [L/T], [1/T]
  /// @param mass, inertia about the centre [M], [M L^2]
  /// @param force external [F]
  RigidBall(int gdim, double radius, Vec<double> centre, double mass, double inertia, Vec<double> velocity,
            Vec<double> spin, Vec<double> force);

  const Vec<double>& displacement() const { return displacement_; }
  /// Since the time level before [L].
  const Vec<double>& moved() const { return moved_; }
  /// How the ball's point that is at x now has moved since the time level before [L].
  Vec<double> moved_at(const Vec<double>& x) const;

  /// Forces on the slave are counted from here.
  void clear();
  /// A contact force on a slave node at x.
  void add(const Vec<double>& force, const Vec<double>& x);
  /// Velocities after the time level, by the forces at it; energies at it.
  /// @param mean of the steps before and after it [T]
  void push(double mean, bool first);
  /// Go on to the next time level.
  void move(double dt);

  double kinetic() const { return kinetic_; }   ///< at the time level [F L]
  double external() const { return external_; } ///< work of the external force up to it [F L]
  /// Area of the slave times the acceleration by a unit force, at most, of all contact points [L^2/M].
  double mobility(double area, bool friction) const;

private:
  int gdim_;
  double radius_, mass_, inertia_;
  Vec<double> centre_, velocity_, spin_, load_, displacement_, moved_, angle_, force_, torque_;
  double kinetic_ = 0, external_ = 0;
};
} // namespace impact_reference
