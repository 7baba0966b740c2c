// SPDX-License-Identifier: MIT
#include "active_set.h"
#include "../../common/vectors.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Friction bounds that a trial traction is beyond where rest is out of the question.
constexpr double far = 1e3;
/// Least part of a node's normal and friction traction along its constrained direction.
constexpr double least_lean = 1e-3;

} // namespace

void check_sizes(const NodalMultipliers& now)
{
  const std::size_t n = now.size(), vector = n * now.gdim;
  const bool friction = now.friction > 0.0;
  if (now.usable.size() != n || now.gap.size() != n || now.multiplier.size() != n ||
      (friction && (now.sliding.size() != n || now.slip.size() != vector || now.traction.size() != vector ||
                    now.direction.size() != vector || now.opening.size() != n || now.stiffness.size() != n)) ||
      (!now.lock.empty() && now.lock.size() != vector * now.gdim) ||
      (!now.roughness.empty() && now.roughness.size() != n))
    throw std::invalid_argument("the arrays of a contact's nodes differ in their numbers");
}

bool sticks(const NodalMultipliers& now, std::size_t i)
{
  return now.active[i] && now.usable[i] && !now.sliding[i] && now.opening[i] == 0.0;
}

bool grips(const NodalMultipliers& now, std::size_t i)
{
  return now.active[i] && now.usable[i] && !now.sliding[i] && now.opening[i] > 0.0;
}

namespace
{
/// A slip or traction less its part along locked directions.
void unlocked(const NodalMultipliers& now, std::size_t i, const double* values, double* out)
{
  const int g = now.gdim;
  for (int a = 0; a < g; ++a)
    out[a] = values[i * g + a] - (now.lock.empty() ? 0.0 : dot(&now.lock[(i * g + a) * g], &values[i * g], g));
}

/// Traction that friction would have if it held the node, up to a factor beyond the bound.
void trial_traction(const NodalMultipliers& now, std::size_t i, double bound, bool moving, double* trial)
{
  const int g = now.gdim;
  double slip[3], traction[3];
  unlocked(now, i, now.slip.data(), slip);
  unlocked(now, i, now.traction.data(), traction);
  // Closed in this step, from a gap: t = -p s / gap, see docs/contact.md.
  const bool fresh = now.opening[i] > 0.0;
  const double rate = fresh && bound > 0.0 ? bound / (now.coefficient(i) * now.opening[i]) : 0.0;
  for (int c = 0; c < g; ++c)
    trial[c] = fresh ? -rate * slip[c] : traction[c] - now.stiffness[i] * (moving ? slip[c] : 0.0);
}

/// Part of normal and friction traction, per pressure, along the constrained direction: friction along prescribed
/// components of a surface that is inclined to them presses, or lifts, the node.
double lean(int gdim, const NodalFrames& frames, std::size_t i, const double* tilt)
{
  double along = frames.length[i];
  for (int a = 0; a < gdim && frames.place[i] >= 0; ++a)
    along += frames.frames[(i * gdim + a) * gdim + frames.place[i]] * tilt[a];
  return std::max(along, least_lean);
}
} // namespace

ActiveSet update_active_set(const NodalMultipliers& now, bool first, double tolerance, double largest)
{
  check_sizes(now);
  const int g = now.gdim;
  const std::size_t num = now.size();
  ActiveSet out{{now.active.begin(), now.active.end()},
                {now.sliding.begin(), now.sliding.end()},
                {now.direction.begin(), now.direction.end()}};
  out.sliding.resize(num, 0);
  for (std::size_t i = 0; i < num; ++i)
  {
    const bool active = now.active[i];
    const bool closing = !active && now.usable[i] && now.gap[i] < (first ? tolerance : -tolerance);
    const bool opening = active && (!now.usable[i] || (!first && now.multiplier[i] < -1e-12 * largest));
    if (now.friction == 0.0 || first)
    {
      out.active[i] = (active || closing) && !opening;
      out.sliding[i] = out.sliding[i] && out.active[i];
      continue;
    }
    // Of a node that closes the pressure that its overlap would call for: it has no multiplier yet.
    const double overlap = now.stiffness[i] * (closing ? std::min(now.gap[i], 0.0) : 0.0);
    const double bound = now.coefficient(i) * std::max(now.multiplier[i] - overlap, 0.0);
    const bool sliding = now.sliding[i];
    double trial[3];
    trial_traction(now, i, bound, sliding || closing, trial);
    const double size = std::sqrt(dot(trial, trial, g));
    // A node that sticks is let slip before it is let go: what holds it along the surface may pull it off.
    out.active[i] = (active || closing) && !(opening && !(sticks(now, i) && size > 0.0));
    const bool held = (out.active[i] && active) || closing;
    // At the bound of friction round-off must not decide whether a node slips: one that slips continues to slip.
    bool slips = held && (size > bound * (sliding ? 1 - 1e-8 : 1 + 1e-10) || now.coefficient(i) == 0.0);
    // What slipped and would now slip the other way, but not far, comes to rest first, or it might go to and fro.
    const bool back = dot(trial, &now.direction[i * g], g) < 0.0;
    slips = slips && !(sliding && back && size < far * bound);
    out.sliding[i] = slips;
    for (int c = 0; c < g && slips; ++c)
      out.direction[i * g + c] = trial[c] / std::max(size, 1e-300);
  }
  return out;
}

