// SPDX-License-Identifier: MIT
#pragma once
#include <span>
#include <string>
#include <vector>

/// Numbers and lists in messages.
namespace dolfinx_impact::common
{
/// @param[in] format of printf, for one double
std::string text(const char* format, double value);

/// Components of a vector, with four digits, between commas.
/// @param[in] format of printf, for one double
std::string components(std::span<const double> x, const char* format = "%.4g");

/// Texts that are not empty, one behind the other.
std::string joined(const std::vector<std::string>& texts, const char* between = "; ");
} // namespace dolfinx_impact::common
