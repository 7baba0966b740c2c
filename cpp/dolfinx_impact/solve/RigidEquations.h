// SPDX-License-Identifier: MIT
#pragma once
#include "../gap/rotation.h"
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::solve
{
/// Where a rigid body is.
struct RigidPlace
{
  gap::Vector3 displacement{};           ///< of its centre [L]
  gap::Matrix3 rotation = gap::identity; ///< about its centre
};

/// What the equations of a rigid body lack, by unknown: forces, and torques over a length.
struct RigidBalance
{
  std::vector<double> missing; ///< [F]
  double size = 0.0;           ///< largest of the forces that should balance [F]
  double round_off = 0.0;      ///< of the forces, from that of places [F]
};

/// A rigid body in one increment: where it is for values of its unknowns, lengths, and what its equations lack there.
class RigidEquations
{
public:
  virtual ~RigidEquations() = default;
  /// Number of unknowns.
  virtual std::size_t size() const = 0;
  /// What an unknown moves the body along: x, y, z, rx, ry, rz.
  virtual std::string component(std::size_t unknown) const = 0;
  /// Values to begin with [L].
  virtual std::vector<double> first_guess() const = 0;
  /// @param[in] q values of the unknowns [L]
  virtual RigidPlace place(std::span<const double> q) const = 0;
  /// Place of the centre before the displacement [L].
  virtual gap::Vector3 centre() const = 0;
  /// @param[in] q values of the unknowns [L]
  /// @param[in] force, torque of all contacts on the body, about its centre there [F], [F L]
  virtual RigidBalance balance(std::span<const double> q, const gap::Vector3& force,
                               const gap::Vector3& torque) const = 0;
  /// Derivatives of the missing forces by their own unknowns at given contact forces [F/L].
  virtual std::vector<double> derivatives() const { return std::vector<double>(size(), 0.0); }
  /// Whether contacts alone hold it, so that it must touch something.
  virtual bool needs_contact() const = 0;
  /// Does it turn?
  virtual bool turns() const = 0;
};
} // namespace dolfinx_impact::solve
