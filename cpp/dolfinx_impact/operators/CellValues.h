// SPDX-License-Identifier: MIT
#pragma once
#include "Batches.h"
#include "lanes.h"

namespace dolfinx_impact::operators
{
/// What a kernel reads of one cell, of the two cells of an interior facet, or of some cells at a time: values of
/// coefficients and coordinates of nodes. Entry i of a cell stands at [num_cells * i + lane].
class CellValues
{
public:
  /// Where a coefficient comes from: a function with ghosts up to date, or a field of a history; neither: it is zero,
  /// as the direction of CellMatrix, which is set there.
  struct Source
  {
    std::shared_ptr<const Function> function = nullptr;
    std::string field = "";
  };

  /// @param[in] kernel of any rank
  /// @param[in] V space whose mesh and cells are meant
  /// @param[in] coefficients by the kernel's names, ghosts up to date
  /// @param[in] num_cells cells at a time
  /// @throws std::runtime_error if the kernel is not for this mesh or a coefficient's space
  /// @throws std::invalid_argument if a coefficient is missing or on another mesh
  CellValues(const impact_kernel& kernel, const FunctionSpace& V, const Coefficients& coefficients, int num_cells = 1);
  /// @param[in] sources of the kernel's coefficients, in their order
  /// @param[in] history internal variables on cells of the same rule, of which committed ones are read, and the
  ///   solution of the local equations of the last evaluation; null without fields among the sources
  /// @param[in] num_cells cells at a time
  /// @throws as the other one, and std::invalid_argument for a history of another size
  CellValues(const impact_kernel& kernel, const FunctionSpace& V, std::vector<Source> sources,
             std::shared_ptr<const PointHistory> history, int num_cells = 1);

  /// Sources by names: functions, then fields of the history, the direction of CellMatrix being neither.
  /// @throws std::invalid_argument if a coefficient is missing
  static std::vector<Source> sources(const impact_kernel& kernel, const Coefficients& coefficients,
                                     const PointHistory* history);

  /// Read a cell.
  /// @param[in] side of an interior facet, 0 for "+" and 1 for "-"; 0 for other kernels
  /// @param[in] lane of the cell, below num_cells
  void gather(std::int32_t cell, int side = 0, int lane = 0);
  /// Read one cell to num_cells cells; the last one is repeated in the lanes that are left over, as no lane may hold
  /// what is not a cell.
  void gather(std::span<const std::int32_t> cells);
  const double* w() const { return _w.data(); }
  std::span<const double> nodes() const { return _nodes; }

private:
  void check(int coefficient) const;

  const impact_kernel& _kernel;
  const FunctionSpace& _space;
  std::vector<Source> _sources;
  std::vector<std::size_t> _fields; ///< numbers of fields in the history, by source
  std::shared_ptr<const PointHistory> _history;
  std::vector<std::int32_t> _places; ///< of the mesh's cells in the history; -1: not there
  int _num_cells;
  AlignedVector _w, _nodes;
  std::vector<double> _history_values; ///< of a cell
};
} // namespace dolfinx_impact::operators
