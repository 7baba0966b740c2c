// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <petscmat.h>
#include <span>
#include <vector>

namespace dolfinx_impact::solve
{
/// How large the equations of each field of a mixed space are, and whether they hold: a volume that is left over
/// vanishes beside forces in one norm of both. The equation of a field is measured by its largest terms, |K| |u|: of a
/// constraint, div u = p / bulk, the terms balance at the solution, and no force at a support tells their size.
class FieldResiduals
{
public:
  /// @param[in] dofs owned degrees of freedom of each field
  /// @param[in] fixed mask of prescribed degrees of freedom
  FieldResiduals(MPI_Comm comm, std::vector<std::vector<std::int32_t>> dofs, std::span<const std::int8_t> fixed);

  /// Begin an increment: nothing is known of it.
  void begin();
  /// Take the size of the terms of a linearisation: the first one of an increment counts to its end, others until the
  /// next one. Collective.
  /// @param[in] K tangent
  /// @param[in] moved unknowns, from where they are measured, owned
  /// @param[in] residual with that of supports, owned
  void measure(Mat K, std::span<const double> moved, std::span<const double> residual);
  /// Whether the equations of every field hold. Collective.
  /// @param[in] residual owned
  /// @param[in] rtol relative to the largest terms of a field's equation [1]
  /// @param[in] atol of each field's equation
  bool small(std::span<const double> residual, double rtol, double atol) const;

private:
  std::vector<double> norms(std::span<const double> values, const std::vector<std::vector<std::int32_t>>& dofs) const;

  MPI_Comm _comm;
  std::vector<std::vector<std::int32_t>> _dofs, _free;
  std::vector<double> _first, _scales, _noises;
};
} // namespace dolfinx_impact::solve
