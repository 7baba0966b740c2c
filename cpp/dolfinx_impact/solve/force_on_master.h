// SPDX-License-Identifier: MIT
#pragma once
#include "../gap/rotation.h"
#include "EquilibriumProblem.h"
#include <span>

namespace dolfinx_impact::solve
{
/// Force of contacts on their rigid master [F], and its torque about a point [F L].
struct MasterForce
{
  gap::Vector3 force{}, torque{};
};

/// Force of some contacts on their rigid master and its torque, from nodal contact forces at the present positions; the
/// same on all ranks. Collective.
/// @param[in] contacts their numbers
/// @param[in] point that the torque is about [L]
MasterForce force_on_master(const EquilibriumProblem& problem, std::span<const std::size_t> contacts,
                            const gap::Vector3& point);
/// Present place of the centre about which the rigid master of a contact turns [L].
gap::Vector3 centre_of_master(const enforcement::StaticContact& contact);
} // namespace dolfinx_impact::solve
