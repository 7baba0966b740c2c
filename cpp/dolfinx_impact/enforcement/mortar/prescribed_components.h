// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/MortarIntegrals.h"
#include <array>

namespace dolfinx_impact::enforcement
{
/// Prescribed displacements in one step, as the contact of a surface sees them. Arrays are over owned and ghost degrees
/// of freedom.
struct PrescribedComponents
{
  int gdim = 3;
  std::span<const std::int8_t> fixed; ///< prescribed degrees of freedom
  std::span<const double> driven;     ///< what these move in this step [L]
  double tolerance = 0.0;             ///< lengths below it are round-off of coordinates [L]
};

/// What prescribed components of some nodes have yet to move in this step, zero of others, [i*gdim + c] [L].
/// @param[in] nodes owned blocks
/// @param[in] u, start displacements now and when the step began [L]
std::vector<double> remaining_motion(const PrescribedComponents& prescribed, std::span<const std::int32_t> nodes,
                                     std::span<const double> u, std::span<const double> start);

/// Prescribed components of some nodes that move as a rigid master does, mask [i*gdim + c].
/// @param[in] motion of the master in this step [L]
std::vector<std::int8_t> locked_components(const PrescribedComponents& prescribed, std::span<const std::int32_t> nodes,
                                           const std::array<double, 3>& motion);

/// Prescribed components of the multiplier nodes along which the master is prescribed to move as the node does: at one
/// of the nodes it faces that lies on one plane with it, or at all of them. Mask [i*gdim + c]. Collective.
/// @param[in] x present positions of the owned nodes at least [L]
/// @param[in] size of the bodies [L]
std::vector<std::int8_t> locked_components(const PrescribedComponents& prescribed,
                                           const gap::MortarIntegrals& integrals, std::span<const double> x,
                                           double size);
} // namespace dolfinx_impact::enforcement
