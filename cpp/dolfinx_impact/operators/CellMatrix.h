// SPDX-License-Identifier: MIT
#pragma once
#include "../kernels/Kernel.h"
#include <optional>
#include <span>
#include <vector>

namespace dolfinx_impact::operators
{
/// Name of the coefficient in whose place a kernel of rank 1 has the trial function.
inline constexpr const char* direction_name = "direction of the tangent";

/// Matrices of cells or facets (of both cells of an interior one): by a kernel of rank 2, of some cells at a time; or
/// by a kernel of rank 1 that is linear in the coefficient `direction_name`, a column in each of its lanes, with one of
/// the direction's degrees of freedom set there. Averages over a cell are sums over its points, which a kernel of rank
/// 1 makes once per column.
class CellMatrix
{
public:
  /// @param[in] direction number of the direction among the kernel's coefficients; nothing: the one of that name
  /// @throws std::invalid_argument for another kernel: not of rank 2, and of rank 1 without that coefficient
  explicit CellMatrix(const impact_kernel& kernel, std::optional<int> direction = std::nullopt);

  int num_rows() const { return _num_rows; }
  int num_columns() const { return _num_columns; }
  /// Matrices that one call of `add` computes. More than one: entry i of an array of a cell stands at
  /// [num_cells() * i + lane], and arrays are aligned as AlignedVector is.
  int num_cells() const { return _first < 0 ? _width : 1; }
  /// Add the matrices to A, row by row.
  /// @param[in] w coefficients as the kernel packs them; values of the direction do not count
  /// @param[in] c constants, the same for all cells
  /// @param[in] x coordinates of the cells' nodes
  /// @param[in] facet number of the facet in the cell, or what a kernel of interior facets takes as its entity
  void add(double* A, const double* w, std::span<const double> c, std::span<const double> x, int facet);

private:
  void add_columns(double* A, const double* w, std::span<const double> c, std::span<const double> x, int facet);

  int _width;
  impact_tabulate _tabulate;
  int _num_rows, _num_columns, _size_w, _size_A, _first = -1; ///< _first: entry of the direction in w; -1: of rank 2
  std::vector<double> _buffer;                                ///< columns, w and x of all lanes, aligned by hand
};
} // namespace dolfinx_impact::operators
