// SPDX-License-Identifier: MIT
#pragma once
#include <span>
#include <string>

/// Numbers in messages.
namespace dolfinx_impact::common
{
/// @param[in] format of printf, for one double
std::string text(const char* format, double value);

/// Components of a vector, with four digits, between commas.
std::string components(std::span<const double> x);
} // namespace dolfinx_impact::common
