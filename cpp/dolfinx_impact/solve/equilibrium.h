// SPDX-License-Identifier: MIT
#pragma once
#include "EquilibriumProblem.h"
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::solve
{
/// What is missing to equilibrium.
struct Imbalance
{
  double norm = 0.0; ///< of the missing forces [F]
  std::string text;  ///< a sentence with the pairs and the node where most is missing
};

/// What is missing to equilibrium of the free nodes in a state that has converged; nothing if nothing is. Collective.
///
/// Newton's method with multipliers takes their forces from the residual of the slave's nodes, where equilibrium holds
/// by construction. Here the forces that all contacts report are summed up, on slaves and masters, and subtracted from
/// the residual of the bodies; what is left at nodes that are free must be within the tolerance.
/// @param[in] bodies residual of the bodies without contact, owned [F]
/// @param[in] tolerance of the norm of the free residual, without round-off of contact forces [F]
std::optional<Imbalance> out_of_balance(const EquilibriumProblem& problem, std::span<const double> bodies,
                                        double tolerance);

/// Contacts that were closed and are open now, by more than round-off: the name of each pair and its smallest gap.
/// Collective.
/// @param[in] closed whether each contact was closed before
std::vector<std::string> open_contacts(const EquilibriumProblem& problem, std::span<const std::int8_t> closed);
} // namespace dolfinx_impact::solve
