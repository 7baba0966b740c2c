// SPDX-License-Identifier: MIT
#pragma once
#include "MortarContact.h"

/// Nodes that several contacts by multipliers have in common: joined, kept apart, or refused; docs/contact.md.
namespace dolfinx_impact::enforcement
{
/// Find the nodes that contacts have in common, and join them where one constraint is meant. Collective. The contacts
/// refer to each other from then on: all of them live as long as one is used.
/// @param[in] contacts all contacts by multipliers of a problem
/// @returns whether nodes are left with constraints of several contacts, so that multipliers cannot be condensed
/// @throws std::invalid_argument on all ranks, if two pairs have the same facets twice, or each has the other's slave
/// for its master, or share slave nodes where they may not
bool connect(std::span<MortarContact* const> contacts);
} // namespace dolfinx_impact::enforcement
