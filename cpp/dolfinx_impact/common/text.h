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

/// The shortest text that is read as this number again, with a point: 0.0, 0.25, 1e-05.
std::string shortest(double value);

/// A position rounded to nine decimals: [0.0, 1.5].
std::string place(std::span<const double> x);

/// Positions of gdim components one after the other: [[0.0, 1.5], [1.0, 1.5]].
std::string places(std::span<const double> x, int gdim);

/// Texts that are not empty, one behind the other.
std::string joined(const std::vector<std::string>& texts, const char* between = "; ");
} // namespace dolfinx_impact::common
