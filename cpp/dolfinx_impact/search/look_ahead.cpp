#include "NodeTracking.h"
#include <algorithm>

// Nodes that stay over their facets, many at a time.
namespace impact::search
{
using surface::FacetShape;

void NodeTracking::look_ahead()
{
  if (_kind == Kind::general)
    return;
  const int D = _gdim, N = _master.displacement.num_nodes();
  std::int32_t nodes[WarmBlock::size];
  _block.num = 0;
  for (std::size_t i = 0; i < size(); ++i)
  {
    const Node& node = _node[i];
    _warm[i].at.facet = -1;
    if (node.winner < 0 || (node.held >= 0 && node.winner != node.held) || !(node.travel < node.expire) || asleep(i))
      continue;
    const int l = _block.num++;
    nodes[l] = std::int32_t(i);
    const std::int32_t* facet = corners(node.winner);
    for (int j = 0; j < N; ++j)
      for (int c = 0; c < D; ++c)
        _block.X[j][c][l] = _master_x[std::size_t(facet[j]) * D + c];
    for (int c = 0; c < D; ++c)
    {
      _block.point[c][l] = node.X[c] + _last[i * D + c];
      _block.slave_normal[c][l] = node.normal[c];
    }
    // Nodes that are not held start from the middle: nothing depends on what a checkpoint does not have.
    const double middle = _kind == Kind::triangle ? 1.0 / 3 : 0.5;
    _block.xi[0][l] = node.held >= 0 ? node.xi[0] : middle;
    _block.xi[1][l] = node.held >= 0 ? node.xi[1] : _kind == Kind::interval ? 0.0 : middle;
    _block.orientation[l] = _master.orientation[node.winner];
    if (_block.num == WarmBlock::size)
      take_block(nodes);
  }
  take_block(nodes);
}

/// Asks the memory for the beginning of a node's list.
void NodeTracking::fetch(std::size_t i) const
{
#if defined(__GNUC__)
  __builtin_prefetch(_list.data() + i * most);
  __builtin_prefetch(_bound.data() + i * most);
  __builtin_prefetch(_bound.data() + i * most + 8);
#endif
}

/// Keeps the closest points that are inside their facets.
void NodeTracking::take_block(const std::int32_t* nodes)
{
  warm_closest_points(FacetShape(int(_kind)), _block);
  _counters.projections += _block.num;
  const double radius = std::max(_reach, 2 * _step);
  for (int l = 0; l < _block.num; ++l)
  {
    if (!(_block.over[l] > 0.0))
      continue;
    const Node& node = _node[nodes[l]];
    Warm& out = _warm[nodes[l]];
    out.distance = _block.distance[l];
    out.alone = node.others - node.travel - 1e-9 * _largest > out.distance && out.distance <= radius;
    if (!out.alone) // its list will be read soon
      fetch(nodes[l]);
    out.at.status = ProjectionStatus::converged;
    out.at.facet = node.winner;
    out.at.gap = out.at.clearance = _block.gap[l];
    for (int a = 0; a < 2; ++a)
      out.at.xi[a] = _block.xi[a][l];
    for (int c = 0; c < 3; ++c)
      out.at.normal[c] = _block.normal[c][l];
  }
  _block.num = 0;
}
} // namespace impact::search
