// SPDX-License-Identifier: MIT
#include "History.h"
#include <algorithm>

namespace dolfinx_impact::integrators
{
void History::write(std::size_t step, const Energies& energies, std::span<const double> forces) const
{
  if (_values.empty())
    return;
  const auto row = _values.subspan(step * _row_size, _row_size);
  const auto values = energies.values();
  std::copy(forces.begin(), forces.end(), std::copy(values.begin(), values.end(), row.begin()));
}
} // namespace dolfinx_impact::integrators
