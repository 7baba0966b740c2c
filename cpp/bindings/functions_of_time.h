// SPDX-License-Identifier: MIT
#pragma once
// Functions of time of Python's, which a problem in C++ does not keep: it asks for their table during a call.
#include "arrays.h"
#include "dolfinx_impact/problems/FunctionsOfTime.h"
#include <algorithm>
#include <optional>

namespace dolfinx_impact::bindings
{
/// A function of time whose later values a table has; here it has one value, at the start.
inline std::optional<problems::FunctionOfTime> from_table(const std::optional<Values>& start)
{
  if (!start)
    return std::nullopt;
  return problems::FunctionOfTime(
      [value = std::vector<double>(start->data(), start->data() + start->size())](std::span<const double> times,
                                                                                  std::span<double> values)
      {
        for (std::size_t k = 0; k < times.size(); ++k)
          std::copy(value.begin(), value.end(), values.begin() + std::ptrdiff_t(k * value.size()));
      },
      int(start->size()), "a function of time");
}
} // namespace dolfinx_impact::bindings
