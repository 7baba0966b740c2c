// SPDX-License-Identifier: MIT
#include "NodeMasses.h"

namespace dolfinx_impact::integrators
{
NodeMasses::NodeMasses(const NodalFields& fields)
{
  if (fields.bs != 3 || !fields.is_padded())
    return;
  const std::size_t num_nodes = fields.owned_entries / 4;
  std::vector<double> mass(num_nodes), inverse(num_nodes);
  std::vector<std::uint8_t> free(num_nodes, 0);
  for (std::size_t k = 0; k < num_nodes; ++k)
  {
    mass[k] = fields.mass[4 * k];
    inverse[k] = 1.0 / mass[k];
    for (int c = 0; c < 3; ++c)
    {
      const double of_component = fields.inverse[4 * k + c];
      if (fields.mass[4 * k + c] != mass[k] || (of_component != 0.0 && of_component != inverse[k]))
        return;
      free[k] |= std::uint8_t((of_component > 0.0) << c);
    }
  }
  _mass = std::move(mass);
  _inverse = std::move(inverse);
  _free = std::move(free);
}

void NodeMasses::prescribe(std::size_t entry)
{
  if (entry / 4 < _free.size())
    _free[entry / 4] &= std::uint8_t(~(1u << entry % 4));
}
} // namespace dolfinx_impact::integrators
