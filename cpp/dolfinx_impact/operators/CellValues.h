// SPDX-License-Identifier: MIT
#pragma once
#include "Batches.h"

namespace dolfinx_impact::operators
{
/// What a kernel reads of one cell, or of the two cells of an interior facet, at a time: values of coefficients and
/// coordinates of nodes.
class CellValues
{
public:
  /// @param[in] kernel of any rank
  /// @param[in] V space whose mesh and cells are meant
  /// @param[in] coefficients by the kernel's names, ghosts up to date
  /// @throws std::runtime_error if the kernel is not for this mesh or a coefficient's space
  /// @throws std::invalid_argument if a coefficient is missing or on another mesh
  CellValues(const impact_kernel& kernel, const FunctionSpace& V,
             const std::map<std::string, std::shared_ptr<const Function>>& coefficients);

  /// Read a cell.
  /// @param[in] side of an interior facet, 0 for "+" and 1 for "-"; 0 for other kernels
  void gather(std::int32_t cell, int side = 0);
  const double* w() const { return _w.data(); }
  const double* nodes() const { return _nodes.data(); }

private:
  const impact_kernel& _kernel;
  const FunctionSpace& _space;
  std::vector<std::shared_ptr<const Function>> _functions; ///< in the kernel's order
  std::vector<double> _w, _nodes;
};
} // namespace dolfinx_impact::operators
