// SPDX-License-Identifier: MIT
#pragma once
#include "Csr.h"

namespace impact_reference
{
/// Order in which to eliminate nodes: nested dissection by coordinates. A set of nodes is cut at the median of its
/// longest extent; the nodes right of the cut that touch the left side separate the halves and come last (George 1973;
/// Davis, Direct Methods for Sparse Linear Systems, ch. 7.6). In space it fills far less than a minimum degree order.
std::vector<std::int64_t> dissection(const Field& field, const Pattern& pattern);

/// Number of every degree of freedom in a reduced system whose unknowns follow `order` (nodes), -1 where fixed.
/// @throws std::invalid_argument for a fixed degree of freedom out of range
std::vector<std::int64_t> free_numbers(const std::vector<std::int64_t>& order, int block,
                                       const std::vector<std::int64_t>& fixed_dofs);
} // namespace impact_reference
