// SPDX-License-Identifier: MIT
#pragma once
#include <mpi.h>
#include <optional>
#include <span>

namespace dolfinx_impact::gap
{
/// Gap below which points are to be closed between bodies that nearly touch: by less than a small part of a facet.
/// Collective.
/// @param[in] comm communicator of the mesh
/// @param[in] gap of the contact points, infinite without master [L]
/// @param[in] size of the points' facets [L]
/// @returns nothing if the bodies do not nearly touch [L]
std::optional<double> nearly_touching(MPI_Comm comm, std::span<const double> gap, std::span<const double> size);
} // namespace dolfinx_impact::gap
