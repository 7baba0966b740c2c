// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <dolfinx/fem/FunctionSpace.h>
#include <vector>

namespace dolfinx_impact::operators
{
/// Ghosts that cells of this rank read, nonzero for each of them, in the order of the space's index map. The others
/// belong to ghost cells only, which kernels over cells leave to their owners.
/// @param[in] V space
std::vector<std::int8_t> cell_ghosts(const dolfinx::fem::FunctionSpace<double>& V);
} // namespace dolfinx_impact::operators
