// SPDX-License-Identifier: MIT
#pragma once
#include <algorithm>
#include <cmath>

/// Springs of explicit penalty contact that never give back more than they took (docs/explicit/penalty.md, "Energy of
/// the springs").
namespace dolfinx_impact::enforcement
{
/// The spring of a slave node after the last step. All zero: it was open and owes nothing.
struct Spring
{
  double force = 0.0;      ///< along the normal [F]
  double compliance = 0.0; ///< reciprocal of the stiffness [L/F]
  double gap = 0.0;        ///< [L]
  double surplus = 0.0;    ///< taken from the bodies by the normal force beyond what is stored; negative: owed [F L]
  double tangential_surplus = 0.0; ///< owed by friction, never positive [F L]

  double stored() const { return 0.5 * force * force * compliance; }
};

/// A deficit below this part of the node's energies is round-off.
constexpr double round_off = 1e-12;

/// The normal force of a step, and the surplus that it leaves.
/// @param[in,out] spring of the last step, then of this one
/// @param[in] wanted the force of the law, k times the overlap [F]
/// @param[in] k,per_k stiffness and its reciprocal [F/L]
/// @param[in] gap now; change: in the step [L]
/// @param[in] begins was it open?
/// @returns what the normal force has dissipated in the step, negative if it has given energy to the bodies [F L]
inline double normal_step(Spring& spring, double wanted, double k, double per_k, double gap, double change, bool begins)
{
  // What is at hand after half of the step with the last force. A node that begins below the surface is given what its
  // spring would have stored there.
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
  // It opens in the next step if it goes on like this: both halves of the force's work, nothing is left stored.
  if (change > 0.0 && gap + change > 0.0 && force * change > at_hand)
    force = std::max(0.0, at_hand / change);
  const double last = spring.surplus;
  spring = {force, per_k, gap, left(force), spring.tangential_surplus};
  return spring.surplus - last;
}

/// The node has opened: what is left over is lost, what it owes it keeps.
/// @param[in] change of the gap in the step [L]
/// @returns dissipated by the normal force in the step [F L]
inline double normal_release(Spring& spring, double change)
{
  const double last = spring.surplus, left = last + spring.stored() - 0.5 * spring.force * change;
  spring.force = 0.0;
  spring.surplus = std::min(left, 0.0);
  return left - last;
}

/// @param[in] taken from the bodies by friction as the node opens
/// @returns the same
inline double tangential_release(Spring& spring, double taken)
{
  spring.tangential_surplus = std::min(0.0, spring.tangential_surplus + taken);
  return taken;
}

/// Friction that gives energy to the bodies is brought back to where it takes some, and the debt that it leaves.
/// @param[in,out] owed tangential surplus
/// @param[in] turned tangential force of the last step, in the present plane [F]
/// @param[in] stored by it [F L]
/// @param[in] motion tangential, in the step [L]
/// @param[in] limit of friction [F]
/// @param[in,out] t tangential force of the step [F]
/// @param[out] changed is t another one?
/// @returns dissipated in the step [F L]
template <int D>
double tangential_step(double& owed, const double* turned, double stored, const double* motion, double k, double per_k,
                       double limit, double* t, bool& changed)
{
  const auto dot = [](const double* a, const double* b)
  {
    double sum = 0.0;
    for (int c = 0; c < D; ++c)
      sum += a[c] * b[c];
    return sum;
  };
  const double at_hand = stored - 0.5 * dot(turned, motion);
  double squared = dot(t, t), taken = at_hand - 0.5 * (dot(t, motion) + squared * per_k);
  changed = owed + taken < -round_off * (stored + squared * per_k);
  if (changed)
  {
    // Forces that leave no debt: a ball about -k/2 times the motion.
    const double reach = 0.25 * k * k * dot(motion, motion) + 2.0 * k * (owed + at_hand);
    double away = 0.0;
    for (int c = 0; c < D; ++c)
      away += (t[c] + 0.5 * k * motion[c]) * (t[c] + 0.5 * k * motion[c]);
    const double factor = reach > 0.0 ? std::min(1.0, std::sqrt(reach / away)) : 0.0;
    squared = 0.0;
    for (int c = 0; c < D; ++c)
    {
      t[c] = factor * t[c] - (1.0 - factor) * 0.5 * k * motion[c];
      squared += t[c] * t[c];
    }
    const double cut = squared > limit * limit ? limit / std::sqrt(squared) : 1.0;
    for (int c = 0; c < D; ++c)
      t[c] *= cut;
    taken = at_hand - 0.5 * (dot(t, motion) + cut * cut * squared * per_k);
  }
  owed = std::min(0.0, owed + taken);
  return taken;
}
} // namespace dolfinx_impact::enforcement
