// SPDX-License-Identifier: MIT
#pragma once
#include <span>

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
  /// Largest absolute value of a coordinate of the surface [L].
  virtual double largest_coordinate() const = 0;
  /// Signed distance to the closest point of the surface. No allocation.
  /// @param[in] x position, (gdim) [L]
  /// @pre x.size() is at least gdim()
  virtual RigidPoint closest(std::span<const double> x) const = 0;
};
} // namespace dolfinx_impact::gap
