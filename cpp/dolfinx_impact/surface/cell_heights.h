// SPDX-License-Identifier: MIT
#pragma once
#include "Surface.h"
#include <vector>

namespace dolfinx_impact::surface
{
/// Heights of the cells behind facets: how thick their layer is [L].
/// @param[in] V displacement space
/// @param[in] facets of this rank, made by make_surface(V, ...)
std::vector<double> cell_heights(const FunctionSpace& V, const Facets& facets);

/// Cell behind each facet, by its number on this rank.
std::vector<std::int32_t> cells_behind(const FunctionSpace& V, const Facets& facets);
} // namespace dolfinx_impact::surface
