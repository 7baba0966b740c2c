// SPDX-License-Identifier: MIT
#pragma once
#include <dolfinx/fem/Function.h>
#include <memory>
#include <string>

namespace dolfinx_impact::enforcement
{
/// A field that a law of the interface reads on both sides: a scalar function of the degree of the displacement.
struct InterfaceField
{
  std::string name;
  std::shared_ptr<const dolfinx::fem::Function<double>> function;
};
} // namespace dolfinx_impact::enforcement
