// SPDX-License-Identifier: MIT
#pragma once
#include "Batches.h"
#include <optional>

namespace dolfinx_impact::operators
{
/// What a kernel reads of one cell, or of the two cells of an interior facet, at a time: values of coefficients and
/// coordinates of nodes.
class CellValues
{
public:
  /// @param[in] kernel of any rank
  /// @param[in] V space whose mesh and cells are meant
  /// @param[in] coefficients by the kernel's names, ghosts up to date; the direction of CellMatrix may be missing
  /// @param[in] history internal variables on cells of the same rule: coefficients that have none of the names above
  ///   are read there, committed ones, and the solution of the local equations of the last evaluation
  /// @throws std::runtime_error if the kernel is not for this mesh or a coefficient's space
  /// @throws std::invalid_argument if a coefficient is missing or on another mesh, or a history has another size
  CellValues(const impact_kernel& kernel, const FunctionSpace& V, const Coefficients& coefficients,
             std::shared_ptr<const PointHistory> history = nullptr);

  /// Read a cell.
  /// @param[in] side of an interior facet, 0 for "+" and 1 for "-"; 0 for other kernels
  void gather(std::int32_t cell, int side = 0);
  const double* w() const { return _w.data(); }
  std::span<const double> nodes() const { return _nodes; }

private:
  /// Where a coefficient comes from: a function, or a field of the history; neither for the direction.
  struct Source
  {
    std::shared_ptr<const Function> function;
    std::optional<std::size_t> field;
  };
  Source source(const impact_coefficient& c, const Coefficients& coefficients) const;

  const impact_kernel& _kernel;
  const FunctionSpace& _space;
  std::vector<Source> _sources; ///< in the kernel's order
  std::shared_ptr<const PointHistory> _history;
  std::vector<std::int32_t> _places; ///< of the mesh's cells in the history; -1: not there
  std::vector<double> _w, _nodes;
};
} // namespace dolfinx_impact::operators
