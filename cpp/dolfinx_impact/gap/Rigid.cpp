// SPDX-License-Identifier: MIT
#include "Rigid.h"
#include <algorithm>
#include <cassert>
#include <cmath>

namespace dolfinx_impact::gap
{
namespace
{
/// Signed distance to an obstacle that may be displaced, but does not rotate.
RigidPoint evaluate_straight(const Rigid& rigid, std::span<const double> x)
{
  if (rigid.kind == Rigid::Kind::surface)
  {
    double moved[3];
    for (int c = 0; c < rigid.gdim; ++c)
      moved[c] = x[c] - rigid.displacement[c];
    return rigid.shape->closest(std::span(moved, rigid.gdim));
  }
  RigidPoint out{};
  double d[3] = {0.0, 0.0, 0.0}, along = 0.0;
  for (int c = 0; c < rigid.gdim; ++c)
  {
    d[c] = x[c] - rigid.point[c] - rigid.displacement[c];
    along += d[c] * rigid.direction[c];
  }
  if (rigid.kind == Rigid::Kind::plane)
  {
    out.gap = along;
    for (int c = 0; c < rigid.gdim; ++c)
      out.normal[c] = rigid.direction[c];
    return out;
  }
  // Distance from the centre or from the axis; P projects on what the distance depends on.
  const bool axis = rigid.kind == Rigid::Kind::cylinder && rigid.gdim == 3;
  double distance = 0.0;
  for (int c = 0; c < rigid.gdim; ++c)
  {
    d[c] -= axis ? along * rigid.direction[c] : 0.0;
    distance += d[c] * d[c];
  }
  distance = std::sqrt(distance);
  // Inside a bore the normal points towards the axis.
  const double sign = rigid.radius < 0.0 ? -1.0 : 1.0;
  out.gap = sign * (distance - std::abs(rigid.radius));
  for (int c = 0; c < rigid.gdim; ++c)
    out.normal[c] = sign * d[c] / distance;
  for (int a = 0; a < rigid.gdim; ++a)
    for (int b = 0; b < rigid.gdim; ++b)
    {
      const double projector = (a == b ? 1.0 : 0.0) - (axis ? rigid.direction[a] * rigid.direction[b] : 0.0);
      out.hessian[3 * a + b] = sign * (projector - out.normal[a] * out.normal[b]) / distance;
    }
  return out;
}
} // namespace

RigidPoint evaluate(const Rigid& rigid, std::span<const double> x)
{
  assert(x.size() >= std::size_t(rigid.gdim));
  if (!rigid.rotates)
    return evaluate_straight(rigid, x);
  // The point as the undisplaced obstacle sees it; gap, normal and curvature turn with the obstacle.
  const int g = rigid.gdim;
  const Matrix3& R = rigid.rotation;
  double there[3] = {0.0, 0.0, 0.0};
  for (int a = 0; a < g; ++a)
  {
    there[a] = rigid.centre[a] + rigid.displacement[a];
    for (int b = 0; b < g; ++b)
      there[a] += R[3 * b + a] * (x[b] - rigid.centre[b] - rigid.displacement[b]);
  }
  const RigidPoint straight = evaluate_straight(rigid, std::span(there, std::size_t(g)));
  RigidPoint out{straight.gap, {}, {}};
  for (int a = 0; a < g; ++a)
    for (int b = 0; b < g; ++b)
    {
      out.normal[a] += R[3 * a + b] * straight.normal[b];
      for (int c = 0; c < g; ++c)
        for (int d = 0; d < g; ++d)
          out.hessian[3 * a + b] += R[3 * a + c] * straight.hessian[3 * c + d] * R[3 * b + d];
    }
  return out;
}

double largest_position(const Rigid& rigid)
{
  double largest = 0.0, moved = 0.0;
  for (double u : rigid.displacement)
    moved = std::max(moved, std::abs(u));
  if (rigid.rotates)
    for (double c : rigid.centre)
      moved = std::max(moved, std::abs(c));
  if (rigid.kind == Rigid::Kind::surface)
    return moved + rigid.shape->largest_coordinate();
  for (double x : rigid.point)
    largest = std::max(largest, std::abs(x));
  return moved + largest + std::abs(rigid.radius);
}
} // namespace dolfinx_impact::gap
