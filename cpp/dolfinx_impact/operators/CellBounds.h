// SPDX-License-Identifier: MIT
#pragma once
#include "lump.h"
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace dolfinx_impact::operators
{
/// Which owned cells are meant; nothing: all.
typedef std::optional<std::span<const std::int8_t>> CellMask;

/// Bounds of the eigenvalues of a bilinear form's cell matrices over the cells' masses. Integrals over a cell's facets
/// belong to the cell, those over a facet between two cells to both. docs/explicit/stable_step.md.
class CellBounds
{
public:
  struct Part
  {
    Integral integral; ///< kernel that CellMatrix takes, this rank's entities
    Coefficients coefficients;
    bool varies = true; ///< does it read functions? Else what was found is kept
  };

  CellBounds(std::shared_ptr<const FunctionSpace> V, std::vector<Part> parts);

  std::size_t num_parts() const { return _parts.size(); }
  /// @throws std::invalid_argument for another number of constants
  void set_constants(std::size_t i, std::span<const double> c);
  /// Are there integrals over facets between cells?
  bool joins_cells() const;

  /// Collective. The sums over the cells of bound times mass are bounds of the assembled matrix: of a facet between two
  /// cells, the eigenvalues over the masses of both count for each of them.
  /// @pre coefficients have up-to-date ghost values
  /// @param[in] masses lumped, by owned cell and local degree of freedom [M]
  /// @param[in] only mask of the owned cells whose integrals count; nothing: all
  /// @param[in] facets do integrals over facets count?
  /// @returns [3*cell]: lower bound, upper bound, norm of the skew-symmetric part, in the form's unit over [M]
  /// @throws std::invalid_argument on all ranks for a matrix with entries that are not finite
  std::vector<double> spectra(std::span<const double> masses, CellMask only = std::nullopt, bool facets = true);

private:
  /// What a part without functions had, and what it followed from.
  struct Kept
  {
    std::size_t digest = 0;
    std::vector<double> spectra;
  };

  std::shared_ptr<const FunctionSpace> _space;
  std::vector<Part> _parts;
  std::vector<Kept> _kept;
};
} // namespace dolfinx_impact::operators