std::vector<double> friction_tilt(const NodalMultipliers& now)
{
  check_sizes(now);
  const int g = now.gdim;
  std::vector<double> tilt(now.size() * g, 0.0);
  for (std::size_t i = 0; i < now.size() && now.friction > 0.0; ++i)
  {
    double slip[3];
    unlocked(now, i, now.slip.data(), slip);
    const bool closed_now = grips(now, i);
    for (int c = 0; c < g; ++c)
      tilt[i * g + c] = closed_now       ? -slip[c] / now.opening[i]
                        : now.sliding[i] ? now.coefficient(i) * now.direction[i * g + c]
                                         : 0.0;
  }
  return tilt;
}

std::vector<std::int32_t> constrained_nodes(const NodalMultipliers& now)
{
  std::vector<std::int32_t> rows;
  for (std::size_t i = 0; i < now.size(); ++i)
    if (now.active[i] && now.usable[i])
      rows.push_back(std::int32_t(i));
  return rows;
}

Constraints constrain(const NodalMultipliers& now, const NodalGeometry& geometry, std::span<const double> tilt,
                      gap::MasterRows facing)
{
  check_sizes(now);
  const int g = now.gdim;
  Constraints out;
  out.gdim = g;
  out.rows = constrained_nodes(now);
  if (facing.pointers.size() != out.rows.size() + 1 || tilt.size() != now.size() * g)
    throw std::invalid_argument("a row of the master's nodes for every active node, and a tilt for every node");
  out.pointers = std::move(facing.pointers);
  out.columns = std::move(facing.columns);
  out.values = std::move(facing.values);
  for (std::size_t i : out.rows)
  {
    const std::int32_t place = geometry.frames.place[i];
    const double length = geometry.frames.length[i], *frame = &geometry.frames.frames[i * g * g];
    const double *normal = &geometry.normal[i * g], *slant = &tilt[i * g];
    const bool stick = now.friction > 0.0 && !now.sliding[i] && now.opening[i] == 0.0;
    // Gaps and slips are means over the cover, rows of D^-1 M speak of the node.
    const double spread = geometry.cover[i] / geometry.weight[i];
    const double ahead = geometry.ahead.empty() ? 0.0 : dot(normal, &geometry.ahead[i * g], g);
    const double leans = lean(g, geometry.frames, i, slant);
    out.nodes.push_back(geometry.nodes[i]);
    out.normal.push_back(place);
    for (int a = 0; a < g; ++a)
    {
      for (int d = 0; d < g; ++d)
      {
        out.frames.push_back(frame[a * g + d]);
        out.over.push_back(d == place ? normal[a] / length : frame[a * g + d]);
      }
      out.tilt.push_back((normal[a] + slant[a]) / leans - normal[a] / length);
    }
    for (int d = 0; d < g; ++d)
    {
      double slip = 0.0;
      for (int a = 0; a < g && !geometry.slip.empty(); ++a)
        slip += frame[a * g + d] * geometry.slip[i * g + a];
      out.constrained.push_back(d == place || (stick && !(geometry.fixed.size() && geometry.fixed[i * g + d])));
      out.known.push_back(d == place ? -(spread * geometry.gap[i] + ahead) / length : -spread * slip);
    }
  }
  return out;
}

