// SPDX-License-Identifier: MIT
#pragma once
#include "segments.h"
#include <cstdint>
#include <dolfinx/common/IndexMap.h>
#include <memory>

namespace dolfinx_impact::gap
{
/// Stands for the cosine of a facet that is over no master.
inline constexpr double no_master = -2.0;

/// How slave facets face the master they are over: by facet the mean of -nu_s . nu_m over the segments, no_master
/// without any. 1: opposite, 0: at a right angle.
std::vector<double> facing(const surface::Facets& slave, const surface::Facets& master, const Segments& segments);

/// Which facets count at which of their nodes: [facet*num_nodes + i]. Where a facet at the node faces the master, those
/// that lie round a sharp edge from it and face nothing do not count (docs/contact.md, "Sharp edges"). Collective.
/// @param[in] map of the facets' nodes
/// @param[in] cosines of `facing`
std::vector<std::int8_t> counting(const std::shared_ptr<const dolfinx::common::IndexMap>& map,
                                  const surface::Facets& slave, std::span<const double> cosines);
} // namespace dolfinx_impact::gap
