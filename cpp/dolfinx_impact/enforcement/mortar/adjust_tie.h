// SPDX-License-Identifier: MIT
#pragma once
#include "TieConditions.h"
#include <dolfinx/mesh/Mesh.h>

namespace dolfinx_impact::enforcement
{
/// Move the slave's nodes of a mesh by what the surfaces of a tie are apart, so that rigid rotations give no force
/// under these conditions, which are those of the surfaces before; docs/tie.md. Collective.
/// @param[in,out] mesh of the conditions' space
/// @returns the largest motion of a node, of all ranks [L]
/// @throws std::invalid_argument if the nodes of displacements are not those of the geometry
double adjust_tie(dolfinx::mesh::Mesh<double>& mesh, const TieConditions& conditions);
} // namespace dolfinx_impact::enforcement
