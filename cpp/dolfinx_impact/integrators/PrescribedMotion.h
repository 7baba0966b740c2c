// SPDX-License-Identifier: MIT
#pragma once
#include "Loads.h"
#include "update.h"
#include <cstdint>
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Displacements prescribed as values times amplitudes, and the support forces that they need: docs/explicit/scheme.md,
/// "Prescribed motion". The degrees of freedom have no inverse mass, so that `update` moves them on as they move; then
/// `impose` brings them where they are to be.
class PrescribedMotion
{
public:
  /// Power of the support forces with the velocities half a step before and half a step after a time level [F L/T].
  struct Power
  {
    double before = 0.0;
    double after = 0.0;
  };

  /// Prescribe a group of displacements.
  /// @param[in] entries places of owned degrees of freedom in arrays of nodal values (NodalFields)
  /// @param[in] values displacements at the amplitude one [L]
  /// @param[in] amplitude column of the amplitudes that `impose` is given; -1: the amplitude is one
  /// @throws std::invalid_argument unless there are as many values as entries
  void add(std::span<const std::int32_t> entries, std::span<const double> values, int amplitude);

  /// Keep what an update is about to change. Arrays, here and below, are those of NodalFields.
  void keep(const double* u, const double* v, const double* r);
  /// Displacements and velocities after an update.
  /// @param[in] dt step to the next time level [T]
  /// @param[in] h mean of the steps before and after the present time level [T]
  /// @param[in] alpha mass-proportional damping [1/T]
  /// @param[in] amplitudes at the next time level [1]
  /// @param[in] mass by entry [M]
  /// @param[in] loads at the present time level
  /// @param[in,out] u, v displacements and velocities after the update
  /// @param[in,out] sums of the update; those of prescribed degrees of freedom are corrected
  Power impose(double dt, double h, double alpha, const double* amplitudes, const double* mass, const Loads& loads,
               double* u, double* v, Sums& sums) const;
  /// The power before the present time level, without an update.
  /// @param[in] dt step that led here; 0 at the start [T]
  /// @param[in] amplitudes one step on [1]
  /// @param[in,out] sums of `measure`; those of prescribed degrees of freedom are corrected
  double power(double dt, double alpha, const double* amplitudes, const double* mass, const Loads& loads,
               const double* u, const double* v, const double* r, Sums& sums) const;
  /// Accelerations at the present time level, by the velocity of the next step.
  /// @param[in] dt step that led here [T]
  /// @param[in] amplitudes one step on [1]
  /// @param[out] a entries of prescribed degrees of freedom are set [L/T^2]
  void accelerations(double dt, const double* amplitudes, const double* u, const double* v, double* a) const;

private:
  struct Group
  {
    std::vector<std::int32_t> entries;
    std::vector<double> values;
    int amplitude;
    std::vector<double> u, v, r; ///< before the update
    double displacement(std::size_t k, const double* amplitudes) const
    {
      return values[k] * (amplitude < 0 ? 1.0 : amplitudes[amplitude]);
    }
  };
  std::vector<Group> _groups;
};
} // namespace dolfinx_impact::integrators
