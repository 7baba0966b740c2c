// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Looks whether cells have deformed since a reference by more than an amount of each: then the stable step may have
/// changed, docs/explicit/stable_step.md. The deformation of a cell is the largest difference of a displacement
/// component between two of its nodes; that of a rotation counts, too.
class DeformationWatch
{
public:
  /// @param[in] nodes of this rank's owned cells, cell by cell
  /// @param[in] nodes_per_cell number of each cell's nodes
  /// @param[in] bs components per node
  /// @param[in] stride entries per node of displacements
  DeformationWatch(std::span<const std::int32_t> nodes, int nodes_per_cell, int bs, int stride);

  /// @param[in] u displacements from now on compared with, nodes of owned cells [L]
  /// @param[in] allowed deformation of each owned cell [L]
  void set(std::span<const double> u, std::span<const double> allowed);
  bool is_set() const { return _set; }
  /// @param[in] u displacements, nodes of owned cells [L]
  /// @returns deformation of each owned cell since `set` [L]
  std::vector<double> deformations(std::span<const double> u);
  /// @param[in] u displacements, nodes of owned cells [L]
  /// @returns has a cell of this rank deformed by more than it is allowed?
  bool passed(std::span<const double> u);

private:
  void move_to(std::span<const double> u);

  std::vector<std::int32_t> _nodes;
  int _width, _bs, _stride;
  bool _set = false;
  std::vector<double> _reference, _moved; ///< by node and entry
  std::vector<double> _allowed;           ///< by cell
};
} // namespace dolfinx_impact::integrators
