// SPDX-License-Identifier: MIT
#pragma once
#include "../ContactStatus.h"
#include "../friction.h"
#include "../node_to_surface/NodalContact.h"
#include "../node_to_surface/overlap.h"
#include "../node_to_surface/spring.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::enforcement
{
/// Relative motion of two points of surfaces that may touch, in a step; normal and tangential parts.
struct PairMotion
{
  const double* normal; ///< unit, from the second point's body outward
  double gap;           ///< now, positive if open [L]
  double closing;       ///< increment of the gap by the motion of the step [L]
  const double* motion; ///< increment of the first point relative to the second one's body, which turns [L]
  const double* last;   ///< the same of the points at which the force of the last step acts, without the turn [L]
  double turn_work;     ///< work in this step of the moment correction of that force [F L]
};

/// What a spring does in a step.
struct PairForce
{
  double force[3] = {}; ///< on the first point; the second one gets the opposite [F]
  double slip[3] = {};  ///< added to the slip [L]
  double tangential_squared = 0.0;
  ContactStatus status = ContactStatus::open;
};

/// Spring between two points of surfaces, with Coulomb's friction, and its history; docs/explicit/penalty.md.
struct PairSpring
{
  Spring spring;
  double tangential[3] = {}; ///< force on the first point [F]
  double normal[3] = {};     ///< of the last step, while it is closed [1]
  bool closed = false;

  /// An open pair whose points are behind each other already came there from beside, or beyond an edge: its spring
  /// begins without force where they were before this step, as nothing has been done to press it. Bodies that overlap
  /// at the start of a run are pushed apart.
  /// @param[in] gap now; closing: its increment by the motion of the step [L]
  void begin_at_rest(double gap, double closing, bool start)
  {
    if (!closed)
      spring.offset = start ? 0.0 : std::max(0.0, closing - gap);
  }
  /// Force of a step; opens and closes the spring.
  /// @param[in] k stiffness [F/L]
  /// @param[in] friction coefficient [1]
  /// @param[in,out] energy of the contact
  template <int D>
  PairForce advance(const PairMotion& at, double k, double friction, ContactEnergy& energy);
  /// The points part: half of the last force's work is done in this step.
  template <int D>
  void release(const PairMotion& at, ContactEnergy& energy);
  /// The pair is given up although its gap did not open: what is stored is dissipated.
  /// @param[in] last, turn_work as in PairMotion; null: not known
  template <int D>
  void drop(const double* last, double turn_work, ContactEnergy& energy);
};

template <int D>
void PairSpring::release(const PairMotion& at, ContactEnergy& energy)
{
  double change = 0.0, squared = 0.0, work = 0.0;
  for (int c = 0; c < D; ++c)
  {
    change += normal[c] * at.last[c];
    squared += tangential[c] * tangential[c];
    work += tangential[c] * at.last[c];
    tangential[c] = 0.0;
  }
  work += at.turn_work;
  energy.normal -= normal_release(spring, change);
  energy.friction += tangential_release(spring, 0.5 * squared * spring.compliance - 0.5 * work);
  closed = false;
}

template <int D>
void PairSpring::drop(const double* last, double turn_work, ContactEnergy& energy)
{
  double change = 0.0, squared = 0.0, work = turn_work;
  for (int c = 0; c < D; ++c)
  {
    change += last ? normal[c] * last[c] : 0.0;
    work += last ? tangential[c] * last[c] : 0.0;
    squared += tangential[c] * tangential[c];
  }
  energy.normal -= normal_release(spring, change);
  energy.friction += tangential_release(spring, 0.5 * squared * spring.compliance - 0.5 * work);
  std::fill_n(tangential, 3, 0.0);
  closed = false;
}

template <int D>
PairForce PairSpring::advance(const PairMotion& at, double k, double friction, ContactEnergy& energy)
{
  PairForce out;
  const double* n = at.normal;
  const double r = at.closing, overlap = mean_overlap(at.gap, r), per_k = 1.0 / k;
  if (!(overlap > 0.0))
  {
    if (closed)
      release<D>(at, energy);
    return out;
  }
  if (closed)
  {
    // The last force has done half of its work in this step, along its own normal.
    double along = 0.0;
    for (int c = 0; c < D; ++c)
      along += normal[c] * at.last[c];
    const double more = 0.5 * spring.force * (along - r);
    spring.surplus -= more;
    energy.normal += more;
  }
  const double last_compliance = spring.compliance;
  energy.normal -= normal_step(spring, k * overlap, k, per_k, at.gap, r, !closed);
  for (int c = 0; c < D; ++c)
    out.force[c] = spring.force * n[c];
  out.status = ContactStatus::slip;
  if (friction > 0.0)
  {
    const double part = part_below(at.gap, r), limit = friction * spring.force;
    double trial[D], turned[D], motion[D], stored = 0.0, more = 0.5 * at.turn_work;
    for (int c = 0; c < D; ++c)
    {
      more += 0.5 * tangential[c] * at.last[c];
      stored += 0.5 * tangential[c] * tangential[c] * last_compliance;
      motion[c] = at.motion[c] - r * n[c];
      out.slip[c] = part * motion[c];
    }
    bool changed = false;
    const bool slips = coulomb<D>(n, k, per_k, limit, tangential, out.slip, trial);
    for (int c = 0; c < D; ++c)
    {
      turned[c] = trial[c] + k * part * motion[c];
      more -= 0.5 * turned[c] * motion[c];
    }
    spring.tangential_surplus -= more;
    energy.friction -= more;
    energy.friction +=
        tangential_step<D>(spring.tangential_surplus, turned, stored, motion, k, per_k, limit, tangential, changed);
    for (int c = 0; c < D; ++c)
    {
      if (changed)
        out.slip[c] = part * motion[c] + (tangential[c] - turned[c]) * per_k;
      out.tangential_squared += tangential[c] * tangential[c];
      out.force[c] += tangential[c];
    }
    if (!slips && !changed)
      out.status = ContactStatus::stick;
  }
  closed = true;
  std::copy_n(n, D, normal);
  energy.stored += spring.stored() + 0.5 * out.tangential_squared * per_k;
  return out;
}
} // namespace dolfinx_impact::enforcement
