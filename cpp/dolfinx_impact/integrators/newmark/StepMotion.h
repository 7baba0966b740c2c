// SPDX-License-Identifier: MIT
#pragma once
#include "ImplicitScheme.h"
#include "Motion.h"
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Acceleration a_1 = acceleration_factor (u_1 - u_0) + acceleration_rest over one implicit step, and the velocity
/// likewise.
///
/// Prescribed degrees of freedom have the derivatives of their functions of time. Those without mass follow no equation
/// of motion: their velocity is the mean of the step.
class StepMotion
{
public:
  /// @param[in] step length of the step [T]
  /// @param[in] start motion at its start
  /// @param[in] massless, fixed masks of owned degrees of freedom without mass, and of prescribed ones
  /// @param[in] prescribed what functions of time prescribe at its end
  StepMotion(const ImplicitScheme& scheme, double step, Motion start, std::span<const std::int8_t> massless,
             std::span<const std::int8_t> fixed, const TimeValues& prescribed);

  /// Motion at the end of the step.
  /// @param[in] displacement there, owned [L]
  Motion end(std::span<const double> displacement) const;
  /// Displacement at the end of a step with constant acceleration, owned [L].
  std::vector<double> predictor() const;

  const Motion& start() const { return _start; }
  std::span<const double> acceleration_factor() const { return _acceleration_factor; } ///< [1/T^2]
  std::span<const double> velocity_factor() const { return _velocity_factor; }         ///< [1/T]

private:
  double _step, _mean_factor;
  Motion _start;
  std::vector<std::int8_t> _massless, _fixed;
  std::vector<double> _mean_rest, _acceleration_factor, _acceleration_rest, _velocity_factor, _velocity_rest;
};
} // namespace dolfinx_impact::integrators
