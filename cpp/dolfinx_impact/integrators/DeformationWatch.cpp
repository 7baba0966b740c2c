// SPDX-License-Identifier: MIT
#include "DeformationWatch.h"
#include <algorithm>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace dolfinx_impact::integrators
{
DeformationWatch::DeformationWatch(std::span<const std::int32_t> nodes, int nodes_per_cell, int bs, int stride)
    : _nodes(nodes.begin(), nodes.end()), _width(nodes_per_cell), _bs(bs), _stride(stride)
{
  if (nodes_per_cell < 1 || nodes.size() % nodes_per_cell)
    throw std::invalid_argument(std::to_string(nodes.size()) + " nodes are not those of cells with " +
                                std::to_string(nodes_per_cell));
}

void DeformationWatch::set(std::span<const double> u, std::span<const double> allowed)
{
  const std::int32_t last = _nodes.empty() ? -1 : *std::max_element(_nodes.begin(), _nodes.end());
  if (allowed.size() * _width != _nodes.size() || u.size() < std::size_t(last + 1) * _stride)
    throw std::invalid_argument("a watch needs a displacement of every node and an amount for every cell");
  _reference.assign(u.begin(), u.end());
  _moved.resize(u.size());
  _allowed.assign(allowed.begin(), allowed.end());
  _set = true;
}

void DeformationWatch::move_to(std::span<const double> u)
{
  if (!_set || u.size() < _reference.size())
    throw std::invalid_argument("a watch has no reference, or one of more nodes");
  for (std::size_t i = 0; i < _reference.size(); ++i)
    _moved[i] = u[i] - _reference[i];
}

namespace
{
/// Largest difference of a component between nodes. All sizes may be integral constants: then loops are unrolled.
double largest_difference(const std::int32_t* nodes, const double* moved, auto width, auto bs, auto stride)
{
  double largest = 0.0;
  for (int k = 0; k < int(bs); ++k)
  {
    double low = moved[std::size_t(nodes[0]) * stride + k], high = low;
    for (int j = 1; j < int(width); ++j)
    {
      const double value = moved[std::size_t(nodes[j]) * stride + k];
      low = std::min(low, value);
      high = std::max(high, value);
    }
    largest = std::max(largest, high - low);
  }
  return largest;
}

template <int n>
constexpr std::integral_constant<int, n> constant{};

/// Calls f(width, bs, stride), with integral constants for cells of degree one.
auto with_sizes(int width, int bs, int stride, auto f)
{
  if (width == 3 && bs == 2)
    return f(constant<3>, constant<2>, constant<2>);
  if (width == 4 && bs == 2)
    return f(constant<4>, constant<2>, constant<2>);
  if (width == 4 && bs == 3 && stride == 4)
    return f(constant<4>, constant<3>, constant<4>);
  if (width == 8 && bs == 3 && stride == 4)
    return f(constant<8>, constant<3>, constant<4>);
  return f(width, bs, stride);
}
} // namespace

std::vector<double> DeformationWatch::deformations(std::span<const double> u)
{
  move_to(u);
  std::vector<double> out(_allowed.size());
  with_sizes(_width, _bs, _stride,
             [&](auto width, auto bs, auto stride)
             {
               for (std::size_t cell = 0; cell < out.size(); ++cell)
                 out[cell] = largest_difference(_nodes.data() + cell * width, _moved.data(), width, bs, stride);
               return true;
             });
  return out;
}

bool DeformationWatch::passed(std::span<const double> u)
{
  move_to(u);
  return with_sizes(_width, _bs, _stride,
                    [&](auto width, auto bs, auto stride)
                    {
                      for (std::size_t cell = 0; cell < _allowed.size(); ++cell)
                        if (largest_difference(_nodes.data() + cell * width, _moved.data(), width, bs, stride) >
                            _allowed[cell])
                          return true;
                      return false;
                    });
}
} // namespace dolfinx_impact::integrators
