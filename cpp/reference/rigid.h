// SPDX-License-Identifier: MIT
#pragma once
#include "Model.h"

namespace impact_reference
{
/// Rigid motions of nodes: columns; translations x, y (, z), then rotations about the axes (z in the plane) through
/// `centre`. Axisymmetric: the translation along z alone.
Matrix rigid_motions(const Matrix& points, const Vector& centre, bool axisymmetric);

/// One sentence that names every rigid motion the fixed degrees of freedom leave free, body by body (bodies are cells
/// connected by nodes); empty if there is none.
std::string free_rigid_motions(const Model& model, const std::vector<bool>& fixed);
} // namespace impact_reference
