#pragma once
#include "../surface/Facets.h"
#include <algorithm>

namespace impact::search
{
/// Position of a node among the corners of a facet, or -1.
inline int corner(const surface::Facets& facets, std::size_t f, std::int32_t node)
{
  for (int i = 0; i < facets.displacement.num_corners(); ++i)
    if (facets.nodes_of(f)[i] == node)
      return i;
  return -1;
}

/// Counts how often the far ends of the edges at a vertex occur: once where the surface ends.
struct Umbrella
{
  static constexpr int most = 128;
  std::int32_t nodes[most];
  int counts[most], num = 0;

  void add(std::int32_t node)
  {
    for (int i = 0; i < num; ++i)
      if (nodes[i] == node)
      {
        ++counts[i];
        return;
      }
    if (num < most)
    {
      nodes[num] = node;
      counts[num++] = 1;
    }
  }
  bool open() const { return std::find(counts, counts + num, 1) != counts + num; }
};
} // namespace impact::search
