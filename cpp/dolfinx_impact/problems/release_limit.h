// SPDX-License-Identifier: MIT
#pragma once
#include <dolfinx/fem/FunctionSpace.h>
#include <span>

namespace dolfinx_impact::problems
{
/// Energy that a residual of one's own may give, beside that of the displacement at the start: what its bodies store
/// when all their cells are strained by about `start_strain`, half the sum of k (start_strain h)^2 over nodes, h^2 the
/// mean square of the cells' sizes. Collective.
/// @param[in] V displacement space; of others nothing is known
/// @param[in] stiffness of owned degrees of freedom: mass times the square of the highest frequency, or the diagonal of
/// the stiffness matrix [F/L]
/// @returns infinite if the space is none of displacements, or bodies have no stiffness [F L]
double release_limit(const dolfinx::fem::FunctionSpace<double>& V, std::span<const double> stiffness);
} // namespace dolfinx_impact::problems
