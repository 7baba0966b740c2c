// SPDX-License-Identifier: MIT
#include "Loads.h"
#include <algorithm>
#include <limits>
#include <stdexcept>

namespace dolfinx_impact::integrators
{
namespace
{
constexpr double never = std::numeric_limits<double>::quiet_NaN();
constexpr auto wrong_size = "a load has as many values as degrees of freedom";
} // namespace

void Loads::add(std::span<const std::int32_t> entries, std::span<const double> values, int amplitude)
{
  if (entries.size() != values.size())
    throw std::invalid_argument(wrong_size);
  _loads.push_back({{entries.begin(), entries.end()}, {values.begin(), values.end()}, amplitude, never});
  _forces.resize(_size, 0.0);
  _loaded.resize(_size, false);
  for (const std::int32_t entry : entries)
    _loaded[entry] = true;
}

void Loads::set_values(std::size_t i, std::span<const double> values)
{
  Load& load = _loads.at(i);
  if (values.size() != load.values.size())
    throw std::invalid_argument(wrong_size);
  load.values.assign(values.begin(), values.end());
  load.applied = never;
}

void Loads::apply(const double* amplitudes)
{
  bool changed = false;
  for (Load& load : _loads)
  {
    const double value = load.amplitude < 0 ? 1.0 : amplitudes[load.amplitude];
    changed = changed || value != load.applied;
    load.applied = value;
  }
  if (!changed)
    return;
  // The sum starts from zero, so that it does not depend on the amplitudes before.
  std::fill(_forces.begin(), _forces.end(), 0.0);
  for (const Load& load : _loads)
    for (std::size_t k = 0; k < load.entries.size(); ++k)
      _forces[load.entries[k]] += load.applied * load.values[k];
}
} // namespace dolfinx_impact::integrators
