// SPDX-License-Identifier: MIT
#pragma once
#include "Motion.h"
#include <optional>
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
/// What drives an implicit run: loads, supports and rigid masters as functions of time.
class Excitation
{
public:
  virtual ~Excitation() = default;

  /// Sample all functions of time. Collective: an error on one rank is one on all.
  /// @param[in] step length of the step that begins or ends then, over a part of which prescribed motion is
  /// differentiated; nothing: velocities and accelerations are zero [T]
  /// @param[in] time [T]
  virtual TimeValues sample(std::optional<double> step, double time) = 0;
  /// Multiply the loads that the bodies' residual contains with amplitudes, until `unscale`.
  virtual void scale(std::span<const double> factors) = 0;
  virtual void unscale() = 0;
  /// Nodal forces of the loads as they are scaled now, owned [F]. Collective.
  virtual std::vector<double> external_forces() = 0;
};

/// Loads are scaled as long as this lives.
class Scaled
{
public:
  Scaled(Excitation& excitation, std::span<const double> factors) : _excitation(excitation)
  {
    _excitation.scale(factors);
  }
  ~Scaled() { _excitation.unscale(); }
  Scaled(const Scaled&) = delete;
  Scaled& operator=(const Scaled&) = delete;

private:
  Excitation& _excitation;
};
} // namespace dolfinx_impact::integrators
