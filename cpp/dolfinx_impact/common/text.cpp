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

std::string components(std::span<const double> x)
{
  std::string out;
  for (double value : x)
    out += (out.empty() ? "" : ", ") + text("%.4g", value);
  return out;
}
} // namespace dolfinx_impact::common
