// SPDX-License-Identifier: MIT
#pragma once
#include "RigidMotion.h"
#include "Shape.h"
#include <array>
#include <memory>
#include <string>

namespace dolfinx_impact::gap
{
/// A rigid obstacle as master.
struct Rigid
{
  enum class Kind
  {
    plane,
    sphere,
    cylinder,
    surface ///< of any form: `shape`
  };

  Kind kind = Kind::plane;
  int gdim = 3;
  std::array<double, 3> point{};            ///< of the plane; centre of the sphere; on the axis of the cylinder [L]
  std::array<double, 3> direction{0, 0, 1}; ///< unit normal of the plane, out of it; unit axis of the cylinder
  double radius = 0.0;                      ///< [L]; negative: the body is inside, as in a bore
  std::array<double, 3> displacement{};     ///< added to `point`, or of the shape [L]
  std::array<double, 3> centre{};           ///< about which it rotates, before the displacement [L]
  bool rotates = false;                     ///< without, it is where it was made but for the displacement
  Matrix3 rotation = identity;              ///< about the centre
  std::shared_ptr<const Shape> shape{};     ///< of a surface
  /// What can be changed if the body is on its wrong side; the end of an error.
  std::string orientation_hint = "turn its normal round, or change the sign of its radius";
};

/// Signed distance to an obstacle. In the plane a cylinder is a circle; its axis points out of the plane.
/// @param[in] x position, (gdim) [L]
/// @pre x.size() is at least rigid.gdim
RigidPoint evaluate(const Rigid& rigid, std::span<const double> x);
/// Largest size of a number that the obstacle's position is computed from: gaps are known to its rounding [L].
double largest_position(const Rigid& rigid);
} // namespace dolfinx_impact::gap
