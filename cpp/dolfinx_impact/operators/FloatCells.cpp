// SPDX-License-Identifier: MIT
#include "FloatCells.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::operators
{
namespace
{
/// The same nodes in batches of another width; the last batch repeats the last cell.
std::vector<std::int32_t> in_batches(const FloatCells::Nodes& nodes, std::size_t num_cells, int width)
{
  const std::size_t batches = (num_cells + width - 1) / width;
  std::vector<std::int32_t> out(batches * width * nodes.per_cell);
  for (std::size_t k = 0; k < batches * width; ++k)
  {
    const std::size_t cell = std::min(k, num_cells - 1), from = cell / nodes.width, to = k / width;
    for (int i = 0; i < nodes.per_cell; ++i)
      out[(to * nodes.per_cell + i) * width + k % width] =
          nodes.numbers[(from * nodes.per_cell + i) * nodes.width + cell % nodes.width];
  }
  return out;
}
} // namespace

FloatCells::FloatCells(const impact_float_kernel& kernel, std::size_t num_cells, const Nodes& nodes,
                       const Nodes& mesh_nodes, double cell_size)
    : _lanes(kernels::float_lanes(nodes.width)), _num_nodes(nodes.per_cell), _num_mesh_nodes(mesh_nodes.per_cell),
      _num_cells(num_cells), _tabulate(kernels::tabulate(kernel, nodes.width)),
      _sweep(nodes.width > 1 ? float_sweep(_lanes) : nullptr),
      // Forces of lengths that are divided by h are smaller by its square.
      _scale(cell_size > 0.0 ? std::exp2(-std::round(std::log2(cell_size))) : 1.0),
      _force_scale(1.0 / (_scale * _scale)), _nodes(in_batches(nodes, num_cells, _lanes)),
      _mesh_nodes(in_batches(mesh_nodes, num_cells, _lanes))
{
  _A.resize(std::size_t(3) * _num_nodes * _lanes, 0.0f);
  for (Buffer& w : _w)
    w.resize(_A.size());
  for (Buffer& x : _x)
    x.resize(std::size_t(3) * _num_mesh_nodes * _lanes);
}

void FloatCells::run(const NodeValues& positions, bool as_space, const NodeValues& u, const double* constants,
                     double* b, int stride) const
{
  const std::size_t places_per_batch = std::size_t(as_space ? _num_nodes : _num_mesh_nodes) * _lanes;
  const std::int32_t* places = (as_space ? _nodes : _mesh_nodes).data();
  std::size_t done = 0;
  if (_sweep && positions.stride == 4 && u.stride == 4 && stride == 4 && _num_cells >= std::size_t(_lanes))
  {
    FloatSweep s;
    s.tabulate = _tabulate;
    s.num_batches = done = _num_cells / _lanes;
    s.position_nodes = places;
    s.num_position_nodes = _num_mesh_nodes;
    s.positions_per_batch = places_per_batch;
    s.nodes = _nodes.data();
    s.num_nodes = _num_nodes;
    s.constants = constants;
    s.positions = positions.values;
    s.values = u.values;
    s.b = b;
    s.scale = _scale;
    s.force_scale = _force_scale;
    s.A = _A.data();
    for (int half = 0; half < 2; ++half)
    {
      s.w[half] = _w[half].data();
      s.x[half] = _x[half].data();
    }
    _sweep(s);
  }
  for (; done * _lanes < _num_cells; ++done)
  {
    const std::int32_t* nodes = _nodes.data() + done * _num_nodes * _lanes;
    gather_differences(_lanes, positions.values, positions.stride, places + done * places_per_batch, _num_mesh_nodes,
                       _scale, _x[0].data());
    gather_differences(_lanes, u.values, u.stride, nodes, _num_nodes, _scale, _w[0].data());
    _tabulate(_A.data(), _w[0].data(), constants, _x[0].data());
    const int used = int(std::min(std::size_t(_lanes), _num_cells - done * _lanes));
    scatter_balanced(_lanes, _A.data(), nodes, _num_nodes, used, _force_scale, b, stride);
  }
}
} // namespace dolfinx_impact::operators
