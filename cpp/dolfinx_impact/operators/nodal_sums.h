// SPDX-License-Identifier: MIT
#pragma once
#include <dolfinx/common/IndexMap.h>
#include <memory>
#include <vector>

namespace dolfinx_impact::operators
{
/// Contributions of all ranks to nodal values, added; complete on ghosts. Collective.
/// @param[in] values owned and ghosts, [node*block + c]
std::vector<double> sum_over_ranks(const std::shared_ptr<const dolfinx::common::IndexMap>& map,
                                   std::vector<double> values, int block);

/// Nodal values whose ghosts have those of their owners. Collective.
/// @param[in] values owned and ghosts, [node*block + c]; those of ghosts do not count
std::vector<double> from_owners(const std::shared_ptr<const dolfinx::common::IndexMap>& map, std::vector<double> values,
                                int block);
} // namespace dolfinx_impact::operators
