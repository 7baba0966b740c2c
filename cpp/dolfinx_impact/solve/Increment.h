// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace dolfinx_impact::solve
{
/// Iterations of one attempt at an increment.
struct Increment
{
  std::string fault = "not finished"; ///< why the increment did not converge; empty if it did
  bool hopeless = false;              ///< whether a smaller increment would not help
  std::string advice = "Apply the load in smaller parts, or pass more iterations"; ///< what a user can do
  std::vector<double> residual_norms = {};         ///< norm of the free residual by iteration [F]
  std::vector<std::int64_t> active_set_sizes = {}; ///< number of active contact points by iteration
  std::vector<std::int64_t> changes = {};          ///< number of points whose status changed by iteration
  int iterations = 0;                   ///< linearised problems, each with its active set updated to convergence
  int unsettled = 0;                    ///< those of them whose active set did not converge
  int unsettled_in_succession = 0;      ///< the last of those in succession
  std::vector<std::int8_t> closed = {}; ///< whether each contact was closed at the start; empty: not known

  /// Add an iteration.
  /// @param[in] norm of the free residual [F]
  /// @param[in] size number of active contact points
  /// @param[in] changed number of points whose status changed
  void add(double norm, std::int64_t size, std::int64_t changed);
  /// Mark the increment as converged.
  Increment& converged();
  /// Mark the increment as failed.
  /// @param[in] why it failed
  /// @param[in] without_hope a smaller increment would not help
  Increment& failed(std::string why, bool without_hope = false);
  /// Period of a cycle in the last iterations: after how many the same states came again, in the last two periods; 0:
  /// no cycle.
  int cycle() const;
  /// Whether the active sets of the last linearised problems did not converge, and the residual does not fall.
  bool stalled() const;
};
} // namespace dolfinx_impact::solve
