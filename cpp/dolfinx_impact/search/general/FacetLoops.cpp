// SPDX-License-Identifier: MIT
#include "FacetLoops.h"
#include <algorithm>
#include <array>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace dolfinx_impact::search
{
FacetLoops::FacetLoops(const surface::Facets& facets, std::size_t num_nodes)
    : _num_corners(facets.displacement.num_corners()), _id(facets.id)
{
  if (facets.displacement.degree != 1 || facets.geometry.degree != 1)
    throw std::invalid_argument("loops of corners are those of straight facets, of degree 1");
  // The nodes of a quadrilateral are those of a product.
  static constexpr std::array<int, 4> around{0, 1, 3, 2}, in_order{0, 1, 2, 3};
  const auto& order = _num_corners == 4 ? around : in_order;
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    for (int k = 0; k < _num_corners; ++k)
      _corners.push_back(facets.nodes_of(f)[order[k]]);
    if (facets.orientation[f] < 0)
      std::reverse(_corners.end() - _num_corners, _corners.end());
  }
  _starts.assign(num_nodes + 1, 0);
  for (const std::int32_t node : _corners)
    ++_starts[node + 1];
  std::partial_sum(_starts.begin(), _starts.end(), _starts.begin());
  _at_node.resize(_corners.size());
  std::vector<std::int32_t> next(_starts.begin(), _starts.end() - 1);
  for (std::size_t k = 0; k < _corners.size(); ++k)
    _at_node[next[_corners[k]]++] = std::int32_t(k / _num_corners);
  _neighbours.assign(_corners.size(), -1);
  if (_num_corners == 2)
    find_neighbours_in_plane();
  else
    find_edges();
}

void FacetLoops::find_neighbours_in_plane()
{
  for (std::size_t f = 0; f < size(); ++f)
    for (int k = 0; k < 2; ++k)
      if (const auto at = at_node(corners(f)[k]); at.size() == 2)
        _neighbours[2 * f + k] = at[0] == std::int32_t(f) ? at[1] : at[0];
}

void FacetLoops::find_edges()
{
  struct Side
  {
    std::pair<std::int32_t, std::int32_t> nodes; ///< the smaller number first
    std::int32_t facet;
    int side;
  };
  std::vector<Side> sides;
  for (std::size_t f = 0; f < size(); ++f)
    for (int k = 0; k < _num_corners; ++k)
    {
      const std::int32_t a = corners(f)[k], b = corners(f)[(k + 1) % _num_corners];
      sides.push_back({std::minmax(a, b), std::int32_t(f), k});
    }
  std::ranges::sort(sides, [](const Side& a, const Side& b)
                    { return std::pair(a.nodes, a.facet) < std::pair(b.nodes, b.facet); });
  for (std::size_t first = 0, last; first < sides.size(); first = last)
  {
    for (last = first + 1; last < sides.size() && sides[last].nodes == sides[first].nodes;)
      ++last;
    if (last - first != 2)
      continue;
    Side a = sides[first], b = sides[first + 1];
    if (_id[b.facet] < _id[a.facet])
      std::swap(a, b);
    const std::int32_t from = corners(a.facet)[a.side], to = corners(a.facet)[(a.side + 1) % _num_corners];
    _neighbours[a.facet * _num_corners + a.side] = b.facet;
    _neighbours[b.facet * _num_corners + b.side] = a.facet;
    _edges.push_back({{from, to}, {a.facet, b.facet}, {a.side, b.side}, 4 * _id[a.facet] + a.side});
  }
}

int FacetLoops::corner_of(std::size_t f, std::int32_t node) const
{
  for (int k = 0; k < _num_corners; ++k)
    if (corners(f)[k] == node)
      return k;
  return -1;
}
} // namespace dolfinx_impact::search
