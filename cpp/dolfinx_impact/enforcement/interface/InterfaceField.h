// SPDX-License-Identifier: MIT
#pragma once
#include <dolfinx/fem/Function.h>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// A field that a law of the interface reads on both sides: a scalar function of the degree of the displacement.
struct InterfaceField
{
  std::string name;
  std::shared_ptr<const dolfinx::fem::Function<double>> function;
};

/// A field on one of its two sides.
struct FieldSide
{
  int field; ///< its number
  bool slave;
};

/// What an input of a kernel is that is named after a field, `NAME_slave` or `NAME_master`; nothing for other names.
inline std::optional<FieldSide> field_side(const std::string& name, const std::vector<InterfaceField>& fields)
{
  for (std::size_t f = 0; f < fields.size(); ++f)
    for (const bool slave : {true, false})
      if (name == fields[f].name + (slave ? "_slave" : "_master"))
        return FieldSide{int(f), slave};
  return std::nullopt;
}
} // namespace dolfinx_impact::enforcement
