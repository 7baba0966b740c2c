// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/PointHistory.h"
#include "../state/State.h"
#include <memory>
#include <vector>

namespace dolfinx_impact::problems
{
typedef std::vector<std::shared_ptr<operators::PointHistory>> Histories;

/// Internal variables of materials, values of their own, as the part "material": rows by owned cell,
/// (num_points * num_components), the largest numbers of all materials; zeros where a material has less, or no such
/// variable.
/// @param[in] histories the same on all ranks, though some may have no cells
/// @param[in] num_cells number of cells that this rank owns
state::State material_state(const Histories& histories, std::size_t num_cells);

/// Set internal variables to those of `material_state`.
/// @throws std::out_of_range if one is not there
/// @throws std::invalid_argument for values that are not finite, or another number of points
void set_material(const Histories& histories, const state::State& saved);
} // namespace dolfinx_impact::problems
