// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/CellBounds.h"
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Highest frequencies of the cells of bodies, and their damping.
class CellFrequencies
{
public:
  /// Lumped masses of owned cells by local degree of freedom [M]; called when they are needed.
  typedef std::function<std::vector<double>()> Masses;

  /// @param[in] stiffness derivative of the internal force
  /// @param[in] damping derivative with respect to the velocity of damping that differs between cells; null: there is
  /// none
  CellFrequencies(std::shared_ptr<const operators::FunctionSpace> V, std::shared_ptr<operators::CellBounds> stiffness,
                  std::shared_ptr<operators::CellBounds> damping, Masses masses);

  /// Keep the masses once they are known: frequencies will be asked for often. Else they take no memory.
  void keep_masses() { _keeps = true; }
  /// With the factors of mass scaling [M].
  /// @param[in] only mask of the owned cells whose masses are read, those of others are zero; nothing: all
  std::vector<double> masses(operators::CellMask only = std::nullopt) const;
  struct Spectra
  {
    std::vector<double> squares; ///< of the highest angular frequency, by cell [1/T^2]
    std::vector<double> rates;   ///< largest eigenvalue of damping over mass, by cell [1/T]
  };
  /// Largest eigenvalues of owned cells. Collective.
  /// @pre coefficients have up-to-date ghost values
  /// @param[in] only mask of the cells that are asked for; nothing: all
  /// @returns those of the cells that are asked for
  /// @throws common::BadValue if the stiffness of a cell is not finite
  Spectra by_cell(operators::CellMask only = std::nullopt);
  /// Sum over the cells at a node of its mass in the cell times the square of the cell's highest frequency, facets left
  /// out. Collective.
  /// @pre the displacement that kernels read is zero
  /// @param[in] nodes mask of the nodes that are asked for, owned and ghosts
  /// @returns by owned and ghost node, right at these nodes; zero where the stiffness is zero or no number [F/L]
  std::vector<double> nodal_stiffness(std::span<const std::int8_t> nodes);
  /// Add mass to cells whose own stable step is less than dt. Collective.
  /// @returns added mass, of all ranks [M]
  double scale_mass(double dt);
  /// Sum of the cells' masses at the nodes, owned and ghosts. Collective [M].
  std::vector<double> nodal_masses() const;

  /// Calls of by_cell, and cells that they were about, of this rank.
  std::int64_t num_looks() const { return _num_looks; }
  std::int64_t num_cells_looked_at() const { return _num_cells; }

private:
  std::size_t width() const;

  std::shared_ptr<const operators::FunctionSpace> _space;
  std::shared_ptr<operators::CellBounds> _stiffness, _damping;
  Masses _masses;
  bool _keeps = false;
  /// Masses without factors, by owned cell and local node, or degree of freedom where those of a node differ; nothing:
  /// not known yet, or not kept. All ranks have them, or none: to compute them is collective [M].
  mutable std::optional<std::vector<double>> _kept;
  mutable bool _by_node = false; ///< is `_kept` by node?
  std::vector<double> _factor;   ///< of each owned cell's mass; empty: no factors [1]
  std::int64_t _num_looks = 0, _num_cells = 0;
};
} // namespace dolfinx_impact::integrators
