// SPDX-License-Identifier: MIT
#pragma once
#include "CellLoop.h"
#include <span>
#include <vector>

namespace dolfinx_impact::hand_written
{
/// The central difference method of a linear elastic body, written by hand for one cell, one law and nothing else: what
/// a processor can do, for comparison. Nodes have four numbers, so that a node is one aligned load; vectors are put
/// together in registers; cells are visited in the order given, several at a time.
class HandWrittenStep
{
public:
  /// Cells at a time that there are loops for and that this processor has vectors for: of 4 (AVX2) and 8 (AVX-512).
  static std::vector<int> widths();
  /// @param[in] x positions of the nodes, shape (num_nodes, 3) [L]
  /// @param[in] cells nodes of each cell in DOLFINx's order, shape (num_cells, nodes_per_cell)
  /// @param[in] kind 8 nodes: hexahedra with 2 x 2 x 2 points, or one and hourglass control; 4, 10: tetrahedra with
  /// straight sides and one and four points
  /// @param[in] elasticity Lame's constants
  /// @param[in] mass of each node [M]
  /// @param[in] width cells at a time: 4 (AVX2) or 8 (AVX-512)
  /// @throws std::invalid_argument for other cells or widths, and for arrays whose sizes do not fit
  HandWrittenStep(std::span<const double> x, std::span<const std::int32_t> cells, const CellKind& kind,
                  const Elasticity& elasticity, std::span<const double> mass, int width);
  /// @param[in] u displacements, shape (num_nodes, 3) [L]
  /// @param[in] v velocities, shape (num_nodes, 3) [L/T]
  void start(std::span<const double> u, std::span<const double> v);
  /// Make steps; the first one begins at a time level, so that it gives the velocity half a step's push.
  /// @param[in] num_steps number of steps
  /// @param[in] step length of each [T]
  void run(int num_steps, double step);
  /// Displacements, shape (num_nodes, 3) [L].
  std::vector<double> displacement() const;

private:
  NodalArrays arrays();

  CellLoop _loop;
  Elasticity _elasticity;
  std::size_t _num_nodes, _num_batches;
  std::vector<std::int32_t> _cells;
  std::vector<double> _storage; ///< x, u, v, r, four entries per node; aligned by hand
  std::vector<double> _inverse_mass;
  bool _started = false;
};
} // namespace dolfinx_impact::hand_written
