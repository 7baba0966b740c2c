// SPDX-License-Identifier: MIT
#pragma once
#include <array>
#include <span>

/// Third stage: the surfaces of bodies, their shape functions, nodes and normals.
namespace dolfinx_impact::surface
{
enum class FacetShape
{
  interval,
  triangle,
  quadrilateral
};

/// Lagrange element of degree 1 or 2 on a reference facet, nodes in the order of Basix (interval 0, 1, midpoint;
/// triangle: vertices, then the midpoints of 12, 02, 01; quadrilateral: vertices (0,0) (1,0) (0,1) (1,1), midpoints of
/// 01, 02, 13, 23, centre). Evaluated at arbitrary points, without tables and without allocation.
struct FacetElement
{
  static constexpr int max_nodes = 9;

  FacetShape shape = FacetShape::interval;
  int degree = 1;

  bool operator==(const FacetElement&) const = default;
  /// Dimension of the facet: 1 or 2.
  int tdim() const { return shape == FacetShape::interval ? 1 : 2; }
  int num_nodes() const
  {
    if (shape == FacetShape::interval)
      return degree + 1;
    if (shape == FacetShape::triangle)
      return degree == 1 ? 3 : 6;
    return degree == 1 ? 4 : 9;
  }
  int num_corners() const { return shape == FacetShape::interval ? 2 : shape == FacetShape::triangle ? 3 : 4; }
  /// Reference coordinates of node i (the second is 0 on intervals).
  std::array<double, 2> node(int i) const;
  /// Reference coordinates of the centre.
  std::array<double, 2> centre() const;
  /// Area of the reference facet.
  double reference_area() const { return shape == FacetShape::triangle ? 0.5 : 1.0; }
  /// @param[in] xi tdim reference coordinates
  /// @param[out] phi num_nodes values
  void values(const double* xi, double* phi) const;
  /// @param[out] dphi dphi[alpha*num_nodes + i], derivative of node i's function by coordinate alpha
  void derivatives(const double* xi, double* dphi) const;
  /// @param[out] ddphi interval: num_nodes values; else ddphi[k*num_nodes + i] with k = 0, 1, 2 for 11, 22, 12
  void second_derivatives(const double* xi, double* ddphi) const;
  /// Is xi inside the reference facet, widened by `margin`?
  bool inside(const double* xi, double margin = 0.0) const;
};

/// Corners at the ends of an edge of a facet of dimension 2; in a facet of dimension 1 edge 0 is the facet.
const int* edge_corners(FacetShape shape, int edge);
} // namespace dolfinx_impact::surface
