// SPDX-License-Identifier: MIT
#pragma once

namespace dolfinx_impact::enforcement
{
/// Sum of the forces on a node of the master: a whole register, whose last component is not used [F].
struct alignas(32) NodalSum
{
  double force[4] = {};
};
} // namespace dolfinx_impact::enforcement
