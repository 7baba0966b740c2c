// SPDX-License-Identifier: MIT
#include "RunHistory.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::problems
{
namespace
{
constexpr std::size_t size = integrators::Energies::size;

integrators::Energies energies_of(const double* values)
{
  std::array<double, size> out;
  std::copy_n(values, size, out.begin());
  return std::bit_cast<integrators::Energies>(out);
}

double sum_of_sizes(const integrators::Energies& energies)
{
  double out = 0.0;
  for (const double value : energies.values())
    out += std::abs(value);
  return out;
}
} // namespace

double total_energy(const integrators::Energies& energies)
{
  double out = 0.0;
  for (const double value : energies.values())
    out += value;
  return out - 2.0 * energies.external; // the last one, which was added
}

void RunHistory::add(std::span<const double> times, std::span<const double> steps)
{
  const std::size_t step_size = _row_size - 1;
  if (steps.size() != times.size() * step_size)
    throw std::invalid_argument("a history of " + std::to_string(times.size()) + " steps has " +
                                std::to_string(steps.size()) + " entries");
  for (std::size_t k = 0; k < times.size(); ++k)
  {
    const double* row = steps.data() + k * step_size;
    const integrators::Energies energies = energies_of(row);
    if (!_total_start)
      _total_start = total_energy(energies);
    _largest = std::max(_largest, sum_of_sizes(energies));
    if (_count++ % _stride == 0)
    {
      append(times[k], row);
      thin();
    }
  }
  if (times.empty())
    return;
  _last.assign(1, times.back());
  _last.insert(_last.end(), steps.end() - std::ptrdiff_t(step_size), steps.end());
}

void RunHistory::begin_anew()
{
  resume(std::nullopt, 0.0);
}

void RunHistory::resume(std::optional<double> total_start, double largest)
{
  _blocks.clear();
  _num_rows = 0;
  _last.clear();
  _count = 0;
  _stride = 1;
  _total_start = total_start;
  _largest = largest;
}

double RunHistory::drift(const integrators::Energies& energies) const
{
  const double total = total_energy(energies), largest = std::max(_largest, sum_of_sizes(energies));
  return largest > 0.0 ? (total - _total_start.value_or(total)) / largest : 0.0;
}

void RunHistory::set_limit(std::size_t limit)
{
  if (limit < 2)
    throw std::invalid_argument("a history keeps two rows at least, not " + std::to_string(limit));
  _limit = limit;
  thin();
}

std::size_t RunHistory::memory() const
{
  std::size_t out = 0;
  for (const std::vector<double>& block : _blocks)
    out += block.capacity() * sizeof(double);
  return out;
}

void RunHistory::append(double time, const double* step)
{
  if (_num_rows == _blocks.size() * rows_per_block)
    _blocks.emplace_back().reserve(std::min(rows_per_block, std::max<std::size_t>(_num_rows, 16)) * _row_size);
  std::vector<double>& block = _blocks.back();
  if (block.size() == block.capacity())
    block.reserve(std::min(2 * block.size(), rows_per_block * _row_size));
  block.push_back(time);
  block.insert(block.end(), step, step + _row_size - 1);
  ++_num_rows;
}

void RunHistory::thin()
{
  while (_num_rows > _limit)
  {
    _num_rows = (_num_rows + 1) / 2;
    for (std::size_t k = 1; k < _num_rows; ++k)
      std::ranges::copy(row(2 * k),
                        _blocks[k / rows_per_block].begin() + std::ptrdiff_t(k % rows_per_block * _row_size));
    _blocks.resize((_num_rows + rows_per_block - 1) / rows_per_block);
    _blocks.back().resize((_num_rows - (_blocks.size() - 1) * rows_per_block) * _row_size);
    _stride *= 2;
  }
}
} // namespace dolfinx_impact::problems
