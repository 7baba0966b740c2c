// SPDX-License-Identifier: MIT
#include "text.h"
#include <charconv>
#include <cmath>
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

std::string shortest(double value)
{
  char digits[32];
  const std::to_chars_result end = std::to_chars(digits, digits + sizeof digits, value);
  const std::string out(digits, end.ptr);
  return out.find_first_of(".en") == std::string::npos ? out + ".0" : out;
}

std::string place(std::span<const double> x)
{
  std::string out;
  for (double value : x)
    out += (out.empty() ? "" : ", ") + shortest(std::nearbyint(value * 1e9) / 1e9);
  return "[" + out + "]";
}

std::string places(std::span<const double> x, int gdim)
{
  std::string out;
  for (std::size_t i = 0; i < x.size(); i += gdim)
    out += (out.empty() ? "" : ", ") + place(x.subspan(i, gdim));
  return "[" + out + "]";
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
