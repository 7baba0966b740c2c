// SPDX-License-Identifier: MIT
#pragma once
#include "NodePenalty.h"
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Sum over the cells at a node of its mass in the cell times the square of the cell's highest frequency, in the
/// undeformed bodies, given a mask of the nodes that are asked for; both by node, owned and ghosts. Collective [F/L].
typedef std::function<std::vector<double>(std::span<const std::int8_t>)> FrequencyStiffness;

/// Reciprocals of the stiffness that the undeformed bodies offer to springs at the nodes of the surfaces of a contact:
/// half of a layer of cells, within what the masses bear; docs/explicit/penalty.md, "Stiffness". Collective.
/// @param[in] V displacement space
/// @param[in] contact whose surfaces are meant
/// @param[in] moduli of uniaxial strain of owned cells; nothing: not known, then the masses count alone [F/L^2]
/// @param[in] frequency_stiffness of the bodies
/// @returns zero at nodes of other places, and where the bodies have no stiffness
NodalCompliances nodal_compliances(const surface::FunctionSpace& V, const NodeToSurface& contact,
                                   std::optional<std::span<const double>> moduli,
                                   const FrequencyStiffness& frequency_stiffness);

/// The same of one surface that meets itself or others of its kind. Collective.
/// @param[in] axisymmetric whether areas are those of bodies of revolution
/// @returns by node that this rank owns; zero at nodes of other places, and where the bodies have no stiffness [L/F]
std::vector<double> nodal_compliances(const surface::FunctionSpace& V, const surface::Facets& facets,
                                      std::optional<std::span<const double>> moduli,
                                      const FrequencyStiffness& frequency_stiffness, bool axisymmetric = false);
} // namespace dolfinx_impact::enforcement