void evaluate_multipliers(const NodalMultipliers& now, const NodalGeometry& geometry, std::span<const double> residual,
                          std::span<const double> tilt, std::span<const double> known, std::span<const double> follow,
                          std::span<double> multiplier, std::span<double> traction)
{
  check_sizes(now);
  const int g = now.gdim;
  const bool friction = now.friction > 0.0;
  if (residual.size() != now.size() * g || multiplier.size() != now.size() ||
      (friction && (traction.size() != now.size() * g || tilt.size() != now.size() * g)))
    throw std::invalid_argument("a residual and a multiplier of every node are needed");
  for (std::size_t i = 0; i < now.size(); ++i)
  {
    const bool on = now.active[i] && now.usable[i];
    multiplier[i] = 0.0;
    if (friction)
      std::fill_n(&traction[i * g], g, 0.0);
    if (!on)
      continue;
    const std::int32_t place = geometry.frames.place[i];
    const double weight = geometry.weight[i], *frame = &geometry.frames.frames[i * g * g];
    double free[3], along = 0.0;
    for (int c = 0; c < g; ++c)
    {
      free[c] = geometry.fixed.size() && geometry.fixed[i * g + c] ? 0.0 : residual[i * g + c];
      along += frame[c * g + place] * free[c];
    }
    if (!friction)
    {
      multiplier[i] = along / (weight * std::max(geometry.frames.length[i], least_lean));
      continue;
    }
    double pressed = along / weight, law[3];
    for (int c = 0; c < g && !known.empty(); ++c)
      pressed -= frame[c * g + place] * known[i * g + c];
    multiplier[i] = pressed / lean(g, geometry.frames, i, &tilt[i * g]);
    // Along prescribed components forces are unknown: there tractions follow from the law.
    for (int c = 0; c < g; ++c)
      law[c] = multiplier[i] * tilt[i * g + c] + (known.empty() ? 0.0 : known[i * g + c]);
    for (int a = 0; a < g; ++a)
      traction[i * g + a] = (free[a] - along * frame[a * g + place]) / weight +
                            (follow.empty() ? 0.0 : dot(&follow[(i * g + a) * g], law, g));
  }
}

void take_multipliers(const NodalMultipliers& now, const NodalGeometry& geometry, std::span<const double> forces,
                      std::span<const double> tilt, std::span<const double> known, std::span<double> multiplier,
                      std::span<double> traction)
{
  check_sizes(now);
  const int g = now.gdim;
  const std::size_t vector = now.size() * g;
  if (forces.size() != vector || tilt.size() != vector || multiplier.size() != now.size() || traction.size() != vector)
    throw std::invalid_argument("a force and a multiplier of every node are needed");
  for (std::size_t i = 0; i < now.size(); ++i)
  {
    multiplier[i] = 0.0;
    std::fill_n(&traction[i * g], g, 0.0);
    if (!now.active[i] || !now.usable[i])
      continue;
    const std::int32_t place = geometry.frames.place[i];
    const double *frame = &geometry.frames.frames[i * g * g], weight = geometry.weight[i];
    double force[3], along = 0.0;
    for (int a = 0; a < g; ++a)
    {
      force[a] = dot(&frame[a * g], &forces[i * g], g);
      along += frame[a * g + place] * force[a];
    }
    multiplier[i] = along / (weight * lean(g, geometry.frames, i, &tilt[i * g]));
    for (int a = 0; a < g; ++a)
      traction[i * g + a] = (force[a] - along * frame[a * g + place]) / weight +
                            (multiplier[i] * tilt[i * g + a] + (known.empty() ? 0.0 : known[i * g + a]));
  }
}

std::vector<double> rotate_friction_traction(const NodalMultipliers& now, std::span<const double> normal)
{
  const int g = now.gdim;
  const std::vector<double> tilt = friction_tilt(now);
  if (now.traction.size() != tilt.size())
    throw std::invalid_argument("a friction traction of every node is needed");
  std::vector<double> out = tangential(g, normal, now.traction);
  for (std::size_t i = 0; i < now.size(); ++i)
  {
    double* t = &out[i * g];
    const double size = std::sqrt(dot(&now.traction[i * g], &now.traction[i * g], g)), length = std::sqrt(dot(t, t, g));
    const bool closed_now = now.friction > 0.0 && grips(now, i);
    for (int c = 0; c < g; ++c)
      t[c] = closed_now ? now.multiplier[i] * tilt[i * g + c] : length > 0.0 ? t[c] * (size / length) : 0.0;
  }
  return out;
}

