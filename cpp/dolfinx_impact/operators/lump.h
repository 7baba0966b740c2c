// SPDX-License-Identifier: MIT
#pragma once
#include "Batches.h"
#include <map>
#include <memory>
#include <string>

namespace dolfinx_impact::operators
{
/// Lumped mass of each cell by Hinton, Rock and Zienkiewicz (1976): the diagonal of its consistent mass matrix, scaled
/// so that the cell's mass is kept in every direction. Positive on every cell, for simplices of degree 2 as well.
/// @param[in] mass kernel of rank 2 (form "mass") with its cells and constants
/// @param[in] V displacement space
/// @returns masses[cell*n + i] of the n local degrees of freedom, in the order of the integral's cells [M]
/// @throws std::runtime_error if the kernel is not for this mesh or space, or a cell has no mass
std::vector<double> cell_masses_hrz(const Integral& mass, const FunctionSpace& V,
                                    const Coefficients& coefficients = {});

/// Lumped mass of each cell by quadrature at the nodes (Gauss-Lobatto-Legendre), scaled to the exact mass where the
/// rule does not integrate the Jacobian of a distorted cell exactly.
/// @param[in] nodal kernel of rank 1 (form "nodal_mass") with its cells and constants
/// @param[in] row_sum kernel of rank 1 (form "row_sum") on the same cells, integrated exactly
/// @param[in] V displacement space
/// @returns as cell_masses_hrz [M]
/// @throws std::runtime_error as cell_masses_hrz
std::vector<double> cell_masses_nodal(const Integral& nodal, const Integral& row_sum, const FunctionSpace& V,
                                      const Coefficients& coefficients = {});
} // namespace dolfinx_impact::operators
