// SPDX-License-Identifier: MIT
#include "NodalAverage.h"
#include "../common/dolfinx_api.h"
#include <algorithm>
#include <stdexcept>
#include <utility>

namespace dolfinx_impact::operators
{
NodalAverage::NodalAverage(std::shared_ptr<InternalForce> measure, const InternalForce& volume,
                           std::shared_ptr<Function> average, std::string displacement, bool linear)
    : _measure(std::move(measure)), _average(std::move(average)), _displacement(std::move(displacement)),
      _linear(linear), _halo(_average->function_space()->dofmap()->index_map)
{
  if (_measure->test_space() != _average->function_space() || volume.test_space() != _average->function_space())
    throw std::invalid_argument("measure, volume and average must have one space");
  std::vector<double> volumes(common::array(*_average->x()).size(), 0.0);
  const int bs = block_size();
  volume.assemble(volumes);
  _halo.reverse(volumes, bs);
  _halo.forward(volumes, bs);
  _inverse.resize(volumes.size() / bs);
  for (std::size_t node = 0; node < _inverse.size(); ++node)
    _inverse[node] = volumes[bs * node] > 0.0 ? 1.0 / volumes[bs * node] : 0.0;
  find_shared_nodes();
}

/// Ghosts, and nodes that are ghosts of others.
void NodalAverage::find_shared_nodes()
{
  _shared.assign(std::size_t(_halo.num_nodes()), 0);
  std::fill(_shared.begin() + _halo.num_owned(), _shared.end(), 1);
  for (const std::int32_t node : _halo.sent_nodes())
    _shared[node] = 1;
  for (std::int32_t node = 0; node < _halo.num_nodes(); ++node)
    if (_shared[node])
      _shared_nodes.push_back(node);
}

void NodalAverage::read(const double* displacement, int stride)
{
  _values = displacement;
  _stride = stride;
  _measure->read(_displacement, displacement, stride);
}

void NodalAverage::read_positions(const NodePositions* positions)
{
  _positions = positions;
  _sums.reset();
  _measure->read_positions(positions);
}

/// The matrix that gives the sums at the present positions; null where they are those of kernels.
const LinearSums* NodalAverage::linear_sums()
{
  const std::span<const Batches> integrals = _measure->batches();
  if (!_linear || !_values || !_positions || integrals.empty())
    return nullptr;
  if (!_sums || _version != _positions->version())
  {
    _sums.emplace(integrals, _displacement);
    _version = _positions->version();
  }
  return &*_sums;
}

/// Entries of a node in the array of the displacement.
int NodalAverage::stride() const
{
  return _stride > 0 ? _stride : _measure->batches().front().nodes_of(_displacement).block_size;
}

/// Sums over this rank's cells.
void NodalAverage::add_up(std::span<double> sums)
{
  if (const LinearSums* matrix = linear_sums())
    return matrix->multiply(_values, stride(), sums);
  std::ranges::fill(sums, 0.0);
  _measure->assemble(sums);
}

void NodalAverage::update()
{
  const std::span<double> values = common::array(*_average->x());
  const int bs = block_size();
  add_up(values);
  _halo.reverse(values, bs);
  _halo.forward(values, bs);
  for (std::size_t node = 0; node < _inverse.size(); ++node)
    for (int c = 0; c < bs; ++c)
      values[bs * node + c] *= _inverse[node];
}

void NodalAverage::add_forces(const MeanStress& stress, std::span<double> b, int stride)
{
  const LinearSums* matrix = linear_sums();
  // A rank without any takes part in the exchange; it may have no displacement to read either.
  const bool has_cells =
      std::ranges::any_of(_measure->batches(), [](const Batches& batches) { return batches.num_cells() > 0; });
  if (has_cells && (!matrix || stride != this->stride()))
    throw std::invalid_argument("forces of averages take a linear measure and a displacement in an array like theirs");
  const std::span<double> values = common::array(*_average->x());
  const std::size_t bs = std::size_t(block_size());
  for (const std::int32_t node : _shared_nodes) // of which the matrix may have no rows
    std::fill_n(values.begin() + std::ptrdiff_t(bs * node), bs, 0.0);
  if (has_cells)
    matrix->add_forces(stress, _inverse, _shared, _values, stride, values, b.data());
  _halo.reverse(values, int(bs));
  _halo.forward(values, int(bs));
  for (const std::int32_t node : _shared_nodes)
    for (std::size_t c = 0; c < bs; ++c)
      values[bs * node + c] *= _inverse[node];
  if (has_cells)
    matrix->add_forces_of(_shared_nodes, stress, values, stride, b.data());
}
} // namespace dolfinx_impact::operators
