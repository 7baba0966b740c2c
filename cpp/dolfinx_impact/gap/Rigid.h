#pragma once
#include <array>

/// Fifth stage: gaps between slave and master, and their integrals.
namespace impact::gap
{
/// A rigid obstacle as master.
struct Rigid
{
  enum class Kind
  {
    plane,
    sphere,
    cylinder
  };

  Kind kind = Kind::plane;
  int gdim = 3;
  std::array<double, 3> point{};            ///< of the plane; centre of the sphere; on the axis of the cylinder [L]
  std::array<double, 3> direction{0, 0, 1}; ///< unit normal of the plane, out of it; unit axis of the cylinder
  double radius = 0.0;                      ///< [L]; negative: the body is inside, as in a bore
  std::array<double, 3> displacement{};     ///< added to `point` [L]
};

/// Signed distance of a point and its derivatives.
struct RigidPoint
{
  double gap;        ///< positive outside the obstacle [L]
  double normal[3];  ///< d gap / d x: unit, out of the obstacle
  double hessian[9]; ///< d normal / d x [1/L]
};

/// @param[in] x gdim coordinates. In the plane a cylinder is a circle; its axis points out of the plane.
RigidPoint evaluate(const Rigid& rigid, const double* x);
} // namespace impact::gap
