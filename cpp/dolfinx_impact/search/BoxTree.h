// SPDX-License-Identifier: MIT
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

/// Fourth stage: which slave facets and master facets can meet, and where a point is closest to a surface.
namespace dolfinx_impact::search
{
/// Bounding-volume hierarchy of axis-parallel boxes in flat arrays. A box is 2*gdim numbers: its lower corner, then its
/// upper corner. Queries allocate nothing; what they find goes to a visitor.
class BoxTree
{
public:
  BoxTree() = default;
  /// @param[in] gdim 2 or 3
  /// @param[in] boxes boxes[2*gdim*i + ...]; may be empty [L]
  BoxTree(int gdim, std::span<const double> boxes);

  /// Other boxes, same tree: right for any boxes, fast while they have moved little.
  /// @pre as many boxes as at construction
  void refit(std::span<const double> boxes);
  std::size_t size() const { return _order.size(); }
  int gdim() const { return _gdim; }
  /// Square of the distance from x to box i, zero inside [L^2].
  double squared_distance(std::int32_t i, const double* x) const
  {
    const double* box = _boxes.data() + 2 * _gdim * i;
    return _gdim == 2 ? squared_distance<2>(box, x) : squared_distance<3>(box, x);
  }

  /// Calls visit(i) for every box i that overlaps `box` (touching counts), in no particular order.
  template <typename Visitor>
  void overlapping(const double* box, Visitor visit) const;
  /// @param[out] found ascending numbers of the boxes that overlap `box`; cleared first
  void overlapping(const double* box, std::vector<std::int32_t>& found) const;
  /// Calls visit(i) for boxes that may lie within a distance of x, near ones first. The visitor returns the square of
  /// the distance beyond which boxes no longer matter.
  /// @param[in] squared_limit that square at the beginning [L^2]
  template <typename Visitor>
  void nearest(const double* x, double squared_limit, Visitor visit) const
  {
    if (_gdim == 2)
      nearest_in<2>(x, squared_limit, visit);
    else
      nearest_in<3>(x, squared_limit, visit);
  }

private:
  struct Node
  {
    std::int32_t first, last; ///< range of _order
    std::int32_t left;        ///< children are left and left + 1; 0: a leaf
  };
  static constexpr int max_depth = 64;

  bool overlap(const double* a, const double* b) const;
  template <int D, typename Visitor>
  void nearest_in(const double* x, double squared_limit, Visitor& visit) const;
  template <int D>
  static double squared_distance(const double* box, const double* x)
  {
    double sum = 0.0;
    for (int c = 0; c < D; ++c)
    {
      const double low = box[c] - x[c], high = x[c] - box[D + c], out = low < high ? high : low;
      sum += out > 0.0 ? out * out : 0.0;
    }
    return sum;
  }
  void fit(std::size_t node);

  int _gdim = 3;
  std::vector<double> _boxes;       ///< as given
  std::vector<std::int32_t> _order; ///< box numbers, leaf by leaf
  std::vector<Node> _nodes;         ///< parents before children
  std::vector<double> _node_boxes;  ///< 2*gdim numbers per node
};

template <typename Visitor>
void BoxTree::overlapping(const double* box, Visitor visit) const
{
  if (_nodes.empty())
    return;
  std::array<std::int32_t, max_depth> stack;
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0)
  {
    const std::int32_t n = stack[--depth];
    if (!overlap(_node_boxes.data() + 2 * _gdim * n, box))
      continue;
    const Node& node = _nodes[n];
    if (node.left > 0)
    {
      stack[depth++] = node.left + 1;
      stack[depth++] = node.left;
    }
    else // one box: that of the leaf
      visit(_order[node.first]);
  }
}

template <int D, typename Visitor>
void BoxTree::nearest_in(const double* x, double squared_limit, Visitor& visit) const
{
  if (_nodes.empty())
    return;
  std::array<std::int32_t, max_depth> stack;
  std::array<double, max_depth> distance;
  int depth = 0;
  distance[depth] = squared_distance<D>(_node_boxes.data(), x);
  stack[depth++] = 0;
  while (depth > 0)
  {
    --depth;
    if (!(distance[depth] <= squared_limit))
      continue;
    const Node& node = _nodes[stack[depth]];
    if (node.left > 0)
    {
      const double left = squared_distance<D>(_node_boxes.data() + 2 * D * node.left, x);
      const double right = squared_distance<D>(_node_boxes.data() + 2 * D * (node.left + 1), x);
      const bool left_first = left <= right;
      distance[depth] = left_first ? right : left;
      stack[depth++] = node.left + (left_first ? 1 : 0);
      distance[depth] = left_first ? left : right;
      stack[depth++] = node.left + (left_first ? 0 : 1);
    }
    else // one box: that of the leaf
      squared_limit = visit(_order[node.first]);
  }
}
} // namespace dolfinx_impact::search
