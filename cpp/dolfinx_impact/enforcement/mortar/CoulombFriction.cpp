// SPDX-License-Identifier: MIT
#include "CoulombFriction.h"
#include "../../common/vectors.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Springs that bring slips along driven directions to zero, per stiffness of the bodies: what is left of a slip in one
/// linear solution.
constexpr double driven_stiffness = 1e3;
/// Least part of a prescribed axis along the surface.
constexpr double least_axis = 1e-3;
/// Part of a traction within which it has not changed.
constexpr double unchanged = 1e-10;
/// Bound of a turning traction's stiffness, per stiffness of the bodies.
constexpr double stiffest = 1e3;

double norm(int gdim, const double* a)
{
  return std::sqrt(dot(a, a, gdim));
}

/// out = A x of one node.
void apply(int gdim, const double* A, const double* x, double* out)
{
  for (int a = 0; a < gdim; ++a)
    out[a] = dot(A + a * gdim, x, gdim);
}
} // namespace

CoulombFriction::CoulombFriction(int gdim, std::size_t num_nodes)
    : imposed(num_nodes * gdim, 0.0), _gdim(gdim), _num(num_nodes), _locked(num_nodes * gdim * gdim, 0.0),
      _driven(_locked), _is_driven(num_nodes, 0), _spring(_locked), _driving(_locked), _slack(imposed)
{
}

void CoulombFriction::update_directions(std::span<const std::int8_t> usable, const NodalGeometry& geometry,
                                        std::span<const std::int8_t> locked)
{
  const int g = _gdim;
  if (usable.size() != _num || geometry.normal.size() != _num * g || geometry.fixed.size() != _num * g ||
      geometry.frames.place.size() != _num || locked.size() != _num * g || imposed.size() != _num * g)
    throw std::invalid_argument("the arrays of a contact's nodes differ in their numbers");
  _has_springs = false;
  std::fill(_locked.begin(), _locked.end(), 0.0);
  std::fill(_driven.begin(), _driven.end(), 0.0);
  std::fill(_is_driven.begin(), _is_driven.end(), std::int8_t(0));
  for (std::size_t i = 0; i < _num; ++i)
  {
    const std::int8_t* fixed = &geometry.fixed[i * g];
    double* traction = &imposed[i * g];
    if (!usable[i] || std::none_of(fixed, fixed + g, [](std::int8_t f) { return f; }))
    {
      std::fill_n(traction, g, 0.0);
      continue;
    }
    const double *normal = &geometry.normal[i * g], *frame = &geometry.frames.frames[i * g * g];
    double *lock = &_locked[i * g * g], *drive = &_driven[i * g * g];
    double plane[9];
    for (int a = 0; a < g; ++a)
      for (int b = 0; b < g; ++b)
        plane[a * g + b] = (a == b ? 1.0 : 0.0) - normal[a] * normal[b];
    // Prescribed axes along the surface, orthonormalised in their order.
    for (int c = 0; c < g; ++c)
    {
      if (!locked[i * g + c])
        continue;
      double axis[3], part[3], column[3];
      for (int a = 0; a < g; ++a)
        column[a] = plane[a * g + c];
      apply(g, lock, column, part);
      for (int a = 0; a < g; ++a)
        axis[a] = column[a] - part[a];
      const double length = norm(g, axis);
      if (!(length > least_axis))
        continue;
      for (int a = 0; a < g; ++a)
        axis[a] /= length;
      for (int a = 0; a < g; ++a)
        for (int b = 0; b < g; ++b)
          lock[a * g + b] += axis[a] * axis[b];
    }
    double trace = 0.0;
    for (int a = 0; a < g; ++a)
    {
      for (int b = 0; b < g; ++b)
      {
        double free = 0.0;
        for (int d = 0; d < g; ++d)
          free += !fixed[d] && d != geometry.frames.place[i] ? frame[a * g + d] * frame[b * g + d] : 0.0;
        drive[a * g + b] = plane[a * g + b] - free - lock[a * g + b];
      }
      trace += drive[a * g + a];
    }
    if (trace < 0.5) // round-off: no direction is left
      std::fill_n(drive, g * g, 0.0);
    else
      _is_driven[i] = 1;
    // Tractions known from before follow the surface.
    double part[3], other[3];
    apply(g, lock, traction, part);
    apply(g, drive, traction, other);
    for (int a = 0; a < g; ++a)
      part[a] += other[a];
    const double size = norm(g, traction), length = norm(g, part);
    for (int a = 0; a < g; ++a)
      traction[a] = length > 0.0 ? part[a] * (size / length) : 0.0;
  }
}

