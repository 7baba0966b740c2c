// SPDX-License-Identifier: MIT
#pragma once
#include "PointHistory.h"
#include <memory>

namespace dolfinx_impact::operators
{
typedef std::vector<std::shared_ptr<PointHistory>> Histories;

/// Internal variables of bodies as a checkpoint holds them, values of their own: a row of all points of a cell for each
/// owned cell, by name. Materials with fewer points or components have the first ones of a row, cells without the
/// variable zeros.
/// @param[in] histories of the integrals, each on owned cells
/// @param[in] num_cells owned cells of the mesh
/// @returns state "material", without fields if there are no histories
state::State saved_history(const Histories& histories, std::size_t num_cells);

/// Set internal variables to what `saved_history` has returned.
/// @throws std::out_of_range for a variable that is missing
/// @throws std::invalid_argument for rows of another length
void resume_history(const Histories& histories, const state::State& saved);
} // namespace dolfinx_impact::operators
