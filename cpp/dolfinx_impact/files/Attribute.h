// SPDX-License-Identifier: MIT
#pragma once
#include "../state/State.h"
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace dolfinx_impact::files
{
/// Real numbers of any shape, the last index fastest.
struct Numbers
{
  std::vector<std::size_t> shape;
  std::vector<double> values;
};

/// A text, a whole or real number, or an array; nothing: a value of another kind, which a file may have.
typedef std::variant<std::monostate, std::string, std::int64_t, double, Numbers> Value;

/// A value by name, the same on all ranks.
struct Attribute
{
  std::string name;
  Value value;
  /// What to do if a file has another value, for the end of a message; may be empty.
  std::string advice = {};
};

typedef std::vector<Attribute> Attributes;

/// By what a problem is recognised, beside its mesh: a file of another one is refused.
struct Identity
{
  /// Texts and numbers are compared exactly, arrays to round-off: sums over ranks depend on their number.
  Attributes attributes = {};
  /// Parts with rows at some nodes, as prescribed values at supports, which are compared exactly.
  state::State supports = state::State("identity");
};

/// A value as messages show it.
std::string to_string(const Value& value);

/// Whether two values are equal, arrays to a relative tolerance of their largest entry.
bool equal(const Value& here, const Value& there, double tolerance);
} // namespace dolfinx_impact::files
