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
  _inverse.assign(common::array(*_average->x()).size(), 0.0);
  volume.assemble(_inverse);
  _halo.reverse(_inverse, 1);
  _halo.forward(_inverse, 1);
  for (double& value : _inverse)
    value = value > 0.0 ? 1.0 / value : 0.0;
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

/// Sums over this rank's cells.
void NodalAverage::add_up(std::span<double> sums)
{
  const std::span<const Batches> integrals = _measure->batches();
  if (!_linear || !_values || !_positions || integrals.empty())
  {
    std::ranges::fill(sums, 0.0);
    _measure->assemble(sums);
    return;
  }
  if (!_sums || _version != _positions->version())
  {
    _sums.emplace(integrals, _displacement);
    _version = _positions->version();
  }
  const int stride = _stride > 0 ? _stride : integrals.front().nodes_of(_displacement).block_size;
  _sums->multiply(_values, stride, sums);
}

void NodalAverage::update()
{
  const std::span<double> values = common::array(*_average->x());
  add_up(values);
  _halo.reverse(values, 1);
  _halo.forward(values, 1);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] *= _inverse[i];
}
} // namespace dolfinx_impact::operators
