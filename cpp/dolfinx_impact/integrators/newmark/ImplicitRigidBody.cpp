// SPDX-License-Identifier: MIT
#include "ImplicitRigidBody.h"
#include "../../common/vectors.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace dolfinx_impact::integrators
{
namespace
{
typedef gap::Vector3 Vector;
constexpr double epsilon = std::numeric_limits<double>::epsilon();

double inner(const Vector& a, const Vector& b)
{
  return dot(a.data(), b.data(), 3);
}

std::vector<double> copy_of(const std::array<double, 6>& values)
{
  return {values.begin(), values.end()};
}
} // namespace

state::State ImplicitRigidState::state(const std::string& name)
{
  using state::Place;
  state::State out(name);
  const auto add = [&](const char* field, auto& values) { out.add(field, Place::all, state::View(std::span(values))); };
  add("displacement", displacement);
  add("rotation", rotation);
  add("rate", rate);
  add("change", change);
  add("mean", mean);
  add("force", force);
  add("torque", torque);
  add("load", load);
  add("load_torque", load_torque);
  out.add("work", Place::all, work);
  return out;
}

ImplicitRigidBody::ImplicitRigidBody(const RigidBodyOptions& options, double length)
    : _options(options), _inertia(options.inertia, options.fixed_spin, options.spin),
      _turns(_inertia.rotates() || options.spin != Vector{}), _length(length)
{
  for (int c = 0; c < 3; ++c)
    if (!options.fixed_velocity[c])
    {
      if (!(options.mass > 0.0))
        throw std::invalid_argument("a rigid body that moves needs a positive mass");
      _free.push_back(c);
    }
  for (int c = 0; c < 3; ++c)
    if (!options.fixed_spin[c])
      _free.push_back(3 + c);
  if (_inertia.rotates() && options.mass > 0.0)
    _length = std::sqrt(_inertia.largest() / options.mass);
  _scale = _inertia.largest() / _length;
  _now.displacement = options.displacement;
  std::ranges::copy(options.velocity, _now.rate.begin());
  if (_inertia.rotates())
    std::ranges::copy(gap::times(options.inertia, options.spin), _now.rate.begin() + 3);
}

std::string ImplicitRigidBody::component(std::size_t unknown) const
{
  static const char* const names[] = {"x", "y", "z", "rx", "ry", "rz"};
  return names[_free.at(unknown)];
}

void ImplicitRigidBody::start(const Vector& load, const Vector& load_torque, const Vector& force, const Vector& torque)
{
  _now.load = load;
  _now.load_torque = load_torque;
  _now.force = force;
  _now.torque = torque;
  _now.change = {};
  for (int c : _free)
    _now.change[c] = c < 3 ? (load[c] + force[c]) / _options.mass : load_torque[c - 3] + torque[c - 3];
  _now.mean = _now.change;
}

void ImplicitRigidBody::begin_step(const ImplicitScheme& scheme, double step, const Vector& load,
                                   const Vector& load_torque)
{
  _step = step;
  _load = load;
  _load_torque = load_torque;
  // Unknowns are increments, so that accelerations do not have the rounding of places.
  std::vector<std::int8_t> fixed(6, 1);
  for (int c : _free)
    fixed[c] = 0;
  TimeValues prescribed;
  prescribed.displacement.assign(6, 0.0);
  prescribed.velocity = copy_of(_now.rate);
  prescribed.acceleration.assign(6, 0.0);
  _motion.emplace(scheme, step,
                  Motion{std::vector<double>(6, 0.0), copy_of(_now.rate), copy_of(_now.change), copy_of(_now.mean)},
                  std::vector<std::int8_t>(6, 0), fixed, prescribed);
  solution = first_guess();
}

std::vector<double> ImplicitRigidBody::first_guess() const
{
  const std::vector<double> predicted = _motion->predictor();
  std::vector<double> out;
  for (int c : _free)
    out.push_back(c < 3 ? predicted[c] : predicted[c] / _scale);
  return out;
}

/// Increments of the displacement and integral of the angular momentum over the step; fixed components go on.
std::array<double, 6> ImplicitRigidBody::increments(std::span<const double> q) const
{
  std::array<double, 6> out{};
  for (int c = 0; c < 6; ++c)
    out[c] = _step * _now.rate[c];
  for (std::size_t i = 0; i < _free.size(); ++i)
    out[_free[i]] = _free[i] < 3 ? q[i] : q[i] * _scale;
  return out;
}

gap::Quaternion ImplicitRigidBody::turned(const std::array<double, 6>& increments) const
{
  return _inertia.turned(_now.rotation, {increments[3] / _step, increments[4] / _step, increments[5] / _step}, _step);
}

solve::RigidPlace ImplicitRigidBody::place(std::span<const double> q) const
{
  const std::array<double, 6> moved = increments(q);
  solve::RigidPlace out{_now.displacement, gap::matrix_of(turned(moved))};
  for (int c = 0; c < 3; ++c)
    out.displacement[c] += moved[c];
  return out;
}

solve::RigidBalance ImplicitRigidBody::balance(std::span<const double> q, const Vector& force,
                                               const Vector& torque) const
{
  const std::array<double, 6> moved = increments(q);
  const Motion end = _motion->end(moved);
  solve::RigidBalance out;
  for (int c : _free)
  {
    const double inertia = c < 3 ? _options.mass * end.acceleration[c] : end.acceleration[c] / _length;
    const double external = c < 3 ? _load[c] : _load_torque[c - 3] / _length;
    const double contact = c < 3 ? force[c] : torque[c - 3] / _length;
    out.missing.push_back(external + contact - inertia);
    out.size = std::max({out.size, std::abs(external), std::abs(contact), std::abs(inertia)});
    const double per_increment = _motion->acceleration_factor()[c] * (c < 3 ? _options.mass : 1.0 / _length);
    out.round_off = std::max(out.round_off, 8.0 * epsilon * std::abs(per_increment * moved[c]));
  }
  return out;
}

std::vector<double> ImplicitRigidBody::derivatives() const
{
  std::vector<double> out;
  for (int c : _free)
    out.push_back(-_motion->acceleration_factor()[c] * (c < 3 ? _options.mass : _scale / _length));
  return out;
}

void ImplicitRigidBody::accept(std::span<const double> q, const Vector& force, const Vector& torque)
{
  const std::array<double, 6> moved = increments(q);
  const Motion end = _motion->end(moved);
  const gap::Quaternion rotation = turned(moved);
  const Vector angle = gap::angle_of(gap::product(rotation, gap::inverse(_now.rotation)));
  for (int c = 0; c < 3; ++c)
  {
    const bool fixed = _options.fixed_velocity[c];
    const double before = fixed ? -_now.force[c] : _now.load[c], after = fixed ? -force[c] : _load[c];
    _now.work += 0.5 * (before + after) * moved[c];
    if (_inertia.rotates())
      _now.work += 0.5 * (_now.load_torque[c] + _load_torque[c]) * angle[c];
    else
      _now.work -= 0.5 * (_now.torque[c] + torque[c]) * angle[c];
  }
  for (int c = 0; c < 3; ++c)
    _now.displacement[c] += moved[c];
  _now.rotation = rotation;
  std::ranges::copy(end.velocity, _now.rate.begin());
  std::ranges::copy(end.acceleration, _now.change.begin());
  std::ranges::copy(end.mean, _now.mean.begin());
  _now.force = force;
  _now.torque = torque;
  _now.load = _load;
  _now.load_torque = _load_torque;
}

// --- the present time

Vector ImplicitRigidBody::position() const
{
  Vector out = _options.centre;
  for (int c = 0; c < 3; ++c)
    out[c] += _now.displacement[c];
  return out;
}

Vector ImplicitRigidBody::velocity() const
{
  return {_now.rate[0], _now.rate[1], _now.rate[2]};
}

Vector ImplicitRigidBody::angular_momentum() const
{
  return {_now.rate[3], _now.rate[4], _now.rate[5]};
}

Vector ImplicitRigidBody::spin() const
{
  return _inertia.spin(angular_momentum(), _now.rotation);
}

Vector ImplicitRigidBody::momentum() const
{
  const Vector v = velocity();
  return {_options.mass * v[0], _options.mass * v[1], _options.mass * v[2]};
}

double ImplicitRigidBody::kinetic_energy() const
{
  const double translation = 0.5 * inner(momentum(), velocity());
  return _inertia.rotates() ? translation + 0.5 * inner(angular_momentum(), spin()) : translation;
}
} // namespace dolfinx_impact::integrators
