// SPDX-License-Identifier: MIT
#pragma once
#include "../surface/Facets.h"
#include <vector>

namespace dolfinx_impact::search
{
/// Which master facets each slave facet may meet: pairs[offsets[f] ... offsets[f+1]-1], ascending.
struct Pairs
{
  std::vector<std::int32_t> pairs, offsets;
};

/// @param[in] slave, master at their current positions
/// @param[in] reach distance within which boxes count as near [L]
Pairs near_facets(const surface::Facets& slave, const surface::Facets& master, double reach);
} // namespace dolfinx_impact::search
