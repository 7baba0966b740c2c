// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/InternalForce.h"
#include <dolfinx/fem/Constant.h>
#include <memory>
#include <span>
#include <vector>

namespace dolfinx_impact::problems
{
/// Constants of a form that kernels read, one behind the other: their values are read anew at every call.
typedef std::vector<std::shared_ptr<const dolfinx::fem::Constant<double>>> Constants;

/// Give an operator the present values of its constants.
/// @param[in] target operator with set_constants(integral, values)
/// @param[in] constants of each of its integrals; none: the integral's values are fixed
template <typename Operator>
void set_constants(Operator& target, const std::vector<Constants>& constants)
{
  std::vector<double> values;
  for (std::size_t i = 0; i < constants.size(); ++i)
  {
    if (constants[i].empty())
      continue;
    values.clear();
    for (const auto& constant : constants[i])
      values.insert(values.end(), constant->value.begin(), constant->value.end());
    target.set_constants(i, values);
  }
}

/// An operator, and the constants of each of its integrals; without any the integrals have fixed values.
struct KernelForce
{
  std::shared_ptr<operators::InternalForce> force;
  std::vector<Constants> constants = {};

  /// Add this rank's contributions at the present values of the constants.
  /// @param[in,out] b owned and ghost entries
  void assemble(std::span<double> b) const
  {
    set_constants(*force, constants);
    force->assemble(b);
  }
  /// Value of an operator of rank 0 on this rank, at the present values of the constants.
  double value() const
  {
    set_constants(*force, constants);
    return force->value();
  }
};
} // namespace dolfinx_impact::problems
