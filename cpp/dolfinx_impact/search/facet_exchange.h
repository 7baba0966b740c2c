// SPDX-License-Identifier: MIT
#pragma once
#include "../surface/Facets.h"
#include <dolfinx/common/IndexMap.h>
#include <mpi.h>
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// Facets that are sent between ranks: nodes by their global numbers, with their owners.
struct FacetPackets
{
  surface::Facets facets;           ///< without `nodes`
  std::vector<std::int64_t> nodes;  ///< global numbers, displacement.num_nodes() per facet
  std::vector<std::int32_t> owners; ///< ranks that own them
};

/// This rank's facets, ready to be sent.
/// @param[in] nodes map by which the facets number their nodes
FacetPackets pack(const dolfinx::common::IndexMap& nodes, const surface::Facets& facets);

/// Send each of this rank's facets to every rank (this one included) whose target box it overlaps. Collective.
/// @param[in] mine this rank's facets
/// @param[in] targets facets that need neighbours; their common box, widened by `reach`, is this rank's target box
/// @param[in] reach [L]
/// @returns the facets that overlap this rank's target box, sorted by id
FacetPackets send_to_overlapping(MPI_Comm comm, const FacetPackets& mine, const surface::Facets& targets, double reach);

/// Send each of this rank's facets to every rank (this one included) that owns one of its nodes. Collective.
/// @returns the facets of all ranks that have a node of this one, sorted by id
FacetPackets send_to_owners(MPI_Comm comm, const FacetPackets& mine);
} // namespace dolfinx_impact::search