Violations violations(const NodalMultipliers& now, std::span<const double> gap)
{
  check_sizes(now);
  if (gap.size() != now.size())
    throw std::invalid_argument("a gap of every node is needed");
  Violations out{std::vector<double>(now.size(), 0.0), std::vector<double>(now.size(), 0.0)};
  for (std::size_t i = 0; i < now.size(); ++i)
  {
    if (now.active[i] && now.usable[i])
      out.gap[i] = std::abs(gap[i]);
    if (now.friction > 0.0 && sticks(now, i))
    {
      double slip[3];
      unlocked(now, i, now.slip.data(), slip);
      out.slip[i] = std::sqrt(dot(slip, slip, now.gdim));
    }
  }
  return out;
}

std::vector<double> tangential(int gdim, std::span<const double> normal, std::span<const double> vectors)
{
  if (normal.size() != vectors.size())
    throw std::invalid_argument("a normal for every vector is needed");
  std::vector<double> out(vectors.begin(), vectors.end());
  for (std::size_t i = 0; i < out.size(); i += gdim)
  {
    const double along = dot(&normal[i], &vectors[i], gdim);
    for (int c = 0; c < gdim; ++c)
      out[i + c] -= along * normal[i + c];
  }
  return out;
}

void add_jump(const NodalGeometry& geometry, std::span<const double> jump, std::span<double> gap,
              std::span<double> slip)
{
  const std::size_t num = geometry.gap.size(), g = num > 0 ? jump.size() / num : 0;
  if (gap.size() != num || geometry.normal.size() != jump.size() || geometry.slip.size() != jump.size() ||
      slip.size() != jump.size())
    throw std::invalid_argument("a jump, a gap and a slip of every node are needed");
  const std::vector<double> along = tangential(int(g), geometry.normal, jump);
  for (std::size_t i = 0; i < num; ++i)
    gap[i] = geometry.gap[i] + dot(&geometry.normal[i * g], &jump[i * g], int(g));
  for (std::size_t k = 0; k < slip.size(); ++k)
    slip[k] = geometry.slip[k] + along[k];
}

std::vector<double> normal_tractions(std::span<const std::int8_t> usable, const NodalGeometry& geometry,
                                     std::span<const double> forces)
{
  const std::size_t num = usable.size(), g = num > 0 ? forces.size() / num : 0;
  if (geometry.frames.place.size() != num || geometry.weight.size() != num || geometry.fixed.size() != forces.size())
    throw std::invalid_argument("a force of every node is needed");
  std::vector<double> out(num, 0.0);
  for (std::size_t i = 0; i < num; ++i)
  {
    const std::int32_t place = geometry.frames.place[i];
    if (place < 0)
      continue;
    double along = 0.0;
    for (std::size_t c = 0; c < g; ++c)
      along += geometry.fixed[i * g + c] ? 0.0 : geometry.frames.frames[(i * g + c) * g + place] * forces[i * g + c];
    out[i] = along / ((usable[i] ? geometry.weight[i] : 1.0) * std::max(geometry.frames.length[i], least_lean));
  }
  return out;
}

void add_linearisation_error(const NodalMultipliers& now, const NodalGeometry& geometry, std::span<const double> gap,
                             std::span<const double> slip, std::span<double> gap_at, std::span<double> slip_at)
{
  const std::size_t num = now.size(), g = now.gdim;
  if (gap.size() != num || slip.size() != num * g || gap_at.size() != num || slip_at.size() != num * g)
    throw std::invalid_argument("a gap and a slip of every node are needed");
  const std::vector<double> along = tangential(int(g), geometry.normal, slip);
  for (std::size_t i = 0; i < num; ++i)
  {
    if (!now.usable[i] || !std::isfinite(gap[i]))
      continue;
    gap_at[i] += gap[i] - now.gap[i];
    for (std::size_t c = 0; c < g; ++c)
      slip_at[i * g + c] += along[i * g + c] - now.slip[i * g + c];
  }
}
} // namespace dolfinx_impact::enforcement
