// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/node_to_surface/NodalPair.h"
#include "../integrators/RigidBody.h"
#include "FunctionsOfTime.h"
#include <memory>
#include <mpi.h>
#include <optional>
#include <span>

namespace dolfinx_impact::problems
{
/// A rigid body of a problem in time. Contacts whose masters are the same body share one object.
struct RigidBodyInTime
{
  integrators::RigidBody body;
  std::optional<FunctionOfTime> force = std::nullopt;  ///< external, at the centre, three components; nothing: none [F]
  std::optional<FunctionOfTime> torque = std::nullopt; ///< external, about the centre [F L]
};

/// Tell the springs of contacts of one rigid body how far it gives way, so that they do not shorten the stable step
/// (docs/rigid_bodies.md, "Stable step"). Collective.
/// @param[in] contacts whose master is the body
/// @throws std::invalid_argument for a contact that has no springs against an obstacle
void set_mobility(MPI_Comm comm, const integrators::RigidBody& body,
                  std::span<const enforcement::NodalPair* const> contacts);
} // namespace dolfinx_impact::problems
