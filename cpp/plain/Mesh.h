// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <string>
#include <vector>

/// Plain data, shared by the DOLFINx side and the hand-written solver: structs of named arrays, no functions.
namespace impact_plain
{
/// Cells and node positions in flat arrays.
/// Node i is points[gdim*i ... gdim*i + gdim-1]; cell c is cells[n*c ... n*c + n-1] with n nodes per cell. The order of
/// the nodes inside a cell belongs to whoever fills the struct, and is written down there.
struct Mesh
{
  std::string cell_type;      ///< "triangle", "quadrilateral", "tetrahedron", "hexahedron"
  int degree = 1;             ///< polynomial degree of the geometry: 1 or 2
  int gdim = 3;               ///< 2 or 3
  std::vector<double> points; ///< [L]
  std::vector<std::int64_t> cells;
  std::vector<std::int32_t> cell_tags; ///< one per cell, or empty
};
} // namespace impact_plain
