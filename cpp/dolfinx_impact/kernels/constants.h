// SPDX-License-Identifier: MIT
#pragma once
#include "Kernel.h"
#include <map>
#include <string>
#include <vector>

namespace dolfinx_impact::kernels
{
/// Values of a kernel's constants in its order, as its integrals take them.
/// @param[in] kernel
/// @param[in] values by name, the components of each one after the other; others may be among them
/// @throws std::invalid_argument if a constant is missing or has another number of components
std::vector<double> constants(const impact_kernel& kernel, const std::map<std::string, std::vector<double>>& values);
} // namespace dolfinx_impact::kernels
