// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <span>

namespace dolfinx_impact::operators
{
/// Nodal vectors of some cells, and what their derivatives at one point of the cells are made of.
struct CellVectors
{
  std::span<const double> values;      ///< [stride*node + component]
  int stride = 0;                      ///< entries per node
  std::span<const std::int32_t> nodes; ///< of all cells of the mesh, cell by cell
  std::span<const double>
      derivatives; ///< of the shape functions in reference coordinates, shape (gdim, nodes of a cell)
};

/// How far a cell has turned.
struct CellRotation
{
  double angle = 0.0;     ///< from 0 to pi [rad]
  std::int32_t cell = -1; ///< -1: none has turned further than was asked for
};

/// The cell that has turned furthest at a point, by the angle of the skew part of F = I + grad u, which is exact where
/// F only turns. Most cells of most runs have not turned far, which takes no more than products to see.
/// @param[in] positions of the mesh's nodes [L]
/// @param[in] displacements [L]
/// @param[in] cells numbers of the cells; those without volume do not count
/// @param[in] gdim 2 or 3, which is also the cells' dimension
/// @param[in] beyond only rotations that are larger count, at least 0 and below a right angle [rad]
/// @throws std::invalid_argument for another dimension or `beyond`
CellRotation largest_rotation(const CellVectors& positions, const CellVectors& displacements,
                              std::span<const std::int32_t> cells, int gdim, double beyond);
} // namespace dolfinx_impact::operators
