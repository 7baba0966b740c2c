// SPDX-License-Identifier: MIT
#pragma once
#include <array>

namespace dolfinx_impact::gap
{
/// A 3 x 3 matrix, row by row.
typedef std::array<double, 9> Matrix3;

constexpr Matrix3 identity{1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};

/// Where a rigid master is, and how it has moved in the last step. The point X of the undisplaced master is at
/// x = centre + rotation (X - centre) + displacement.
struct RigidMotion
{
  std::array<double, 3> displacement{}; ///< of the centre [L]
  std::array<double, 3> increment{};    ///< of the displacement in the last step [L]
  bool rotates = false;                 ///< without, what follows has no effect
  Matrix3 rotation = identity;          ///< about the centre
  /// What the last step has added to the rotation, times the inverse of the rotation: the point that is now at the arm
  /// r from the centre has moved by increment + turn r [1].
  Matrix3 turn{};
};
} // namespace dolfinx_impact::gap
