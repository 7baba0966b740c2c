// SPDX-License-Identifier: MIT
#include "text.h"
#include <cstdio>

namespace dolfinx_impact::common
{
std::string text(const char* format, double value)
{
  std::string out(std::snprintf(nullptr, 0, format, value), '\0');
  std::snprintf(out.data(), out.size() + 1, format, value);
  return out;
}

std::string components(std::span<const double> x, const char* format)
{
  std::string out;
  for (double value : x)
    out += (out.empty() ? "" : ", ") + text(format, value);
  return out;
}

std::string joined(const std::vector<std::string>& texts, const char* between)
{
  std::string out;
  for (const std::string& text : texts)
    if (!text.empty())
      out += (out.empty() ? "" : between) + text;
  return out;
}
} // namespace dolfinx_impact::common
