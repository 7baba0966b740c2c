// SPDX-License-Identifier: MIT
#pragma once

namespace dolfinx_impact::solve
{
/// Time spent on this rank [s].
struct SolveSeconds
{
  double bodies = 0.0;  ///< residual, stiffness
  double contact = 0.0; ///< search, integrals, assembly, active set
  double linear = 0.0;  ///< condensation, preconditioner, solution
};
} // namespace dolfinx_impact::solve
