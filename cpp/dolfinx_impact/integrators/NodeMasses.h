// SPDX-License-Identifier: MIT
#pragma once
#include "NodalFields.h"
#include <cstdint>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Masses of owned nodes of three components, for `update`: one number a node, and which components are prescribed.
/// Numbers for each degree of freedom would be a fifth of what an update reads and writes.
class NodeMasses
{
public:
  NodeMasses() = default;
  /// @param[in] fields their masses and inverse masses are set
  explicit NodeMasses(const NodalFields& fields);
  /// Are there any? Not where components of a node have different masses, or nodes are not padded to four entries.
  bool known() const { return !_mass.empty(); }
  /// The velocity of a degree of freedom is prescribed.
  /// @param[in] entry its place in the arrays of NodalFields
  void prescribe(std::size_t entry);

  /// By node [M], [1/M].
  const double* mass() const { return _mass.data(); }
  const double* inverse() const { return _inverse.data(); }
  /// By node: bit c is set where component c is free.
  const std::uint8_t* free() const { return _free.data(); }

private:
  std::vector<double> _mass, _inverse;
  std::vector<std::uint8_t> _free;
};
} // namespace dolfinx_impact::integrators
