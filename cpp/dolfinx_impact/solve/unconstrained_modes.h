// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/StaticContact.h"
#include <dolfinx/fem/FunctionSpace.h>
#include <petscmat.h>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::solve
{
/// Rigid body modes that supports and active contacts do not constrain: combinations of the modes of all bodies, of
/// length one. Collective.
/// @param[in] motions modes at the present displacements
/// @param[in] stiffness tangent of the bodies, where it may resist rigid body modes; null: it does not [F/L]
std::vector<std::vector<double>> free_modes(const operators::RigidBodyModes& motions,
                                            const dolfinx::fem::FunctionSpace<double>& V,
                                            std::span<const std::int8_t> fixed,
                                            std::span<enforcement::StaticContact* const> contacts, bool axisymmetric,
                                            Mat stiffness = nullptr);

/// Sentences about the rigid body modes that supports and active contacts do not constrain, one per body; the same on
/// all ranks and on any number of ranks. If modes are unconstrained and bodies nearly touch, `close_nearest` of the
/// contacts activates their nearest points, and the modes are found again. Collective.
/// @param[in] V displacement space
/// @param[in] fixed mask of prescribed degrees of freedom, owned and ghosts
/// @param[in] u present displacements, owned and ghosts [L]
/// @param[in] axisymmetric x is the radius
/// @param[in] stiffness tangent of the bodies, where it may resist rigid body modes (springs in a residual); null: it
/// does not [F/L]
std::vector<std::string> unconstrained_modes(const dolfinx::fem::FunctionSpace<double>& V,
                                             std::span<const std::int8_t> fixed,
                                             std::span<enforcement::StaticContact* const> contacts,
                                             std::span<const double> u, bool axisymmetric = false,
                                             Mat stiffness = nullptr);
} // namespace dolfinx_impact::solve
