// SPDX-License-Identifier: MIT
#pragma once
#include "FunctionsOfTime.h"
#include "KernelForce.h"
#include <dolfinx/fem/Constant.h>
#include <dolfinx/fem/Form.h>
#include <memory>
#include <vector>

namespace dolfinx_impact::problems
{
/// Loads that the residual of bodies contains.
struct BodyLoads
{
  /// A constant of the residual that is multiplied with a function of time.
  struct Scaled
  {
    std::shared_ptr<dolfinx::fem::Constant<double>> constant;
    FunctionOfTime amplitude; ///< [1]
  };

  /// Virtual work of the loads, whose nodal forces are external ones; null: there are none.
  std::shared_ptr<const dolfinx::fem::Form<double>> work = nullptr;
  std::vector<KernelForce> kernels = {}; ///< the same by kernels
  std::vector<Scaled> scaled = {};
};
} // namespace dolfinx_impact::problems
