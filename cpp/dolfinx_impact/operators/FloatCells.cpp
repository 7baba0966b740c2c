// SPDX-License-Identifier: MIT
#include "FloatCells.h"
#include "gather_float.h"
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
    : _functions(kernels::float_functions(kernel, nodes.width)), _lanes(_functions.lanes), _num_nodes(nodes.per_cell),
      _num_mesh_nodes(mesh_nodes.per_cell), _num_cells(num_cells),
      // Forces of lengths that are divided by h are smaller by its square.
      _scale(cell_size > 0.0 ? std::exp2(-std::round(std::log2(cell_size))) : 1.0),
      _force_scale(1.0 / (_scale * _scale)), _nodes(in_batches(nodes, num_cells, _lanes)),
      _mesh_nodes(in_batches(mesh_nodes, num_cells, _lanes))
{
  _A.resize(std::size_t(3) * _num_nodes * _lanes, 0.0f);
  _w.resize(_A.size());
  _x.resize(std::size_t(3) * _num_mesh_nodes * _lanes);
  _places.resize(_mesh_nodes.size() / _num_mesh_nodes * (_num_mesh_nodes - 1) * 3);
}

/// Positions stay where they are: differences are taken once, in double, and then read one after the other.
void FloatCells::place(const CellPlaces& places) const
{
  if (places.version != 0 && places.version == _version)
    return;
  _version = places.version;
  const std::size_t first = std::size_t(3) * _lanes, size = _x.size() - first; // those of the first node are zero
  const std::int32_t* nodes = (places.as_space ? _nodes : _mesh_nodes).data();
  const std::size_t per_batch = std::size_t(places.as_space ? _num_nodes : _num_mesh_nodes) * _lanes;
  for (std::size_t k = 0; k < _places.size() / size; ++k)
  {
    gather_differences(_lanes, places.positions.values, places.positions.stride, nodes + k * per_batch, _num_mesh_nodes,
                       _scale, _x.data());
    std::copy(_x.begin() + std::ptrdiff_t(first), _x.end(), _places.begin() + std::ptrdiff_t(k * size));
  }
}

void FloatCells::run(const CellPlaces& places, const NodeValues& u, const double* constants, double* b,
                     int stride) const
{
  place(places);
  std::size_t done = 0;
  if (_functions.sweep && u.stride == 4 && stride == 4 && _num_cells >= std::size_t(_lanes))
  {
    done = _num_cells / _lanes;
    const impact_float_cells cells{done, _nodes.data(), constants, _places.data(), u.values, b, _scale, _force_scale};
    _functions.sweep(&cells);
  }
  for (; done * _lanes < _num_cells; ++done)
  {
    const std::int32_t* nodes = _nodes.data() + done * _num_nodes * _lanes;
    const std::size_t first = std::size_t(3) * _lanes, size = _x.size() - first;
    std::fill_n(_x.begin(), first, 0.0f);
    std::copy_n(_places.begin() + std::ptrdiff_t(done * size), size, _x.begin() + std::ptrdiff_t(first));
    gather_differences(_lanes, u.values, u.stride, nodes, _num_nodes, _scale, _w.data());
    _functions.tabulate(_A.data(), _w.data(), constants, _x.data());
    const int used = int(std::min(std::size_t(_lanes), _num_cells - done * _lanes));
    scatter_balanced(_lanes, _A.data(), nodes, _num_nodes, used, _force_scale, b, stride);
  }
}
} // namespace dolfinx_impact::operators
