#pragma once
#include "../common/vectors.h"
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

/// Whether d, from a surface's rim to a point, leads beside the surface. Else the point is right over or under the rim;
/// or it is less than a twentieth of the facet deep and under the rim to within 5 degrees of the normal, as the nodes
/// of a plane of symmetry are when the last facet is tilted against it. `mean` need not be of length one.
inline bool beside(int gdim, const double* d, const double* mean, double size)
{
  constexpr double tangent = 0.08748866, deepest = 0.05; // of 5 degrees; of the facet
  const double squared = dot(mean, mean, gdim), along = dot(d, mean, gdim);
  const double normal = squared > 0.0 ? along * along / squared : 0.0, round_off = 1e-9 * size;
  const double tilted = normal < deepest * deepest * size * size ? tangent * tangent * normal : 0.0;
  return dot(d, d, gdim) - normal > tilted + round_off * round_off;
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
