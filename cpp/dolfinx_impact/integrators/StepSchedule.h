// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>

namespace dolfinx_impact::integrators
{
/// Equal steps between two times, numbered as the steps of the run.
struct StepSchedule
{
  double begin = 0.0, until = 0.0; ///< time at the first and at the last step [T]
  std::int64_t first = 0, last = 1;
  bool automatic = false; ///< was the length chosen by the stable step?

  /// Length of a step [T].
  double dt() const { return (until - begin) / double(last - first); }
  /// Time of a step; that of step `last` is exactly `until` [T].
  double time(std::int64_t step) const { return step == last ? until : begin + double(step - first) * dt(); }
  bool operator==(const StepSchedule&) const = default;
};
} // namespace dolfinx_impact::integrators
