// SPDX-License-Identifier: MIT
#pragma once
#include "RigidPlace.h"
#include "contact_surface.h"

namespace impact_reference
{
/// A rigid obstacle, which may be turned and moved.
struct Rigid
{
  enum class Shape
  {
    plane,
    sphere,
    cylinder
  };
  Shape shape;
  Vec<double> point;     ///< a point of the plane, the centre, or a point of the axis [L]
  Vec<double> direction; ///< normal of the plane (out of the obstacle) or axis of the cylinder
  double radius = 0;     ///< [L]
  Vec<double> pivot;     ///< that it turns about, before it is displaced [L]
  RigidPlace place;
};

/// Gap and normal (out of the obstacle).
template <typename T>
struct GapNormal
{
  T gap;
  Vec<T> normal;
};

/// In closed form; a cylinder in the plane has its axis along e_z.
template <typename T>
GapNormal<T> gap_and_normal(const Rigid& rigid, const RigidPlace& place, const Vec<T>& x)
{
  if (norm(place.angle) > 0) // where the point is for the obstacle that is not turned
  {
    const Vec<T> r = x - constant<T>(rigid.pivot + place.displacement);
    const Vec<T> back = constant<T>(rigid.pivot) + turned(-1.0 * place.angle, r);
    const GapNormal<T> at_rest = gap_and_normal<T>(rigid, RigidPlace{}, back);
    return {at_rest.gap, turned(place.angle, at_rest.normal)};
  }
  Vec<T> d = x - constant<T>(rigid.point + place.displacement);
  const Vec<T> direction = constant<T>(rigid.direction);
  if (rigid.shape == Rigid::Shape::plane)
    return {dot(d, direction), direction};
  if (rigid.shape == Rigid::Shape::cylinder)
    d = d - dot(d, direction) * direction;
  const T r = norm(d);
  return {r - rigid.radius, (1.0 / r) * d};
}
} // namespace impact_reference
