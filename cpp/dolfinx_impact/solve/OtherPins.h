// SPDX-License-Identifier: MIT
#pragma once
#include "LinearSystem.h"
#include <cstdint>
#include <petscksp.h>
#include <span>
#include <vector>

namespace dolfinx_impact::solve
{
/// A preconditioner of one system for another, in which other unknowns are pinned. Unknowns that are pinned in one of
/// them alone are left out of it, and have the diagonal of the stiffness for one of their own: the entries of pinned
/// rows have the size of a mean diagonal, which where the mesh is fine is larger than the stiffness by orders of
/// magnitude.
class OtherPins
{
public:
  /// Collective.
  /// @param[in] preconditioner that has been set up; referred to
  /// @param[in] system that it is to serve
  /// @param[in] pinned unknowns of the system that it was made of, owned
  OtherPins(PC preconditioner, const LinearSystem& system, std::span<const std::int8_t> pinned);
  ~OtherPins();
  OtherPins(const OtherPins&) = delete;
  OtherPins& operator=(const OtherPins&) = delete;

  /// It as a preconditioner of PETSc's, borrowed; valid as long as this object lives.
  PC pc() const { return _shell; }

private:
  static PetscErrorCode apply(PC pc, Vec r, Vec z);

  PC _preconditioner, _shell = nullptr;
  std::vector<PetscInt> _differ;          ///< local unknowns that are pinned in one of the systems alone
  std::vector<double> _inverse_stiffness; ///< of those [L/F]
  Vec _right = nullptr;                   ///< work
};
} // namespace dolfinx_impact::solve
