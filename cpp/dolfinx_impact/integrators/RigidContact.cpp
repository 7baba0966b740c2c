// SPDX-License-Identifier: MIT
#include "RigidContact.h"
#include "../common/vectors.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace dolfinx_impact::integrators
{
namespace
{
/// Part of the largest stable stiffness that springs between rigid bodies have. With part = sin^2(pi/14) central
/// differences swing half a period in seven steps of the problem's own: an impact of balls in such steps is reversed
/// exactly, wherever in a step it begins.
constexpr double part_of_limit = 0.049515566048790427;

/// How the point at x of a body has moved in the last step.
void add_increment(const gap::RigidMotion& motion, const gap::Vector3& centre, const double* x, double sign,
                   gap::Vector3& out)
{
  for (int c = 0; c < 3; ++c)
  {
    out[c] += sign * motion.increment[c];
    for (int d = 0; d < 3; ++d)
      out[c] += sign * motion.turn[3 * c + d] * (x[d] - centre[d]);
  }
}

void add_moment(const double* force, const double* x, const gap::Vector3& centre, double sign, gap::Matrix3& out)
{
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d)
      out[3 * c + d] += sign * force[c] * (x[d] - centre[d]);
}
} // namespace

RigidContact::RigidContact(RigidContactOptions options, std::shared_ptr<RigidBody> slave,
                           std::shared_ptr<RigidBody> master)
    : _options(std::move(options)), _slave(std::move(slave)), _master(std::move(master)), _surface(_options.master)
{
  if (!_slave || _slave == _master)
    throw std::invalid_argument("a contact of rigid bodies has a slave, which is not its master");
  if (_options.points.empty() || _options.points.size() != 3 * _options.areas.size() || _options.radius < 0.0 ||
      _options.friction < 0.0)
    throw std::invalid_argument("a contact of rigid bodies has points with an area each, a radius and a coefficient of "
                                "friction that are not negative");
  _area = std::accumulate(_options.areas.begin(), _options.areas.end(), 0.0);
  if (!(_area > 0.0) || std::ranges::any_of(_options.areas, [](double area) { return !(area > 0.0); }))
    throw std::invalid_argument("areas of points of a rigid body are positive");
  if (_slave->mobility(1.0) == 0.0 && (!_master || _master->mobility(1.0) == 0.0))
    throw std::invalid_argument("two rigid bodies that cannot move do not meet");
  _memory = _slave->state().meetings.size();
  _slave->state().meetings.resize(_memory + 2 + _options.points.size(), 0.0);
}

std::span<double> RigidContact::memory() const
{
  return std::span(_slave->state().meetings).subspan(_memory, 2 + _options.points.size());
}

/// Largest arm about the slave's centre that a force has; along the normal alone, those of balls have none.
double RigidContact::largest_arm() const
{
  double square = 0.0;
  for (std::size_t i = 0; i < _options.points.size(); i += 3)
  {
    double sum = 0.0;
    for (int c = 0; c < 3; ++c)
      sum += std::pow(_options.points[i + c] - _slave->options().centre[c], 2);
    square = std::max(square, sum);
  }
  return std::sqrt(square) + (_options.friction > 0.0 ? _options.radius : 0.0);
}

void RigidContact::set_step(double dt)
{
  double mobility = _slave->mobility(largest_arm());
  if (_master)
  {
    const gap::Rigid& m = _options.master;
    double arm = 0.0;
    if (m.kind == gap::Rigid::Kind::sphere || (m.kind == gap::Rigid::Kind::cylinder && m.gdim == 2))
    {
      for (int c = 0; c < m.gdim; ++c)
        arm += std::pow(m.point[c] - m.centre[c], 2);
      arm = std::sqrt(arm) + (_options.friction > 0.0 ? std::abs(m.radius) : 0.0);
    }
    else // as far as the slave's points are from it at the start
      for (std::size_t i = 0; i < _options.points.size(); i += 3)
      {
        double sum = 0.0;
        for (int c = 0; c < 3; ++c)
          sum += std::pow(_options.points[i + c] - m.centre[c], 2);
        arm = std::max(arm, std::sqrt(sum) + _options.radius);
      }
    mobility += _master->mobility(arm);
  }
  _stiffness = part_of_limit * 4.0 / (dt * dt * mobility);
}

void RigidContact::evaluate()
{
  const gap::RigidMotion motion = _slave->motion();
  const gap::Vector3 centre = _slave->position();
  gap::RigidMotion other;
  gap::Vector3 other_centre{};
  if (_master)
  {
    other = _master->motion();
    other_centre = _master->position();
    _surface.displacement = other.displacement;
    _surface.rotates = true;
    _surface.rotation = other.rotation;
  }
  _force = {};
  _slave_moment = _master_moment = {};
  const std::span<double> kept = memory();
  double &stored = kept[0], &dissipated = kept[1];
  stored = 0.0;
  _gap = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < _options.areas.size(); ++i)
  {
    double x[3];
    for (int c = 0; c < 3; ++c)
    {
      x[c] = centre[c];
      for (int d = 0; d < 3; ++d)
        x[c] += motion.rotation[3 * c + d] * (_options.points[3 * i + d] - _slave->options().centre[d]);
    }
    const gap::RigidPoint at = gap::evaluate(_surface, std::span(x, std::size_t(_surface.gdim)));
    double* const shear = kept.data() + 2 + 3 * i;
    const double gap = at.gap - _options.radius;
    _gap = std::min(_gap, gap);
    const bool opens = !(gap < 0.0), sheared = dot(shear, shear, 3) > 0.0;
    if (opens && !sheared)
      continue;
    double n[3] = {0.0, 0.0, 0.0}, f[3];
    std::copy_n(at.normal, _surface.gdim, n);
    for (int c = 0; c < 3; ++c) // the point of the slave's surface
      x[c] -= _options.radius * n[c];
    const double k = _stiffness * _options.areas[i] / _area, pressed = opens ? 0.0 : -k * gap;
    stored += 0.5 * k * std::pow(opens ? 0.0 : gap, 2);
    if (_options.friction > 0.0)
    {
      gap::Vector3 moved{};
      add_increment(motion, centre, x, 1.0, moved);
      if (_master)
        add_increment(other, other_centre, x, -1.0, moved);
      const double along = dot(moved.data(), n, 3), before = dot(shear, n, 3);
      double size = 0.0, work = 0.0;
      for (int c = 0; c < 3; ++c)
      {
        shear[c] -= before * n[c];
        f[c] = shear[c] - k * (moved[c] - along * n[c]);
        size += f[c] * f[c];
      }
      size = std::sqrt(size);
      const double limit = _options.friction * pressed, factor = size > limit ? limit / size : 1.0;
      for (int c = 0; c < 3; ++c)
      {
        const double now = factor * f[c], slip = moved[c] - along * n[c] + (now - shear[c]) / k;
        work -= 0.5 * (now + shear[c]) * slip; // mean of the step: of second order
        shear[c] = now;
      }
      dissipated += work;
      stored += 0.5 * dot(shear, shear, 3) / k;
    }
    for (int c = 0; c < 3; ++c)
    {
      f[c] = pressed * n[c] + shear[c];
      _force[c] += f[c];
    }
    add_moment(f, x, centre, 1.0, _slave_moment);
    if (_master)
      add_moment(f, x, other_centre, 1.0, _master_moment);
  }
}

} // namespace dolfinx_impact::integrators
