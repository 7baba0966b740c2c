// SPDX-License-Identifier: MIT
#pragma once
#include "Shape.h"
#include <array>
#include <vector>

namespace dolfinx_impact::gap
{
/// Surface z = h(a) over a line or a rectangle of a plane, h a cubic spline on a uniform grid; beyond the grid it goes
/// on straight. The normal and its derivative are those of the spline: twice differentiable, gaps are continuous with
/// their second derivatives where the point is nearer than the centres of curvature.
class HeightField : public Shape
{
public:
  struct Grid
  {
    std::array<double, 2> low{};     ///< first coordinate of the grid [L]
    std::array<double, 2> spacing{}; ///< [L]
    std::array<int, 2> cells{};
  };

  /// @param[in] gdim 2 (a line: the first entries of the grid) or 3
  /// @param[in] origin a point of the plane z = 0 [L]
  /// @param[in] axes directions of the coordinates a (one or two) and of z, out of the obstacle: unit, orthogonal
  /// @param[in] coefficients of the B-splines, cells + 3 in each direction, the last direction fastest [L]
  /// @throws std::invalid_argument for sizes that do not fit
  HeightField(int gdim, const std::array<double, 3>& origin, const std::array<std::array<double, 3>, 3>& axes,
              const Grid& grid, std::vector<double> coefficients);

  int gdim() const override { return _gdim; }
  double largest_coordinate() const override;
  RigidPoint closest(std::span<const double> x) const override;

private:
  /// Height with its first and second derivatives: h, h_1, h_2, h_11, h_12, h_22.
  struct Height
  {
    double value, slope[2], bend[3];
  };
  Height height(const double* a) const;

  int _gdim;
  std::array<double, 3> _origin;
  std::array<std::array<double, 3>, 3> _axes;
  Grid _grid;
  std::vector<double> _coefficients;
};
} // namespace dolfinx_impact::gap
