// SPDX-License-Identifier: MIT
#pragma once
#include "../gap/rotation.h"
#include <array>

namespace dolfinx_impact::integrators
{
/// Inertia of a rigid body, and which components of its spin are fixed: spins of angular momenta, and how a body turns
/// whose angular momentum stays. docs/rigid_bodies.md has the equations.
class RigidInertia
{
public:
  RigidInertia() = default;
  /// @param[in] inertia about the centre, at the start [M L^2]
  /// @param[in] fixed components of the spin that stay as they are
  /// @param[in] spin at the start [1/T]
  /// @throws std::invalid_argument for an inertia that is not positive where rotation is not fixed, or a spin with some
  /// fixed components that are not zero
  RigidInertia(const gap::Matrix3& inertia, const std::array<bool, 3>& fixed, const gap::Vector3& spin);

  /// Are not all components of the spin fixed?
  bool rotates() const { return _rotation != Rotation::fixed; }
  /// Angular velocity of a body with an angular momentum; the constant one if all components are fixed [1/T].
  gap::Vector3 spin(const gap::Vector3& momentum, const gap::Quaternion& rotation) const;
  /// Rotation after a time in which the angular momentum stays.
  gap::Quaternion turned(const gap::Quaternion& rotation, const gap::Vector3& momentum, double dt) const;
  /// Least and largest principal moment; zero for a body that does not rotate [M L^2].
  double least() const { return _least; }
  double largest() const { return _largest; }

private:
  enum class Rotation
  {
    fixed, ///< with constant spin
    free,
    partly ///< some components are zero
  };
  gap::Matrix3 inertia_at(const gap::Quaternion& rotation) const;

  Rotation _rotation = Rotation::fixed;
  std::array<bool, 3> _fixed{true, true, true};
  gap::Vector3 _spin{};                         ///< of a body whose components are all fixed
  std::array<double, 3> _moments{};             ///< principal; the first two are those that differ least [M L^2]
  std::array<std::array<double, 3>, 3> _axes{}; ///< principal axes at the start, right-handed [1]
  double _least = 0.0, _largest = 0.0;
};
} // namespace dolfinx_impact::integrators
