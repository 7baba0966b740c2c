// SPDX-License-Identifier: MIT
#pragma once

namespace dolfinx_impact::integrators
{
/// Changes of constants and functions that stiffness or damping depend on, since the stable step was found, and how far
/// they may go before it is found again.
struct InputChanges
{
  /// Change of ln(omega^2) between two looks at the stable step; 0.9 of it leaves 0.21.
  static constexpr double effect = 0.1;

  bool stale = false;      ///< was there any?
  double total = 0.0;      ///< sum of relative changes [1]
  double allowed = effect; ///< sum that is allowed [1]

  /// @param[in] change relative to the value before; 1 for one that was zero
  void add(double change);
  /// Should the stable step be found anew?
  bool due() const { return stale && !(total <= allowed); }
  /// The stable step was found anew: the sums begin again; what is allowed follows from the effect of the change.
  /// @param[in] before, after stable steps [T]
  void done(double before, double after);
};
} // namespace dolfinx_impact::integrators
