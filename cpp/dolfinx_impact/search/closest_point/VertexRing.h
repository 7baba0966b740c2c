// SPDX-License-Identifier: MIT
#pragma once
#include <algorithm>
#include <cstdint>

namespace dolfinx_impact::search
{
/// The facets around a vertex (its one-ring), given by the far ends of their edges at the vertex. In a closed ring each
/// of these nodes belongs to two facets; where the surface ends at the vertex, one of them belongs to a single facet.
class VertexRing
{
public:
  static constexpr int max_nodes = 128; ///< further nodes are left out

  /// Add the far end of an edge of one facet.
  void add(std::int32_t node)
  {
    for (int i = 0; i < _num; ++i)
      if (_nodes[i] == node)
      {
        ++_counts[i];
        return;
      }
    if (_num < max_nodes)
    {
      _nodes[_num] = node;
      _counts[_num++] = 1;
    }
  }
  /// Does the surface end at the vertex?
  bool open() const { return std::find(_counts, _counts + _num, 1) != _counts + _num; }

private:
  std::int32_t _nodes[max_nodes];
  int _counts[max_nodes], _num = 0;
};
} // namespace dolfinx_impact::search
