// SPDX-License-Identifier: MIT
#pragma once
#include "contact_surface.h"

namespace impact_reference
{
/// A rigid obstacle; it may be moved, not turned.
struct Rigid
{
  enum class Shape
  {
    plane,
    sphere,
    cylinder
  };
  Shape shape;
  Vec<double> point;        ///< a point of the plane, the centre, or a point of the axis [L]
  Vec<double> direction;    ///< normal of the plane (out of the obstacle) or axis of the cylinder
  double radius = 0;        ///< [L]
  Vec<double> displacement; ///< [L]
};

/// Gap and normal (out of the obstacle).
template <typename T>
struct GapNormal
{
  T gap;
  Vec<T> normal;
};

/// In closed form; a cylinder in the plane has its axis along e_z.
/// @param displacement of the obstacle [L]
template <typename T>
GapNormal<T> gap_and_normal(const Rigid& rigid, const Vec<double>& displacement, const Vec<T>& x)
{
  Vec<T> d = x - constant<T>(rigid.point + displacement);
  const Vec<T> direction = constant<T>(rigid.direction);
  if (rigid.shape == Rigid::Shape::plane)
    return {dot(d, direction), direction};
  if (rigid.shape == Rigid::Shape::cylinder)
    d = d - dot(d, direction) * direction;
  const T r = norm(d);
  return {r - rigid.radius, (1.0 / r) * d};
}
} // namespace impact_reference
