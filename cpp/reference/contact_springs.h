// SPDX-License-Identifier: MIT
#pragma once
#include "contact_surface.h"
#include <algorithm>
#include <cmath>

/// What penalty springs of explicit runs are made of (docs/explicit/penalty.md).
namespace impact_reference
{
/// Mean penetration over the gaps from g - |r| / 2 to g + |r| / 2.
inline double overlap(double g, double r)
{
  const double half = std::abs(r) / 2;
  if (g >= half)
    return 0;
  if (g <= -half)
    return -g;
  return (half - g) * (half - g) / (4 * half);
}

/// The part below zero of the gaps from g - r to g.
inline double part_below(double g, double r)
{
  if (r == 0)
    return g < 0 ? 1 : 0;
  return std::clamp(-std::min(g, g - r) / std::abs(r), 0.0, 1.0);
}

/// The largest normal force up to k delta without energy deficit, or the one with the smallest deficit.
/// @param a what the node has beyond this force's own work, stored the part of it that the spring held
/// @param gap, change of the gap, now and in the step that has led here
inline double normal_force(double k, double delta, double gap, double change, double a, double stored)
{
  double force = k * delta;
  if (a - force * (change + force / k) / 2 < -1e-12 * (stored + k * delta * delta))
  {
    const double root = std::sqrt(std::max(0.0, change * change / 4 + 2 * a / k));
    force = std::clamp(k * (root - change / 2), 0.0, k * delta);
  }
  // Would the node be open in the next step, with the same motion, nothing were stored and the force worked on all the
  // way.
  if (change > 0 and gap + change > 0)
    force = std::min(force, std::max(0.0, a / change));
  return force;
}

inline Vec<double> cut_to(const Vec<double>& t, double bound)
{
  const double size = norm(t);
  return size > bound ? (bound / size) * t : t;
}

/// What friction keeps of its stored energy and of the work of the force at the step's start, b, less the part of the
/// force t at its end.
inline double tangential_change(const Vec<double>& t, double k, const Vec<double>& across, double b)
{
  return b - dot(t, across) / 2 - dot(t, t) / (2 * k);
}
} // namespace impact_reference