void CoulombFriction::set_edges(std::vector<double> projectors)
{
  if (!projectors.empty() && projectors.size() != _locked.size())
    throw std::invalid_argument("a projector of every node is needed");
  _edges = std::move(projectors);
}

/// Projector of a node on directions in which nothing slips.
std::array<double, 9> CoulombFriction::without_slip(std::size_t i) const
{
  const std::size_t size = _gdim * _gdim;
  std::array<double, 9> out{};
  for (std::size_t k = 0; k < size; ++k)
    out[k] = _locked[i * size + k] + (_edges.empty() ? 0.0 : _edges[i * size + k]);
  return out;
}

std::vector<double> CoulombFriction::prescribed() const
{
  std::vector<double> out(_locked);
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] += _driven[k];
  return out;
}

std::vector<std::int8_t> CoulombFriction::update_imposed(const NodalMultipliers& now,
                                                         std::span<const std::int8_t> was_stuck,
                                                         std::span<const double> traction_n)
{
  check_sizes(now);
  const int g = _gdim;
  if (now.size() != _num || was_stuck.size() != _num || traction_n.size() != _num * g)
    throw std::invalid_argument("the arrays of a contact's nodes differ in their numbers");
  std::vector<std::int8_t> changed(_num, 0);
  for (std::size_t i = 0; i < _num; ++i)
  {
    const bool stuck = sticks(now, i);
    const double *lock = &_locked[i * g * g], *traction = &now.traction[i * g];
    double driven[3]{}, kept[3], rest[3], before[3], along[3];
    if (stuck)
      apply(g, &_driven[i * g * g], was_stuck[i] ? &imposed[i * g] : traction, driven);
    apply(g, lock, &traction_n[i * g], kept);
    apply(g, lock, traction, along);
    apply(g, lock, &imposed[i * g], before);
    for (int a = 0; a < g; ++a)
      rest[a] = traction[a] - along[a];
    const double bound = now.coefficient(i) * std::max(now.multiplier[i], 0.0);
    const double room = std::sqrt(std::max(0.0, bound * bound - dot(rest, rest, g))), size = norm(g, kept);
    const double part = stuck && size > 0.0 ? std::min(room, size) / size : 0.0;
    double change[3];
    for (int a = 0; a < g; ++a)
    {
      kept[a] *= part;
      change[a] = kept[a] - before[a];
      imposed[i * g + a] = driven[a] + kept[a];
    }
    changed[i] = norm(g, change) > unchanged * std::max(bound, size);
  }
  return changed;
}

