// SPDX-License-Identifier: MIT
#pragma once
#include "MortarGeometry.h"
#include "active_set.h"
#include <string>

/// What a contact by multipliers tells about its nodes, in words. Collective.
namespace dolfinx_impact::enforcement
{
/// Slave nodes whose displacement along the normal is prescribed and that lie in the master, deeper than any point did
/// before anything was loaded: there is nothing that a multiplier could move. Empty without any.
/// @param[in] name of the pair
/// @param[in] prescribed mask of nodes that are prescribed along the normal
/// @param[in] depth of the initial penetration [L]
std::string describe_overlap(const std::string& name, const MortarGeometry& geometry,
                             std::span<const std::int8_t> prescribed, double depth);

/// The node whose gap or slip is largest.
std::string describe_violation(const std::string& name, const MortarGeometry& geometry, const Violations& violations);

/// A sharp edge of the slave with both sides at the master; empty without any.
std::string describe_sharp_edge(const std::string& name, const MortarGeometry& geometry);
} // namespace dolfinx_impact::enforcement
