// SPDX-License-Identifier: MIT
#pragma once
#include "Cell.h"

namespace impact_reference
{
/// Shape functions tabulated at points.
struct Shapes
{
  Matrix N;               ///< (num_points, num_nodes)
  std::vector<Matrix> dN; ///< per point: (num_nodes, tdim), derivatives by the reference coordinates
};

/// Lagrange shape functions: area and volume coordinates on simplices, products of one-dimensional Lagrange polynomials
/// on tensor cells (Zienkiewicz & Taylor vol. 1 ch. 4; Hughes ch. 3). Nodes in the order of node_vertices.
/// @param points reference coordinates, shape (num_points, tdim)
/// @throws std::invalid_argument for a wrong degree or a wrong number of columns
Shapes shape_functions(CellType cell, int degree, const Matrix& points);
} // namespace impact_reference
