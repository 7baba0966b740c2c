// SPDX-License-Identifier: MIT
#pragma once
#include "../../common/columns.h"
#include <cstddef>
#include <cstdint>

namespace dolfinx_impact::search
{
/// A node of the master: what a step needs of it lies in one line of the cache.
struct alignas(64) MasterNode
{
  double x[3] = {};             ///< position at the last `advance` [L]
  double du[3] = {};            ///< increment of the last step [L]
  double compliance = 0.0;      ///< of penalty springs at this node; set by the contact [L/F]
  double area_compliance = 0.0; ///< the same times the nodal area; set by the contact [L^3/F, in the plane L^2/F]
};

/// Data of four nodes of the master, one in each lane.
struct MasterColumns
{
  common::Column x[3], du[3], compliance, area_compliance;
};

/// The first half of the data of four nodes: positions and the first component of the increments.
/// @param[in] at positions of the nodes among `nodes`
IMPACT_INLINED void read_half(const MasterNode* nodes, const std::int32_t* at, common::Column (&out)[4], int first = 0)
{
  static_assert(offsetof(MasterNode, du) == 24 && offsetof(MasterNode, compliance) == 48 && sizeof(MasterNode) == 64);
#pragma GCC unroll 4
  for (int l = 0; l < 4; ++l)
    out[l] = common::column(reinterpret_cast<const double*>(nodes + at[l]) + first);
  common::transpose(out);
}

/// @param[in] at positions of the four nodes among `nodes`
IMPACT_INLINED void read(const MasterNode* nodes, const std::int32_t* at, MasterColumns& out)
{
  common::Column low[4], high[4];
  read_half(nodes, at, low);
  read_half(nodes, at, high, 4);
  out = {{low[0], low[1], low[2]}, {low[3], high[0], high[1]}, high[2], high[3]};
}
} // namespace dolfinx_impact::search
