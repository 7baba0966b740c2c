// SPDX-License-Identifier: MIT
#pragma once
#include <algorithm>
#include <cmath>

/// Springs of explicit penalty contact that never return more energy than they absorbed (docs/explicit/penalty.md,
/// "Energy of the springs").
namespace dolfinx_impact::enforcement
{
/// Spring of a slave node after the last step. All zero: the node was open and has no energy deficit.
struct Spring
{
  double force = 0.0;              ///< along the normal [F]
  double compliance = 0.0;         ///< reciprocal of the stiffness [L/F]
  double gap = 0.0;                ///< [L]
  double surplus = 0.0;            ///< energy absorbed by the normal force minus energy stored; negative: deficit [F L]
  double tangential_surplus = 0.0; ///< energy deficit of friction, never positive [F L]
  double offset = 0.0;             ///< added to the gap until the node is open without it: a start under load [L]

  double stored() const { return 0.5 * force * force * compliance; }
};

/// A deficit below this part of the node's energies is round-off.
constexpr double round_off = 1e-12;

/// Normal force of a step, and the energy surplus that it leaves.
/// @param[in,out] spring of the last step, then of this one
/// @param[in] wanted force of the penalty law, k times the overlap [F]
/// @param[in] k,per_k stiffness and its reciprocal [F/L]
/// @param[in] gap now; change: in the step [L]
/// @param[in] begins true if the node was open
/// @returns energy dissipated by the normal force in the step; negative if the bodies received energy [F L]
inline double normal_step(Spring& spring, double wanted, double k, double per_k, double gap, double change, bool begins)
{
  // Energy available after half of the step with the last force. A node that begins below the surface starts with the
  // energy that its spring would have stored there.
  const double before = std::max(0.0, change - gap);
  const double stored = begins ? 0.5 * k * before * before : spring.stored();
  const double at_hand = spring.surplus + stored - (begins ? 0.0 : 0.5 * spring.force * change);
  const auto left = [&](double force) { return at_hand - 0.5 * force * (change + force * per_k); };
  double force = wanted;
  if (left(force) < -round_off * (stored + force * force * per_k))
  {
    const double root = 0.25 * change * change + 2.0 * at_hand * per_k;
    force = std::clamp(k * ((root > 0.0 ? std::sqrt(root) : 0.0) - 0.5 * change), 0.0, wanted);
  }
  // The node opens in the next step at this velocity: both halves of the force's work count and no energy stays stored.
  if (change > 0.0 && gap + change > 0.0 && force * change > at_hand)
    force = std::max(0.0, at_hand / change);
  const double last = spring.surplus;
  spring = {force, per_k, gap, left(force), spring.tangential_surplus, spring.offset};
  return spring.surplus - last;
}

/// Opens the spring: a surplus is dissipated, a deficit is kept.
/// @param[in] change of the gap in the step [L]
/// @returns dissipated by the normal force in the step [F L]
inline double normal_release(Spring& spring, double change)
{
  const double last = spring.surplus, left = last + spring.stored() - 0.5 * spring.force * change;
  spring.force = 0.0;
  spring.surplus = std::min(left, 0.0);
  return left - last;
}

/// Friction's part of opening.
/// @param[in] taken energy absorbed by friction when the node opens [F L]
/// @returns `taken`
inline double tangential_release(Spring& spring, double taken)
{
  spring.tangential_surplus = std::min(0.0, spring.tangential_surplus + taken);
  return taken;
}

/// Corrects a tangential force that would give energy to the bodies, and updates the deficit of friction.
/// @param[in,out] owed tangential surplus [F L]
/// @param[in] turned tangential force of the last step, rotated into the present tangent plane [F]
/// @param[in] stored energy of this force in the spring [F L]
/// @param[in] motion tangential increment of the step [L]
/// @param[in] limit friction coefficient times normal force [F]
/// @param[in,out] t tangential force of the step [F]
/// @param[out] changed true if t was corrected
/// @returns dissipated in the step [F L]
template <int D>
double tangential_step(double& owed, const double* turned, double stored, const double* motion, double k, double per_k,
                       double limit, double* t, bool& changed)
{
  const auto dot = [](const double* a, const double* b)
  {
    double sum = 0.0;
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
      sum += a[c] * b[c];
    return sum;
  };
  const double at_hand = stored - 0.5 * dot(turned, motion);
  double squared = dot(t, t), taken = at_hand - 0.5 * (dot(t, motion) + squared * per_k);
  changed = owed + taken < -round_off * (stored + squared * per_k);
  if (changed)
  {
    // Forces without deficit lie in a ball about -k/2 times the motion.
    const double reach = 0.25 * k * k * dot(motion, motion) + 2.0 * k * (owed + at_hand);
    double away = 0.0;
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
      away += (t[c] + 0.5 * k * motion[c]) * (t[c] + 0.5 * k * motion[c]);
    const double factor = reach > 0.0 ? std::min(1.0, std::sqrt(reach / away)) : 0.0;
    squared = 0.0;
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
    {
      t[c] = factor * t[c] - (1.0 - factor) * 0.5 * k * motion[c];
      squared += t[c] * t[c];
    }
    const double cut = squared > limit * limit ? limit / std::sqrt(squared) : 1.0;
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
      t[c] *= cut;
    taken = at_hand - 0.5 * (dot(t, motion) + cut * cut * squared * per_k);
  }
  owed = std::min(0.0, owed + taken);
  return taken;
}
} // namespace dolfinx_impact::enforcement
