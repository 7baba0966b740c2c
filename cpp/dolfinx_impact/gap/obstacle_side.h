// SPDX-License-Identifier: MIT
#pragma once
#include "../surface/Surface.h"
#include "Rigid.h"
#include <string>

namespace dolfinx_impact::gap
{
/// Refuse a rigid obstacle whose surface does not face the slave: where the slave is nearest to it, outward normals
/// must be opposite. Normals are compared at the slave's nodes that are at most one facet farther away than the nearest
/// one. A slave whose nodes are all farther outside than one facet is accepted. Collective.
/// @param[in] name of the pair, for the error
/// @param[in] slave this rank's facets in the reference configuration, whose nodes are those of V
/// @throws std::invalid_argument on all ranks
void check_side(const std::string& name, const surface::FunctionSpace& V, const surface::Facets& slave,
                const Rigid& obstacle);
} // namespace dolfinx_impact::gap
