// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <span>
#include <vector>

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

/// Rotations of cells at a point: the angle of the skew part of F = I + grad u, exact where F only turns.
/// @param[in] positions of the mesh's nodes [L]
/// @param[in] displacements [L]
/// @param[in] cells numbers of the cells
/// @param[in] gdim 2 or 3, which is also the cells' dimension
/// @returns angles from 0 to pi [rad]; not finite for cells without volume
/// @throws std::invalid_argument for another dimension
std::vector<double> cell_rotations(const CellVectors& positions, const CellVectors& displacements,
                                   std::span<const std::int32_t> cells, int gdim);
} // namespace dolfinx_impact::operators
