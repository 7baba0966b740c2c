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
/// them alone are left out of it. Those that are free now are relaxed before and after it, by Jacobi's method with the
/// rows and columns of the present system (the hybrid Schwarz method; Smith, Bjorstad and Gropp, Domain decomposition,
/// 1996, 1.3): without what they do to their neighbours, conjugate gradients take an eighth more iterations. A system
/// that is not symmetric has them relaxed before it alone.
class OtherPins
{
public:
  /// Collective.
  /// @param[in] preconditioner that has been set up; referred to
  /// @param[in] system that it is to serve
  /// @param[in] pinned unknowns of the system that it was made of, owned
  OtherPins(PC preconditioner, const CondensedSystem& system, std::span<const std::int8_t> pinned);
  ~OtherPins();
  OtherPins(const OtherPins&) = delete;
  OtherPins& operator=(const OtherPins&) = delete;

  /// It as a preconditioner of PETSc's, borrowed; valid as long as this object lives.
  PC pc() const { return _shell; }

private:
  static PetscErrorCode apply(PC pc, Vec r, Vec z);

  PC _preconditioner, _shell = nullptr;
  bool _symmetric;
  std::vector<PetscInt> _freed;           ///< local unknowns that are pinned in the other system alone
  std::vector<double> _relaxation;        ///< of those: inverse of the sum of their row's absolute entries [L/F]
  std::vector<PetscInt> _pinned;          ///< local unknowns that are pinned in the present system alone
  std::vector<double> _inverse_stiffness; ///< of those [L/F]
  Mat _columns = nullptr;                 ///< of the present system, one for each freed unknown; null without any
  Vec _right = nullptr;                   ///< work
  Vec _moved = nullptr, _sums = nullptr;  ///< work, an entry for each freed unknown
};
} // namespace dolfinx_impact::solve
