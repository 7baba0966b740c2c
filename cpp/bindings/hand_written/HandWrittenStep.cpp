// SPDX-License-Identifier: MIT
#include "HandWrittenStep.h"
#include "dolfinx_impact/kernels/KernelTable.h"
#include "dolfinx_impact/operators/lanes.h"
#include <algorithm>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::hand_written
{
namespace
{
CellLoop loop(const CellKind& kind, int width)
{
#if defined(__x86_64__) && defined(__GNUC__)
  const CellLoop found = width == 8 ? loop8(kind) : width == 4 ? loop4(kind) : CellLoop{};
  if (found.add_forces)
    return found;
#endif
  throw std::invalid_argument("there is no step written by hand for cells with " + std::to_string(kind.num_nodes) +
                              " nodes" + (kind.one_point ? " and one point, " : ", ") + std::to_string(width) +
                              " at a time: use 4, 8 or 10 nodes, one point with 8, 4 (AVX2) or 8 (AVX-512) cells");
}

void spread(std::span<const double> values, double* padded)
{
  for (std::size_t i = 0; i < values.size(); ++i)
    padded[4 * (i / 3) + i % 3] = values[i];
}
} // namespace

std::vector<int> HandWrittenStep::widths()
{
  std::vector<int> out;
#if defined(__x86_64__) && defined(__GNUC__)
  for (int width : {4, 8})
    if (width <= kernels::processor_width())
      out.push_back(width);
#endif
  return out;
}

HandWrittenStep::HandWrittenStep(std::span<const double> x, std::span<const std::int32_t> cells, const CellKind& kind,
                                 const Elasticity& elasticity, std::span<const double> mass, int width)
    : _loop(loop(kind, width)), _elasticity(elasticity), _num_nodes(mass.size())
{
  const int nodes_per_cell = kind.num_nodes;
  if (x.size() != 3 * _num_nodes || cells.size() % nodes_per_cell != 0 || cells.empty())
    throw std::invalid_argument("the arrays of a step written by hand do not fit together");
  if (std::ranges::any_of(cells, [this](std::int32_t n) { return n < 0 || std::size_t(n) >= _num_nodes; }))
    throw std::invalid_argument("a cell has a node that does not exist");
  const std::size_t num_cells = cells.size() / nodes_per_cell;
  _num_batches = (num_cells + width - 1) / width;
  // Lanes that are left over take a copy of the last cell, whose nodes nobody reads.
  const std::size_t padding = nodes_per_cell;
  _cells.resize(_num_batches * width * nodes_per_cell);
  for (std::size_t k = 0; k < _num_batches * width; ++k)
    for (int i = 0; i < nodes_per_cell; ++i)
      _cells[(k / width * nodes_per_cell + i) * width + k % width] =
          k < num_cells ? cells[k * nodes_per_cell + i] : std::int32_t(_num_nodes) + i;
  _storage.resize(4 * 4 * (_num_nodes + padding) + operators::doubles_per_line);
  double* positions = operators::aligned(_storage.data());
  spread(x, positions);
  for (int i = 0; i < nodes_per_cell; ++i)
    std::copy_n(positions + 4 * cells[(num_cells - 1) * nodes_per_cell + i], 4, positions + 4 * (_num_nodes + i));
  for (double m : mass)
    _inverse_mass.push_back(1.0 / m);
}

NodalArrays HandWrittenStep::arrays()
{
  const std::size_t size = (_storage.size() - operators::doubles_per_line) / 4;
  double* first = operators::aligned(_storage.data());
  return {first, first + size, first + 2 * size, first + 3 * size, _inverse_mass.data()};
}

void HandWrittenStep::start(std::span<const double> u, std::span<const double> v)
{
  if (u.size() != 3 * _num_nodes || v.size() != 3 * _num_nodes)
    throw std::invalid_argument("displacements and velocities have three entries per node");
  const NodalArrays a = arrays();
  spread(u, a.u);
  spread(v, a.v);
  _started = false;
}

void HandWrittenStep::run(int num_steps, double step)
{
  NodalArrays a = arrays();
  for (int k = 0; k < num_steps; ++k)
  {
    _loop.add_forces({_cells.data(), _num_batches}, _elasticity, a);
    if (!_started)
      for (std::size_t i = 0; i < 4 * _num_nodes; ++i)
        a.r[i] *= 0.5;
    _started = true;
    _loop.update(_num_nodes, step, a);
  }
}

std::vector<double> HandWrittenStep::displacement() const
{
  const double* u = const_cast<HandWrittenStep*>(this)->arrays().u;
  std::vector<double> out(3 * _num_nodes);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = u[4 * (i / 3) + i % 3];
  return out;
}
} // namespace dolfinx_impact::hand_written