CoulombFriction::Springs CoulombFriction::update_springs(const NodalMultipliers& now, const NodalGeometry& geometry,
                                                         std::span<const double> slave_stiffness,
                                                         std::span<const double> master_stiffness)
{
  check_sizes(now);
  const int g = _gdim;
  if (now.size() != _num || geometry.slip.size() != _num * g || slave_stiffness.size() != _num ||
      master_stiffness.size() != _num)
    throw std::invalid_argument("the arrays of a contact's nodes differ in their numbers");
  _has_springs = true;
  std::fill(_spring.begin(), _spring.end(), 0.0);
  std::fill(_driving.begin(), _driving.end(), 0.0);
  std::fill(_slack.begin(), _slack.end(), 0.0);
  Springs out;
  out.traction.resize(_num * g);
  for (std::size_t i = 0; i < _num; ++i)
  {
    const bool on = now.active[i] && now.usable[i];
    const bool grip = grips(now, i), slide = g == 3 && on && now.sliding[i], drive = sticks(now, i) && _is_driven[i];
    const std::array<double, 9> still = without_slip(i);
    const double *lock = still.data(), *normal = &geometry.normal[i * g];
    double *spring = &_spring[i * g * g], *driving = &_driving[i * g * g], *slack = &_slack[i * g];
    double part[3], here[3];
    if (grip || slide || drive)
    {
      const double pressure = std::max(now.multiplier[i], 0.0), *direction = &now.direction[i * g];
      double slip[3];
      apply(g, lock, &now.slip[i * g], part);
      for (int a = 0; a < g; ++a)
        slip[a] = now.slip[i * g + a] - part[a];
      const double turning =
          std::min(now.coefficient(i) * pressure / std::max(norm(g, slip), 1e-300), stiffest * now.stiffness[i]);
      const double factor = grip ? pressure / now.opening[i] : turning;
      for (int a = 0; a < g && !drive; ++a)
        for (int b = 0; b < g; ++b)
        {
          const double plane = (a == b ? 1.0 : 0.0) - normal[a] * normal[b] - lock[a * g + b];
          spring[a * g + b] = factor * (grip ? plane : plane - direction[a] * direction[b]);
        }
      if (grip)
        std::copy_n(slip, g, slack);
      if (drive)
      {
        const double stiffness =
            driven_stiffness * std::max(slave_stiffness[i], master_stiffness[i]) / geometry.weight[i];
        for (int k = 0; k < g * g; ++k)
          driving[k] = stiffness * _driven[i * g * g + k];
      }
      // Forces go with the diagonal of D, slips are means over the cover.
      const double area = geometry.weight[i] * geometry.weight[i] / geometry.cover[i];
      out.rows.push_back(std::int32_t(i));
      for (int k = 0; k < g * g; ++k)
        out.blocks.push_back(area * (spring[k] + driving[k]));
    }
    // Tractions of the springs in the state that is linearised about.
    apply(g, lock, &geometry.slip[i * g], part);
    for (int a = 0; a < g; ++a)
      here[a] = geometry.slip[i * g + a] - part[a];
    double stretch[3], stretched[3], driven[3];
    for (int a = 0; a < g; ++a)
      stretch[a] = here[a] - slack[a];
    apply(g, spring, stretch, stretched);
    apply(g, driving, here, driven);
    for (int a = 0; a < g; ++a)
      out.traction[i * g + a] = stretched[a] + (driven[a] - imposed[i * g + a]);
  }
  return out;
}

void CoulombFriction::raise_imposed(const NodalMultipliers& now)
{
  check_sizes(now);
  for (std::size_t i = 0; i < now.size(); ++i)
  {
    if (!sticks(now, i) || !_is_driven[i])
      continue;
    double raised[3];
    apply(_gdim, &_driving[i * _gdim * _gdim], &now.slip[i * _gdim], raised);
    for (int a = 0; a < _gdim; ++a)
      imposed[i * _gdim + a] -= raised[a];
  }
}

std::vector<double> CoulombFriction::known_tractions(const NodalMultipliers& now) const
{
  std::vector<double> out(imposed);
  if (!_has_springs)
    return out;
  check_sizes(now);
  const int g = _gdim;
  for (std::size_t i = 0; i < now.size(); ++i)
  {
    double part[3], stretch[3], traction[3];
    apply(g, without_slip(i).data(), &now.slip[i * g], part);
    for (int a = 0; a < g; ++a)
      stretch[a] = now.slip[i * g + a] - part[a] - _slack[i * g + a];
    apply(g, &_spring[i * g * g], stretch, traction);
    for (int a = 0; a < g; ++a)
      out[i * g + a] -= traction[a];
  }
  return out;
}
} // namespace dolfinx_impact::enforcement
