// SPDX-License-Identifier: MIT
#include "Attribute.h"
#include "../common/text.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::files
{
namespace
{
struct Shown
{
  std::string operator()(std::monostate) const { return "of another kind"; }
  // Text with quotes of its own is shown as it is.
  std::string operator()(const std::string& text) const
  {
    return text.find('\'') == std::string::npos ? "'" + text + "'" : text;
  }
  std::string operator()(std::int64_t number) const { return std::to_string(number); }
  std::string operator()(double number) const { return common::shortest(number); }
  std::string operator()(const Numbers& numbers) const
  {
    return "[" + common::components(numbers.values, "%.17g") + "]";
  }
};
} // namespace

std::string to_string(const Value& value)
{
  return std::visit(Shown(), value);
}

bool equal(const Value& here, const Value& there, double tolerance)
{
  if (here.index() != there.index() || std::holds_alternative<std::monostate>(here))
    return false;
  if (const std::string* text = std::get_if<std::string>(&here))
    return *text == std::get<std::string>(there);
  if (const std::int64_t* number = std::get_if<std::int64_t>(&here))
    return *number == std::get<std::int64_t>(there);
  if (const double* number = std::get_if<double>(&here))
    return *number == std::get<double>(there);
  const Numbers &a = std::get<Numbers>(here), &b = std::get<Numbers>(there);
  if (a.shape != b.shape)
    return false;
  double largest = 0.0;
  for (double value : a.values)
    largest = std::max(largest, std::abs(value));
  return std::ranges::equal(a.values, b.values,
                            [limit = tolerance * largest](double x, double y) { return std::abs(x - y) <= limit; });
}
} // namespace dolfinx_impact::files
