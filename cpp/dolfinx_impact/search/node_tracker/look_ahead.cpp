// SPDX-License-Identifier: MIT
#include "NodeTracking.h"
#include "../closest_point/linear_facet.h"
#include <algorithm>
#include <cmath>

// Nodes that stay over their facets, many at a time.
namespace dolfinx_impact::search
{
using surface::FacetShape;

void NodeTracking::look_ahead(std::size_t first, const double* u)
{
  _ahead = first;
  _ahead_end = std::min(first + BatchProjection::size, size());
  for (std::size_t i = _ahead; i < _ahead_end; ++i)
    warm(i).at.facet = -1;
  switch (_kind)
  {
  case Kind::interval:
    return project_ahead<FacetShape::interval>(u);
  case Kind::triangle:
    return project_ahead<FacetShape::triangle>(u);
  case Kind::quadrilateral:
    return project_ahead<FacetShape::quadrilateral>(u);
  case Kind::general:
    break;
  }
}

template <FacetShape S>
void NodeTracking::project_ahead(const double* u)
{
  constexpr int D = linear::dimension<S>, N = linear::num_nodes<S>;
  // Nodes that are not held start from the middle: nothing depends on what a checkpoint does not have.
  constexpr double half = S == FacetShape::triangle ? 1.0 / 3 : 0.5;
  constexpr double middle[2] = {half, S == FacetShape::interval ? 0.0 : half};
  // Facets first, then all that they ask of the memory at once.
  std::int32_t nodes[BatchProjection::size], facets[BatchProjection::size][N];
  int num = 0;
  for (std::size_t i = _ahead; i < _ahead_end; ++i)
  {
    const Node& node = _node[i];
    if (node.winner < 0 || (node.held >= 0 && node.winner != node.held) || !(_travelled[i].now < node.expire) ||
        asleep(i))
      continue;
    double space[3];
    if (!std::isfinite(node.bent)) // evaluated and kept
      present_normal(i, u, space);
    std::copy_n(_corners.data() + std::size_t(node.winner) * N, N, facets[num]);
    nodes[num++] = std::int32_t(i);
  }
  for (int l = 0; l < num; ++l)
  {
    const Node& node = _node[nodes[l]];
    for (int j = 0; j < N; ++j)
      for (int c = 0; c < D; ++c)
        _block.X[j][c][l] = _masters[facets[l][j]].x[c];
    for (int c = 0; c < D; ++c)
    {
      _block.point[c][l] = node.x[c];
      _block.slave_normal[c][l] = node.normal[c];
    }
    const double change = turned(nodes[l]);
    _block.rotation[l] = change <= Turning::most ? change : 2.0; // more than any scalar product
    for (int a = 0; a < 2; ++a)
      _block.xi[a][l] = node.held >= 0 ? node.xi[a] : middle[a];
    _block.orientation[l] = _master.orientation[node.winner];
  }
  _block.num = num;
  project_batch(S, _block);
  take_block(nodes);
}

/// Asks the memory for a node's list.
void NodeTracking::fetch(std::size_t i) const
{
#if defined(__GNUC__)
  constexpr int line = 64 / sizeof(Entry);
  for (int k = 0; k < _node[i].count; k += line)
    __builtin_prefetch(_lists[i].entries + k);
#endif
}

/// Keeps the closest points that are inside their facets.
void NodeTracking::take_block(const std::int32_t* nodes)
{
  _counters.projections += _block.num;
  for (int l = 0; l < _block.num; ++l)
  {
    if (!(_block.over[l] > 0.0))
    {
      fetch(nodes[l]);
      continue;
    }
    const Node& node = _node[nodes[l]];
    Warm& out = warm(nodes[l]);
    out.distance = _block.distance[l];
    out.alone = node.others - _travelled[nodes[l]].now - 1e-9 * _largest > out.distance && out.distance <= _reach;
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
}
} // namespace dolfinx_impact::search
