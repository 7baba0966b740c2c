// SPDX-License-Identifier: MIT
#pragma once
#include <chrono>

namespace dolfinx_impact::common
{
/// Adds the time from its construction to its end to a sum.
class Stopwatch
{
public:
  /// @param[in,out] seconds the sum; it must outlive the stopwatch [s]
  explicit Stopwatch(double& seconds) : _seconds(seconds) {}
  ~Stopwatch() { _seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - _begin).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

private:
  double& _seconds;
  std::chrono::steady_clock::time_point _begin = std::chrono::steady_clock::now();
};
} // namespace dolfinx_impact::common
