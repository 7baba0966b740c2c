// SPDX-License-Identifier: MIT
#pragma once
#include "FacetFrame.h"
#include "Facets.h"

/// Smooth facets (smooth.h) that turn by any angle: the offsets of their geometry nodes from the flat facet between
/// the corners keep their components in the axes that turn with it.
namespace dolfinx_impact::surface
{
/// Frame of a facet in space of this dimension when its corners are at these places; for 2 and 3.
/// @param[in] corners positions of its corners, corners[j*gdim + c] [L]
template <int gdim>
FacetFrame<gdim> frame_of(const Facets& facets, const double* corners);

/// Components of the offsets in the reference configuration.
/// @returns [(facet*geometry.num_nodes() + i)*gdim + k], zero for corners; empty unless the facets are smooth
std::vector<double> offset_components(const Facets& facets);

/// `move` for facets that may turn by any angle; the same as `move` unless the facets are smooth.
/// @param[in,out] facets
/// @param[in] components offset_components(facets)
/// @param[in] u nodal displacements, u[node*gdim + c], numbered as facets.nodes [L]
void move_and_turn(Facets& facets, const std::vector<double>& components, const double* u);
} // namespace dolfinx_impact::surface
