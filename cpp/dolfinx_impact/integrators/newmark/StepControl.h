// SPDX-License-Identifier: MIT
#pragma once
#include <optional>
#include <utility>

namespace dolfinx_impact::integrators
{
/// Chooses the lengths of implicit steps: equal ones, those that a local error allows, and those after a step that
/// failed.
class StepControl
{
public:
  /// Newton iterations of a step after which the next one is shorter, and up to which it may be longer again.
  static constexpr int many = 12, few = 6;

  /// @param[in] largest step [T]
  /// @param[in] smallest step [T]
  /// @param[in] tolerance local error of the displacement in a step, relative to the largest displacement so far;
  /// nothing: steps are equal, unless one fails [1]
  /// @param[in] length step to begin with; nothing: the largest [T]
  /// @param[in] last length of the step before; a step that differs from it by round-off only gets it. 0: there is
  /// none [T]
  StepControl(double largest, double smallest, std::optional<double> tolerance = {}, std::optional<double> length = {},
              double last = 0.0);

  /// Next step on the way to a time that must be met: its length, and the time at its end, which is `goal` for the last
  /// one [T].
  std::pair<double, double> next(double time, double goal);
  /// Halve the step after one that did not converge. @returns whether the next one is long enough to be tried
  bool failed(double step);
  /// Judge the error of a converged step, nothing: there is none [1]. One that is rejected is to be repeated with the
  /// new length. @returns whether the step is accepted
  bool accepts(double step, std::optional<double> error);
  /// Choose the length of the next step after an accepted one, of which its Newton iterations and error are given.
  void choose_next_step(double step, int iterations, std::optional<double> error);

  double largest() const { return _largest; }
  double smallest() const { return _smallest; }
  const std::optional<double>& tolerance() const { return _tolerance; }
  /// Wanted length of the next step [T].
  double length() const { return _length; }
  void set_length(double length) { _length = length; }
  /// Length of the last step [T].
  double last() const { return _last; }

private:
  double factor(double error) const;

  double _largest, _smallest;
  std::optional<double> _tolerance;
  double _length, _last;
};
} // namespace dolfinx_impact::integrators
