// SPDX-License-Identifier: MIT
#pragma once
#include <cstdio>
#include <string>
#include <vector>

/// Numbers and lists in messages.
namespace dolfinx_impact::common
{
/// A number as printf writes it.
inline std::string text_of(const char* format, double value)
{
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// Texts that are not empty, one behind the other.
inline std::string joined(const std::vector<std::string>& texts, const char* between = "; ")
{
  std::string out;
  for (const std::string& text : texts)
    if (!text.empty())
      out += (out.empty() ? "" : between) + text;
  return out;
}

/// A point: its coordinates in parentheses.
inline std::string text_of_point(const double* x, int gdim, const char* format = "%.4g")
{
  std::string out = "(";
  for (int c = 0; c < gdim; ++c)
    out += (c ? ", " : "") + text_of(format, x[c] + 0.0);
  return out + ")";
}
} // namespace dolfinx_impact::common
