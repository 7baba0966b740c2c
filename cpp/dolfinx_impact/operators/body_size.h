// SPDX-License-Identifier: MIT
#pragma once
#include <dolfinx/mesh/Mesh.h>

namespace dolfinx_impact::operators
{
/// Diagonal of the bounding box of the whole mesh, the length scale of tolerances of gaps [L]. Collective.
double body_size(const dolfinx::mesh::Mesh<double>& mesh);
} // namespace dolfinx_impact::operators
