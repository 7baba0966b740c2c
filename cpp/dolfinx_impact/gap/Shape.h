// SPDX-License-Identifier: MIT
#pragma once

/// Fifth stage: gaps between slave and master, and their integrals.
namespace dolfinx_impact::gap
{
/// Signed distance of a point and its derivatives.
struct RigidPoint
{
  double gap;        ///< positive outside the obstacle [L]
  double normal[3];  ///< d gap / d x: unit, out of the obstacle
  double hessian[9]; ///< d normal / d x [1/L]
};

/// Surface of a rigid obstacle of any form, where it was made. Immutable: obstacles may share it.
class Shape
{
public:
  virtual ~Shape() = default;
  virtual int gdim() const = 0;
  /// Signed distance from the surface's closest point to x, gdim coordinates. No allocation.
  virtual RigidPoint closest(const double* x) const = 0;
};
} // namespace dolfinx_impact::gap
