// SPDX-License-Identifier: MIT
#pragma once
#include "../integrators/StepSchedule.h"
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::problems
{
/// What a run tells and asks between its steps. What a function throws, it must throw on all ranks alike; all but
/// `asked` and `room` may be collective.
class RunObserver
{
public:
  virtual ~RunObserver() = default;
  /// Is this rank asked to stop after a step?
  virtual bool asked() { return false; }
  /// Is there something to ask at all?
  virtual bool asks() const { return false; }
  /// Most steps until `after_steps` is to be called, the same on all ranks.
  virtual std::int64_t room() { return std::numeric_limits<std::int64_t>::max(); }
  /// The steps of a call of `advance` are known.
  virtual void begins(const integrators::StepSchedule& schedule) { (void)schedule; }
  /// Rows of the functions of time at times; nothing: those of the problem. Collective.
  virtual std::optional<std::vector<double>> table(std::span<const double> times)
  {
    (void)times;
    return std::nullopt;
  }
  /// Which local equations of the materials were not solved, in words, or an empty text; nothing: the number is told.
  virtual std::optional<std::string> unsolved() { return std::nullopt; }
  /// Steps were made.
  /// @param[in] times before them [T]
  /// @param[in] steps rows as CentralDifference::run writes them
  virtual void add_rows(std::span<const double> times, std::span<const double> steps) { (void)times, (void)steps; }
  /// One step or several are complete.
  virtual void after_steps() {}
  /// On one rank.
  virtual void warn(const std::string& text) { (void)text; }
  /// The run has failed and goes back to its last good state.
  virtual void failed() {}
};
} // namespace dolfinx_impact::problems
