// SPDX-License-Identifier: MIT
#pragma once
#include "MortarContact.h"

/// Nodes that other contacts constrain along another normal (MortarContact::edges): they lie on the edge between two
/// surfaces; docs/contact.md.
namespace dolfinx_impact::enforcement
{
/// Projectors on the directions along the surface that other contacts of the same nodes hold at present,
/// [(i*gdim + a)*gdim + b]; empty without any.
std::vector<double> held_by_others(const MortarContact& contact);

/// At nodes with two normals in space let one tangent lie along the edge between them: what sticks or slips there is
/// told apart from what the other normal holds.
void align_frames(const MortarContact& contact, NodalFrames& frames);
} // namespace dolfinx_impact::enforcement
