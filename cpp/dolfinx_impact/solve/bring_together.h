// SPDX-License-Identifier: MIT
#pragma once
#include "EquilibriumProblem.h"
#include <string>

namespace dolfinx_impact::solve
{
/// What has become of bodies that only contact can hold.
struct Approach
{
  std::string moved;    ///< which bodies moved, how far, and what they touch, in words; empty: nothing was moved
  std::string obstacle; ///< why nothing was moved though bodies are free and apart, in words; may be empty
};

/// Bring bodies that are apart together, where the loads leave one way only: bodies that supports do not hold move as
/// rigid bodies, without turning, along the loads at their present values and along what they touch already, until
/// contacts bear the loads. Contacts hold on one side only: a body may leave one and go to another.
///
/// With generalised forces f of the loads on the free rigid motions q, and rows a_i of the gaps that are closed, the
/// direction is the projection of f on the cone a_i . q >= 0, a non-negative least-squares problem (Moreau's
/// decomposition). It is zero where contacts bear the loads. The motion is unique where closed contacts leave each body
/// one direction, a translation, and where they leave none at its end; otherwise nothing is changed.
///
/// Contacts are as they were afterwards, displacements are those of bodies that touch. Collective.
/// @param[in] problem whose displacement is changed
Approach bring_together(const EquilibriumProblem& problem);
} // namespace dolfinx_impact::solve
