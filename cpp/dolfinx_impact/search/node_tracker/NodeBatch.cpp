// SPDX-License-Identifier: MIT
#include "NodeBatch.h"
#include "../../common/clones.h"

namespace dolfinx_impact::search
{
namespace
{
using common::Column, common::column;

/// Positions of the nodes of facets, four facets at a time.
/// @param[in] corners corners[j]: of all facets, the position of node j among `nodes`
template <int D, int N>
IMPACT_CLONES void read_positions(BatchProjection& block, const std::int32_t (*corners)[NodeBatch::size],
                                  const MasterNode* nodes)
{
  for (int l = 0; l < block.num; l += 4)
#pragma GCC unroll 4
    for (int j = 0; j < N; ++j)
    {
      Column x[4];
      read_half(nodes, corners[j] + l, x);
#pragma GCC unroll 4
      for (int c = 0; c < D; ++c)
        column(block.X[j][c] + l) = x[c];
    }
}
} // namespace

void NodeBatch::read_corners(surface::FacetShape shape, const MasterNode* nodes)
{
  // Lanes of the last four that are not in use read the last facet.
  for (auto& corner : _corners)
    for (int l = _block.num; l % 4 != 0; ++l)
      corner[l] = corner[_block.num - 1];
  switch (shape)
  {
  case surface::FacetShape::interval:
    return read_positions<2, 2>(_block, _corners, nodes);
  case surface::FacetShape::triangle:
    return read_positions<3, 3>(_block, _corners, nodes);
  case surface::FacetShape::quadrilateral:
    return read_positions<3, 4>(_block, _corners, nodes);
  }
}
} // namespace dolfinx_impact::search
