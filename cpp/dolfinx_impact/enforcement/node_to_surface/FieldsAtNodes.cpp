// SPDX-License-Identifier: MIT
#include "FieldsAtNodes.h"

namespace dolfinx_impact::enforcement
{
void FieldsAtNodes::assign_numbers(const operators::Halo& halo, std::span<const std::int32_t> numbers,
                                   std::size_t num_owned)
{
  _owned_numbers.assign(numbers.begin(), numbers.begin() + num_owned);
  for (std::vector<double>& values : _values)
    values.assign(halo.num_nodes(), 0.0);
}

void FieldsAtNodes::gather(operators::Halo& halo)
{
  for (std::size_t f = 0; f < _values.size(); ++f)
  {
    const std::span<const double> given = _fields[f].function->x()->array();
    for (std::size_t node = 0; node < _owned_numbers.size(); ++node)
      if (_owned_numbers[node] >= 0)
        _values[f][_owned_numbers[node]] = given[node];
    halo.forward(_values[f], 1);
  }
}

double FieldsAtNodes::at(std::size_t field, int num, const std::int32_t* masters, const double* phi) const
{
  double out = 0.0;
  for (int j = 0; j < num; ++j)
    out += phi[j] * _values[field][masters[j]];
  return out;
}
} // namespace dolfinx_impact::enforcement
