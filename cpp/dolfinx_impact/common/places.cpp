// SPDX-License-Identifier: MIT
#include "places.h"
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace dolfinx_impact::common
{
std::string shortest(double value)
{
  if (!std::isfinite(value))
    return std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
  const double size = std::abs(value);
  const bool plain = size == 0.0 || (size >= 1e-4 && size < 1e16);
  char buffer[64];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value,
                                 plain ? std::chars_format::fixed : std::chars_format::scientific);
  std::string out(buffer, end.ptr);
  if (plain && out.find('.') == std::string::npos)
    out += ".0";
  return out;
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
} // namespace dolfinx_impact::common
