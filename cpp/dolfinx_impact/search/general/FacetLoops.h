// SPDX-License-Identifier: MIT
#pragma once
#include "../../surface/Facets.h"
#include <cstdint>
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// An edge between two facets in space.
struct SurfaceEdge
{
  std::int32_t nodes[2]; ///< in the direction in which the loop of facets[0] has them
  std::int32_t facets[2];
  int sides[2];    ///< of the loops of the facets
  std::int64_t id; ///< 4 * id of the facet with the smaller id + side; it depends neither on the ranks nor their number
};

/// Corners of straight facets, in an order from which the outward normal follows, and what lies beside them.
///
/// In the plane a facet is the segment between two corners, from the first to the second one with the body on the left.
/// In space the corners run counter-clockwise when they are seen from outside; side k is between corner k and the next.
class FacetLoops
{
public:
  FacetLoops() = default;
  /// @param[in] facets of degree 1, whose nodes are below num_nodes
  /// @param[in] num_nodes of the numbering
  /// @throws std::invalid_argument for facets of another degree
  FacetLoops(const surface::Facets& facets, std::size_t num_nodes);

  std::size_t size() const { return _id.size(); }
  /// Corners, and sides, of a facet: 2, 3 or 4.
  int num_corners() const { return _num_corners; }
  const std::int32_t* corners(std::size_t f) const { return _corners.data() + f * _num_corners; }
  /// Facet beyond side k; in the plane beyond corner k. -1: there is none, or more than one.
  std::int32_t neighbour(std::size_t f, int k) const { return _neighbours[f * _num_corners + k]; }
  std::int64_t id(std::size_t f) const { return _id[f]; }
  /// Facets that have a node as corner.
  std::span<const std::int32_t> at_node(std::int32_t node) const
  {
    return std::span(_at_node).subspan(_starts[node], _starts[node + 1] - _starts[node]);
  }
  /// Edges between two facets each, in space.
  const std::vector<SurfaceEdge>& edges() const { return _edges; }
  /// The corner of a facet that a node is; -1: none.
  int corner_of(std::size_t f, std::int32_t node) const;

private:
  void find_neighbours_in_plane();
  void find_edges();

  int _num_corners = 3;
  std::vector<std::int32_t> _corners, _neighbours, _starts{0}, _at_node;
  std::vector<std::int64_t> _id;
  std::vector<SurfaceEdge> _edges;
};
} // namespace dolfinx_impact::search
