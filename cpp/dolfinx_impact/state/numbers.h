// SPDX-License-Identifier: MIT
#pragma once
#include "State.h"

/// Numbers that are the same on all ranks, and vectors, in states with values of their own.
namespace dolfinx_impact::state
{
template <typename T>
void add_number(State& out, const char* name, T value)
{
  out.add_own(name, Place::all, std::vector<T>{value});
}

/// @throws std::out_of_range naming what there is
template <typename T>
T number(const State& saved, const char* name)
{
  return saved.values<T>(name)[0];
}

/// Copy of a field of real numbers.
/// @throws std::out_of_range naming what there is
inline std::vector<double> vector(const State& saved, const char* name)
{
  const auto values = saved.values<double>(name);
  return {values.begin(), values.end()};
}
} // namespace dolfinx_impact::state
