// SPDX-License-Identifier: MIT
#pragma once
#include "ExplicitTie.h"
#include "MortarContact.h"
#include "Tie.h"

/// Nodes that ties share with each other and with contacts; docs/tie.md.
namespace dolfinx_impact::enforcement
{
/// Leave out of each tie the components that an earlier one holds, and find out whether nodes have conditions of
/// several ties or contacts. Collective.
/// @param[in] ties, contacts all ties and contacts by multipliers of a problem, in its order
/// @returns whether a tied node belongs to another tie or contact, so that multipliers cannot be condensed
/// @throws std::invalid_argument on all ranks, if each of two ties has the other's slave for its master
bool connect(std::span<Tie* const> ties, std::span<MortarContact* const> contacts);
/// The same for the ties of an explicit problem, whose forces are solved for together.
void connect(std::span<ExplicitTie* const> ties);
} // namespace dolfinx_impact::enforcement
