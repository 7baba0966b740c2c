// SPDX-License-Identifier: MIT
#pragma once
#include "../../search/general/FacetLoops.h"
#include "../../search/general/crossed_edges.h"

namespace dolfinx_impact::enforcement::general
{
/// An edge of a surface at some positions, [node*3 + c], less some increments if there are any.
inline search::loop::EdgeAtPresent edge_at(const search::SurfaceEdge& edge, const search::FacetLoops& loops,
                                           const double* x, const double* minus)
{
  search::loop::EdgeAtPresent out;
  const auto position = [&](std::int32_t node, double* to)
  {
    for (int c = 0; c < 3; ++c)
      to[c] = x[std::size_t(node) * 3 + c] - (minus ? minus[std::size_t(node) * 3 + c] : 0.0);
  };
  for (int k = 0; k < 2; ++k)
  {
    position(edge.nodes[k], out.ends[k]);
    double corners[4][3];
    for (int j = 0; j < loops.num_corners(); ++j)
      position(loops.corners(edge.facets[k])[j], corners[j]);
    search::loop::side_normal(corners, loops.num_corners(), edge.sides[k], out.normals[k]);
  }
  return out;
}
} // namespace dolfinx_impact::enforcement::general
