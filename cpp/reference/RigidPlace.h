// SPDX-License-Identifier: MIT
#pragma once
#include "Dual.h"

namespace impact_reference
{
/// Where a rigid body is: first it turns by the rotation vector `angle` about its pivot, then it is displaced.
struct RigidPlace
{
  Vec<double> displacement; ///< [L]
  Vec<double> angle;        ///< [1]

  friend RigidPlace operator+(const RigidPlace& a, const RigidPlace& b)
  {
    return {a.displacement + b.displacement, a.angle + b.angle};
  }
  friend RigidPlace operator*(double s, const RigidPlace& a) { return {s * a.displacement, s * a.angle}; }
};

/// v turned by a rotation vector, by Rodrigues' formula.
template <typename T>
Vec<T> turned(const Vec<double>& angle, const Vec<T>& v)
{
  const double size = norm(angle);
  if (size == 0)
    return v;
  const Vec<T> axis = constant<T>((1 / size) * angle);
  return T(std::cos(size)) * v + T(std::sin(size)) * cross(axis, v) + (T(1 - std::cos(size)) * dot(axis, v)) * axis;
}

/// How the point of a body that is at x now has moved between two places.
/// @param pivot before the displacement [L]
template <typename T>
Vec<T> motion_of_point(const Vec<double>& pivot, const RigidPlace& before, const RigidPlace& now, const Vec<T>& x)
{
  const Vec<T> straight = constant<T>(now.displacement - before.displacement);
  if (norm(now.angle) == 0 and norm(before.angle) == 0)
    return straight;
  const Vec<T> r = x - constant<T>(pivot + now.displacement);
  return straight + r - turned(before.angle, turned(-1.0 * now.angle, r));
}
/// How the point of a body that was at x moves between two places.
/// @param pivot before the displacement [L]
inline Vec<double> motion_from(const Vec<double>& pivot, const RigidPlace& before, const RigidPlace& now,
                               const Vec<double>& x)
{
  const Vec<double> straight = now.displacement - before.displacement;
  if (norm(now.angle) == 0 and norm(before.angle) == 0)
    return straight;
  const Vec<double> r = x - pivot - before.displacement;
  return straight + turned(now.angle, turned(-1.0 * before.angle, r)) - r;
}
} // namespace impact_reference
