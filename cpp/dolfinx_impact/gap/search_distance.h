// SPDX-License-Identifier: MIT
#pragma once
#include "../surface/Surface.h"
#include <mpi.h>

namespace dolfinx_impact::gap
{
/// Search distance within which surfaces with layers can touch. Collective.
/// @param[in] slave, master this rank's facets; no master: it is rigid
/// @param[in] given search distance; 0: chosen by who searches [L]
/// @param[in] layers thickness of the layers of both sides [L]
/// @returns what is given without layers, else the layers and two facets where nothing is given [L]
/// @throws std::invalid_argument if the given distance is no larger than the layers, within which surfaces touch
double search_distance(MPI_Comm comm, const surface::Facets& slave, const surface::Facets* master, double given,
                       double layers);
} // namespace dolfinx_impact::gap
