// SPDX-License-Identifier: MIT
#pragma once
#include "../surface/Facets.h"
#include <mpi.h>
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// Facets on their way between ranks: nodes by their global numbers, with their owners.
struct Travellers
{
  surface::Facets facets;           ///< without `nodes`
  std::vector<std::int64_t> nodes;  ///< global numbers, displacement.num_nodes() per facet
  std::vector<std::int32_t> owners; ///< ranks that own them
};

/// Send each of this rank's facets to every rank (this one included) whose target box it overlaps. Collective.
/// @param[in] mine this rank's facets
/// @param[in] targets facets that need neighbours; their common box, widened by `reach`, is this rank's target box
/// @param[in] reach [L]
/// @returns the facets that overlap this rank's target box, sorted by id
Travellers send_to_overlapping(MPI_Comm comm, const Travellers& mine, const surface::Facets& targets, double reach);

/// Send each of this rank's facets to every rank (this one included) that owns one of its nodes. Collective.
/// @returns the facets of all ranks that have a node of this one, sorted by id
Travellers send_to_owners(MPI_Comm comm, const Travellers& mine);
} // namespace dolfinx_impact::search
