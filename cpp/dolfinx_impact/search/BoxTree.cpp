// SPDX-License-Identifier: MIT
#include "BoxTree.h"
#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace dolfinx_impact::search
{
BoxTree::BoxTree(int gdim, std::span<const double> boxes) : _gdim(gdim), _boxes(boxes.begin(), boxes.end())
{
  if (boxes.size() % (2 * gdim) != 0)
    throw std::invalid_argument("a box is given by 2*gdim numbers");
  _order.resize(boxes.size() / (2 * gdim));
  std::iota(_order.begin(), _order.end(), 0);
  if (_order.empty())
    return;
  _nodes.push_back({0, std::int32_t(_order.size()), 0});
  for (std::size_t n = 0; n < _nodes.size(); ++n)
  {
    const auto [first, last, left] = _nodes[n];
    if (last - first == 1)
      continue;
    // Halve the boxes across the axis along which their centres are spread most.
    int axis = 0;
    double widest = -1.0;
    for (int c = 0; c < gdim; ++c)
    {
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (std::int32_t k = first; k < last; ++k)
      {
        const double* box = _boxes.data() + 2 * gdim * _order[k];
        low = std::min(low, box[c] + box[gdim + c]);
        high = std::max(high, box[c] + box[gdim + c]);
      }
      if (high - low > widest)
      {
        widest = high - low;
        axis = c;
      }
    }
    const auto centre = [&](std::int32_t i)
    { return _boxes[2 * gdim * i + axis] + _boxes[2 * gdim * i + gdim + axis]; };
    const std::int32_t middle = first + (last - first) / 2;
    std::nth_element(_order.begin() + first, _order.begin() + middle, _order.begin() + last,
                     [&](std::int32_t a, std::int32_t b)
                     { return centre(a) < centre(b) || (centre(a) == centre(b) && a < b); });
    _nodes[n].left = std::int32_t(_nodes.size());
    _nodes.push_back({first, middle, 0});
    _nodes.push_back({middle, last, 0});
  }
  _node_boxes.resize(2 * gdim * _nodes.size());
  for (std::size_t n = _nodes.size(); n-- > 0;)
    fit(n);
}

void BoxTree::refit(std::span<const double> boxes)
{
  if (boxes.size() != _boxes.size())
    throw std::invalid_argument("a tree is refitted to as many boxes as it was made of");
  std::copy(boxes.begin(), boxes.end(), _boxes.begin());
  for (std::size_t n = _nodes.size(); n-- > 0;)
    fit(n);
}

void BoxTree::fit(std::size_t n)
{
  double* box = _node_boxes.data() + 2 * _gdim * n;
  for (int c = 0; c < _gdim; ++c)
  {
    box[c] = std::numeric_limits<double>::infinity();
    box[_gdim + c] = -box[c];
  }
  const auto include = [&](const double* other)
  {
    for (int c = 0; c < _gdim; ++c)
    {
      box[c] = std::min(box[c], other[c]);
      box[_gdim + c] = std::max(box[_gdim + c], other[_gdim + c]);
    }
  };
  const Node& node = _nodes[n];
  if (node.left > 0)
  {
    include(_node_boxes.data() + 2 * _gdim * node.left);
    include(_node_boxes.data() + 2 * _gdim * (node.left + 1));
  }
  else
    include(_boxes.data() + 2 * _gdim * _order[node.first]);
}

void BoxTree::overlapping(const double* box, std::vector<std::int32_t>& found) const
{
  found.clear();
  overlapping(box, [&](std::int32_t i) { found.push_back(i); });
  std::sort(found.begin(), found.end());
}

bool BoxTree::overlap(const double* a, const double* b) const
{
  for (int c = 0; c < _gdim; ++c)
    if (!(a[c] <= b[_gdim + c] && b[c] <= a[_gdim + c]))
      return false;
  return true;
}
} // namespace dolfinx_impact::search
