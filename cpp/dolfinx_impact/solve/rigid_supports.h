// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/RigidBodyModes.h"
#include <cstdint>
#include <span>
#include <vector>

/// What supports do to the rigid motions of bodies.
namespace dolfinx_impact::solve
{
/// Work of the supports on the modes: products of their rows, summed over this rank, [i*num_modes + j]. Not collective.
/// @param[in] fixed mask of prescribed degrees of freedom, owned ones first
std::vector<double> products_of_supports(const operators::RigidBodyModes& motions, std::span<const std::int8_t> fixed);

/// Displacement increments of bodies that follow their supports without deformation: by body the rigid motion that is
/// nearest to the prescribed increments, and the smallest of several. Owned, [node*gdim + c] [L]. Collective.
/// @param[in] motions modes at the present displacements
/// @param[in] fixed mask of prescribed degrees of freedom, owned ones first
/// @param[in] jump increments of the prescribed owned degrees of freedom, one behind the other [L]
std::vector<double> rigid_extrapolation(const operators::RigidBodyModes& motions, std::span<const std::int8_t> fixed,
                                        std::span<const double> jump);
} // namespace dolfinx_impact::solve
