// SPDX-License-Identifier: MIT
#pragma once
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::common
{
/// Shortest text that is read as the same number, always with a point or an exponent: 0.0, 1.5, 1e-07.
std::string shortest(double value);
/// A position rounded to nine decimals: [0.0, 1.5].
std::string place(std::span<const double> x);
/// Positions of gdim components one after the other: [[0.0, 1.5], [1.0, 1.5]].
std::string places(std::span<const double> x, int gdim);
} // namespace dolfinx_impact::common
