// SPDX-License-Identifier: MIT
#pragma once
#include "../surface/Facets.h"
#include <vector>

namespace dolfinx_impact::search
{
/// Boxes around facets at their current positions. A curved facet may reach beyond its nodes: its box is that of the
/// control points of the same polynomial in Bernstein form, whose hull contains it.
/// @param[out] boxes 2*gdim numbers per facet, lower corner first
void bounding_boxes(const surface::Facets& facets, std::vector<double>& boxes);

/// The Bernstein control points of one facet.
/// @param[in] x positions of its nodes, x[i*gdim + c] [L]
/// @param[out] control as many points, in the order of the nodes
void control_points(const surface::FacetElement& element, int gdim, const double* x, double* control);
} // namespace dolfinx_impact::search
