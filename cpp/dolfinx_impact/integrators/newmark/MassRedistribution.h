// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <dolfinx/fem/FunctionSpace.h>
#include <memory>
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Nodes of contact surfaces, and the cells that pass their mass on.
///
/// The mass of a contact node goes, cell by cell, to the nodes of the cell that are on no contact surface: in the
/// kinetic energy of the cell the velocity of a contact node is the mean of theirs, v_c = sum_i w_ci v_i with w_ci ~
/// 1/|x_i - x_c|^2. The cell keeps its mass and its momentum, and its mass matrix stays positive semi-definite. In
/// place of the global problem of Khenous, Laborde and Renard (2008) it needs nothing but the cells at the surface, as
/// the quadrature formulas of Hager, Hueeber and Wohlmuth (2008).
class MassRedistribution
{
public:
  typedef dolfinx::fem::FunctionSpace<double> Space;

  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] facets of all contact surfaces on this rank
  MassRedistribution(std::shared_ptr<const Space> V, std::span<const std::int32_t> facets);

  /// Mask of nodes on a contact surface, owned and ghosts.
  const std::vector<std::int8_t>& on_surface() const { return _on_surface; }
  /// Mask of those whose cells all pass their mass on, owned and ghosts: a cell without other nodes keeps the mass of
  /// its contact nodes.
  const std::vector<std::int8_t>& massless() const { return _massless; }
  /// Owned cells that pass mass on, sorted.
  const std::vector<std::int32_t>& cells() const { return _cells; }
  /// Velocities of a cell's nodes as means of those of its nodes on no contact surface: a matrix T, [i*n + j] over its
  /// n nodes, with unit rows for the other nodes [1].
  std::vector<double> weights(std::int32_t cell) const;
  /// T^T M T of a cell's mass matrix.
  /// @param[in] M over the cell's degrees of freedom, node by node, [i*size + j] [M]
  std::vector<double> matrix(std::int32_t cell, std::span<const double> M) const;
  /// Lumped masses of a cell after redistribution.
  /// @param[in] masses over the cell's degrees of freedom, node by node [M]
  std::vector<double> lumped(std::int32_t cell, std::span<const double> masses) const;

private:
  std::shared_ptr<const Space> _space;
  std::vector<std::int8_t> _on_surface, _massless;
  std::vector<std::int32_t> _cells;
  std::vector<double> _x; ///< of nodes, three coordinates each [L]
};
} // namespace dolfinx_impact::integrators
