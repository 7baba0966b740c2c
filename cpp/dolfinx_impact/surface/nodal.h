// SPDX-License-Identifier: MIT
#pragma once
#include "Facets.h"
#include <span>
#include <vector>

namespace dolfinx_impact::surface
{
/// What nodes of a surface get from its facets; sums over this rank's facets, at the numbers that facets.nodes has.
/// Areas: the facet's area by shape functions (degree 1) or in proportion to the integrals of their squares over the
/// reference facet (degree 2); docs/explicit/penalty.md.
/// @param[in] axisymmetric times 2 pi R
/// @param[in,out] areas one value per node [L^2; in the plane L]
/// @param[in] factors one per facet, which its areas are multiplied with; empty: ones
/// @throws std::invalid_argument for another number of factors
void add_nodal_areas(const Facets& facets, bool axisymmetric, std::vector<double>& areas,
                     std::span<const double> factors = {});
} // namespace dolfinx_impact::surface
