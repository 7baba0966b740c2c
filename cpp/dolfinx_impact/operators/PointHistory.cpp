// SPDX-License-Identifier: MIT
#include "PointHistory.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dolfinx_impact::operators
{
PointHistory::PointHistory(const impact_kernel& kernel, std::span<const std::int32_t> cells, int width)
    : _cells(cells.begin(), cells.end()), _num_points(kernel.num_points), _width(width),
      _num_batches((cells.size() + width - 1) / width), _has_history(_num_batches)
{
  if (kernel.num_outputs == 0 && kernel.local_unknowns == 0)
    throw std::invalid_argument(std::string("kernel ") + kernel.name + " has no outputs at its points, so no history");
  for (int i = 0; i < kernel.num_outputs; ++i)
  {
    const impact_output& o = kernel.outputs[i];
    Field f{o.name, o.num_components, o.coefficient >= 0, std::size_t(_num_points) * o.num_components * width, {}, {}};
    f.committed.resize(_num_batches * f.batch_size);
    if (f.is_history)
      f.trial.resize(f.committed.size());
    _fields.push_back(std::move(f));
  }
}

void PointHistory::commit()
{
  if (!_evaluated)
    return;
  for (Field& f : _fields)
    if (f.is_history)
      std::ranges::copy(f.trial, f.committed.begin()); // not exchanged: a State has views of committed values
  _evaluated = _knows_history = false;
}

unsigned char* PointHistory::batches_with_history()
{
  if (!_knows_history)
  {
    std::ranges::fill(_has_history, 0);
    for (const Field& f : _fields)
      for (std::size_t batch = 0; f.is_history && batch < _num_batches; ++batch)
      {
        const std::span<const double> values(f.committed.data() + batch * f.batch_size, f.batch_size);
        _has_history[batch] |= !std::ranges::all_of(values, [](double x) { return x == 0.0 && !std::signbit(x); });
      }
    _knows_history = true;
  }
  return _has_history.data();
}

void PointHistory::set_in_place(bool in_place)
{
  _in_place = in_place;
  _evaluated = _has_snapshot = _knows_history = false;
}

void PointHistory::store_snapshot()
{
  if (!_in_place)
    throw std::logic_error("history has snapshots in place only: the second array holds trial values");
  for (Field& f : _fields)
    std::ranges::copy(f.committed.begin(), f.committed.begin() + f.trial.size(), f.trial.begin());
  _has_snapshot = true;
}

void PointHistory::restore_snapshot()
{
  if (!_in_place || !_has_snapshot)
    throw std::logic_error("history has no snapshot to go back to");
  for (Field& f : _fields)
    std::ranges::copy(f.trial, f.committed.begin());
  _knows_history = false;
}

std::size_t PointHistory::find(const std::string& name) const
{
  std::string known;
  for (std::size_t i = 0; i < _fields.size(); ++i)
  {
    if (_fields[i].name == name)
      return i;
    known += (i ? ", " : "") + _fields[i].name;
  }
  throw std::invalid_argument("no values at the points are called '" + name + "'; there are: " + known);
}

std::size_t PointHistory::entry(const Field& f, std::size_t cell, int point, int component) const
{
  const std::size_t batch = cell / _width, lane = cell % _width;
  return batch * f.batch_size + (std::size_t(point) * f.num_components + component) * _width + lane;
}

std::vector<double> PointHistory::values(std::size_t field, bool trial) const
{
  const Field& f = _fields.at(field);
  const AlignedVector& from = trial && _evaluated && f.is_history ? f.trial : f.committed;
  std::vector<double> out;
  out.reserve(_cells.size() * _num_points * f.num_components);
  for (std::size_t cell = 0; cell < _cells.size(); ++cell)
    for (int q = 0; q < _num_points; ++q)
      for (int c = 0; c < f.num_components; ++c)
        out.push_back(from[entry(f, cell, q, c)]);
  return out;
}

void PointHistory::copy_cell(std::size_t field, std::size_t cell, double* out) const
{
  const Field& f = _fields[field];
  const double* from = f.committed.data() + entry(f, cell, 0, 0);
  for (int i = 0; i < _num_points * f.num_components; ++i)
    out[i] = from[std::size_t(i) * _width];
}

void PointHistory::set_values(std::size_t field, std::span<const double> values)
{
  Field& f = _fields.at(field);
  const std::size_t per_cell = std::size_t(_num_points) * f.num_components;
  if (values.size() != _cells.size() * per_cell)
    throw std::invalid_argument("'" + f.name + "' has " + std::to_string(_cells.size()) + " cells with " +
                                std::to_string(_num_points) + " points and " + std::to_string(f.num_components) +
                                " components here, found " + std::to_string(values.size()) + " values");
  if (!std::ranges::all_of(values, [](double x) { return std::isfinite(x); }))
    throw std::invalid_argument("values of '" + f.name + "' must be finite numbers");
  for (std::size_t lane = 0; lane < _num_batches * _width && !_cells.empty(); ++lane)
  {
    const std::size_t cell = std::min(lane, _cells.size() - 1); // the last batch repeats its last cell
    for (int q = 0; q < _num_points; ++q)
      for (int c = 0; c < f.num_components; ++c)
        f.committed[entry(f, lane, q, c)] = values[cell * per_cell + std::size_t(q) * f.num_components + c];
  }
  _evaluated = _knows_history = false;
}

state::State PointHistory::state(const std::string& name)
{
  _knows_history = false; // what the state refers to may be set
  state::State out(name);
  for (Field& f : _fields)
    if (f.is_history)
      out.add(f.name, state::Place::rank, state::View(std::span<double>(f.committed)));
  return out;
}

std::size_t PointHistory::memory() const
{
  std::size_t entries = 0;
  for (const Field& f : _fields)
    entries += f.committed.size() + f.trial.size();
  return entries * sizeof(double);
}
} // namespace dolfinx_impact::operators
