// SPDX-License-Identifier: MIT
#pragma once
#include "lump.h"
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace dolfinx_impact::operators
{
/// Extreme eigenvalues of M_e^-1 A_e of every cell or facet, A_e the symmetric part of its matrix, M_e the cell's part
/// of a lumped mass. At a facet between two cells, M_e has the masses of both, added up where they share a degree of
/// freedom.
/// @param[in] matrix kernel over cells or facets that CellMatrix takes, with its entities and constants
/// @param[in] V displacement space
/// @param[in] coefficients by the kernel's names, ghosts up to date
/// @param[in] masses lumped, by entity and local degree of freedom of its cell, or of its two cells [M]
/// @returns [3*e]: the smallest eigenvalue of entity e, the largest, and the Frobenius norm of the skew-symmetric part,
///   scaled by the mass as well
/// @throws std::runtime_error if the kernel is not for this mesh or space, or a matrix is not a number
std::vector<double> cell_spectra(const Integral& matrix, const FunctionSpace& V,
                                 const std::map<std::string, std::shared_ptr<const Function>>& coefficients,
                                 std::span<const double> masses);
} // namespace dolfinx_impact::operators
