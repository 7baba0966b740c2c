// SPDX-License-Identifier: MIT
#include "constants.h"
#include <algorithm>
#include <span>
#include <stdexcept>

namespace dolfinx_impact::kernels
{
std::vector<double> constants(const impact_kernel& kernel, const std::map<std::string, std::vector<double>>& values)
{
  std::vector<double> packed(kernel.size_c);
  for (const impact_constant& c : std::span(kernel.constants, kernel.num_constants))
  {
    const auto found = values.find(c.name);
    if (found == values.end())
      throw std::invalid_argument(std::string("kernel ") + kernel.name + " has the constant " + c.name +
                                  ", which is not among the values: give it one");
    if (found->second.size() != std::size_t(c.size))
      throw std::invalid_argument(std::string("kernel ") + kernel.name + ": the constant " + c.name + " has " +
                                  std::to_string(c.size) + " components, but " + std::to_string(found->second.size()) +
                                  " values were given");
    std::ranges::copy(found->second, packed.begin() + c.offset);
  }
  return packed;
}
} // namespace dolfinx_impact::kernels
