// SPDX-License-Identifier: MIT
#pragma once
#include "quadrature.h"
#include "shape.h"
#include <cstdint>

namespace impact_reference
{
/// Everything an integrand needs at one integration point.
struct Sample
{
  double weight; ///< rule weight x det J, x 2 pi r if axisymmetric: the volume the point stands for [L^d]
  double radius; ///< r, or 0 if not axisymmetric [L]
  Vector x;      ///< position (gdim) [L]
  Vector N;      ///< shape functions of the field (num_nodes)
  Matrix dN;     ///< their derivatives by position (num_nodes, gdim) [1/L]
};

/// Maps the points of a rule into cells. Field and geometry may have different degrees (sub- and superparametric
/// elements; Zienkiewicz & Taylor vol. 1 ch. 5, Bathe ch. 5.3).
class Sampler
{
public:
  /// @throws std::invalid_argument if the rule does not fit the cell
  Sampler(CellType cell, int degree, int geometry_degree, const Rule& rule, bool axisymmetric);

  int num_points() const { return int(weights_.size()); }
  int num_nodes() const { return int(field_.N.cols()); }
  int gdim() const { return tdim(cell_); }
  bool axisymmetric() const { return axisymmetric_; }

  /// Integration point q of the cell whose geometry nodes are X (num_geometry_nodes, gdim) [L].
  /// @param cell number used in error messages
  /// @throws std::invalid_argument if X has the wrong shape or NaN, the cell is inverted or has no volume, or r < 0
  Sample at(const Matrix& X, int q, std::int64_t cell = 0) const;

private:
  CellType cell_;
  bool axisymmetric_;
  Vector weights_;
  Shapes field_, geometry_;
};

/// Everything a facet integrand needs at one point of a facet.
struct FacetSample
{
  double weight;  ///< rule weight alone; the facet's measure is |normal|
  double radius;  ///< r, or 0 if not axisymmetric [L]
  Vector x;       ///< position (gdim) [L]
  Vector N;       ///< shape functions of the facet's field nodes
  Matrix dN;      ///< their derivatives by the facet's reference coordinates (num_facet_nodes, gdim - 1)
  Matrix tangent; ///< columns x_xi (, x_eta), shape (gdim, gdim - 1) [L]
};

/// Maps the points of a facet rule onto the facets of cells.
class FacetSampler
{
public:
  /// @param cell the cell, whose facet_type the rule belongs to
  FacetSampler(CellType cell, int degree, int geometry_degree, const Rule& rule, bool axisymmetric);

  int num_points() const { return int(weights_.size()); }
  bool axisymmetric() const { return axisymmetric_; }
  CellType cell() const { return cell_; }
  int degree() const { return degree_; }

  /// Point q of facet `facet` of the cell whose geometry nodes are X.
  FacetSample at(const Matrix& X, int facet, int q) const;

private:
  CellType cell_;
  int degree_, geometry_degree_;
  bool axisymmetric_;
  Vector weights_;
  Shapes field_, geometry_;
};

/// Outward normal times area density: x_xi turned clockwise in the plane, x_xi cross x_eta in space.
Vector area_vector(const Matrix& tangent);
} // namespace impact_reference
