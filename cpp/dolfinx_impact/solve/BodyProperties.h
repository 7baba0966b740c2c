// SPDX-License-Identifier: MIT
#pragma once

namespace dolfinx_impact::solve
{
/// What is known of bodies beforehand.
struct BodyProperties
{
  bool linear = false;           ///< the tangent does not change with the displacement: one serves an increment
  bool keeps_tangent = false;    ///< it does not change with time either: one serves all steps
  bool symmetric = true;         ///< the tangent is symmetric
  bool inelastic = false;        ///< there are internal variables: tangents of two iterations may be far apart
  bool has_inertia = false;      ///< inertia holds the bodies against rigid motions
  bool has_springs = false;      ///< springs to the ground may hold the bodies
  bool rounds_positions = false; ///< round-off of positions enters the forces, as with finite strain
};
} // namespace dolfinx_impact::solve
