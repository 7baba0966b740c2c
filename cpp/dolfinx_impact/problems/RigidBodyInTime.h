// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/node_to_surface/NodalPair.h"
#include "../integrators/RigidContact.h"
#include "FunctionsOfTime.h"
#include <memory>
#include <mpi.h>
#include <optional>
#include <span>
#include <vector>

namespace dolfinx_impact::problems
{
/// A rigid body of a problem in time. Contacts whose masters are the same body share one object.
struct RigidBodyInTime
{
  struct Meeting
  {
    std::shared_ptr<integrators::RigidContact> contact;
    std::shared_ptr<RigidBodyInTime> master; ///< null: an obstacle
  };

  integrators::RigidBody body;
  std::optional<FunctionOfTime> force = std::nullopt;  ///< external, at the centre, three components; nothing: none [F]
  std::optional<FunctionOfTime> torque = std::nullopt; ///< external, about the centre [F L]
  std::vector<Meeting> meetings{};                     ///< with other rigid bodies and obstacles, as the slave
};

/// Let a rigid body meet another one, or an obstacle.
/// @throws std::invalid_argument as the constructor of RigidContact
void meet(RigidBodyInTime& slave, integrators::RigidContactOptions options, std::shared_ptr<RigidBodyInTime> master);

/// Tell the springs of contacts of one rigid body how far it gives way, so that they do not shorten the stable step
/// (docs/rigid_bodies.md, "Stable step"). Collective.
/// @param[in] contacts whose master is the body
/// @param[in] meets it meets other rigid bodies or obstacles as well
/// @throws std::invalid_argument for a contact that has no springs against an obstacle
void set_mobility(MPI_Comm comm, const integrators::RigidBody& body,
                  std::span<const enforcement::NodalPair* const> contacts, bool meets = false);
} // namespace dolfinx_impact::problems
