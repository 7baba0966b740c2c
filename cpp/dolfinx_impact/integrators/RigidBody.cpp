// SPDX-License-Identifier: MIT
#include "RigidBody.h"
#include "../common/vectors.h"
#include <algorithm>
#include <stdexcept>

namespace dolfinx_impact::integrators
{
namespace
{
using gap::Matrix3;
using gap::matrix_of;
typedef gap::Vector3 Vector;

Vector scaled(double factor, const Vector& x)
{
  return {factor * x[0], factor * x[1], factor * x[2]};
}

double inner(const Vector& a, const Vector& b)
{
  return dot(a.data(), b.data(), 3);
}
} // namespace

state::State RigidBodyState::state(const std::string& name)
{
  using state::Place;
  state::State out(name);
  const auto add = [&](const char* field, auto& values) { out.add(field, Place::all, state::View(std::span(values))); };
  add("displacement", displacement);
  add("rotation", rotation);
  add("momentum", momentum);
  add("angular_momentum", angular_momentum);
  add("increment", increment);
  add("angle", angle);
  add("turn", turn);
  add("force", force);
  add("force_moment", force_moment);
  out.add("work_done", Place::all, work.done).add("work_before", Place::all, work.before);
  if (!meetings.empty())
    out.add("meetings", Place::all, meetings);
  return out;
}

RigidBody::RigidBody(const RigidBodyOptions& options)
    : _options(options), _inertia(options.inertia, options.fixed_spin, options.spin)
{
  const RigidBodyOptions& o = options;
  for (int k = 0; k < 3; ++k)
    if (!o.fixed_velocity[k] && !(o.mass > 0.0))
      throw std::invalid_argument("a rigid body that moves needs a positive mass");
  _now.displacement = o.displacement;
  for (int k = 0; k < 3; ++k)
    _now.momentum[k] = o.mass * o.velocity[k];
  if (_inertia.rotates())
    _now.angular_momentum = gap::times(o.inertia, o.spin);
}

void RigidBody::begin()
{
  _now.increment = {};
  _now.angle = {};
  _now.turn = {};
  _now.work = {};
  _work_after = 0.0;
}

void RigidBody::set_loads(const Vector& force, const Vector& torque)
{
  _load = force;
  _load_torque = torque;
}

void RigidBody::set_contact_forces(const Vector& force, const Matrix3& moment)
{
  _now.force = force;
  _now.force_moment = moment;
  _now.work.before = half_work(_now);
}

// --- forces

Vector RigidBody::contact_force() const
{
  return scaled(-1.0, _now.force);
}

Vector RigidBody::contact_torque() const
{
  const Matrix3& m = _now.force_moment;
  return {m[3 * 1 + 2] - m[3 * 2 + 1], m[3 * 2 + 0] - m[3 * 0 + 2], m[3 * 0 + 1] - m[3 * 1 + 0]};
}

Vector RigidBody::force() const
{
  Vector out = contact_force();
  for (int k = 0; k < 3; ++k)
    out[k] = _options.fixed_velocity[k] ? 0.0 : out[k] + _load[k];
  return out;
}

Vector RigidBody::torque() const
{
  Vector out = contact_torque();
  for (int k = 0; k < 3; ++k)
    out[k] = _options.fixed_spin[k] ? 0.0 : out[k] + _load_torque[k];
  return out;
}

/// Half of the work of a step's motion by the forces at a time level.
double RigidBody::half_work(const RigidBodyState& motion) const
{
  double work = 0.0;
  for (int k = 0; k < 3; ++k)
    work += motion.increment[k] * (_options.fixed_velocity[k] ? _now.force[k] : _load[k]);
  if (!_inertia.rotates())
    work += dot(motion.turn.data(), _now.force_moment.data(), 9);
  else
    work += inner(motion.angle, _load_torque);
  return 0.5 * work;
}

// --- kinetics

/// Kinetic energy of two momenta, as p q/2m.
double RigidBody::kinetic(const RigidBodyState& at, const Vector& momentum, const Vector& angular) const
{
  double out = 0.0;
  if (_options.mass > 0.0)
    out += 0.5 * inner(at.momentum, momentum) / _options.mass;
  if (_inertia.rotates())
    out += 0.5 * inner(at.angular_momentum, _inertia.spin(angular, at.rotation));
  return out;
}

void RigidBody::rotate(double dt)
{
  const gap::Quaternion before = _now.rotation;
  _now.rotation = _inertia.turned(before, _now.angular_momentum, dt);
  const gap::Quaternion step = gap::product(_now.rotation, gap::inverse(before));
  _now.angle = gap::angle_of(step);
  _now.turn = gap::turn_of(step);
}

void RigidBody::advance(double dt, double h, bool starts)
{
  measure(h, starts);
  const Vector f = force(), t = torque();
  RigidBodyState moved = _now;
  for (int k = 0; k < 3; ++k)
  {
    _now.momentum[k] += h * f[k];
    _now.angular_momentum[k] += h * t[k];
    _now.increment[k] = dt * (_options.fixed_velocity[k] ? _options.velocity[k] : _now.momentum[k] / _options.mass);
    _now.displacement[k] += _now.increment[k];
  }
  rotate(dt);
  // The arms of the forces before the step are turned by the step, not back by it.
  moved.increment = _now.increment;
  moved.angle = _now.angle;
  moved.turn = gap::matrix_less_identity(gap::quaternion_of(_now.angle));
  _work_after = half_work(moved);
}

void RigidBody::measure(double h, bool starts)
{
  const Vector f = force(), t = torque();
  RigidBodyState after = _now, before = _now;
  for (int k = 0; k < 3; ++k)
  {
    after.momentum[k] += h * f[k];
    after.angular_momentum[k] += h * t[k];
    if (starts) // nothing moved before: the momenta half a step earlier would have led here
    {
      before.momentum[k] -= h * f[k];
      before.angular_momentum[k] -= h * t[k];
    }
  }
  _energies.kinetic = kinetic(before, after.momentum, after.angular_momentum);
  _energies.after = kinetic(after, after.momentum, after.angular_momentum);
  _energies.before = kinetic(before, before.momentum, before.angular_momentum);
}

void RigidBody::commit()
{
  _now.work.commit(_work_after);
}

// --- the present time level

gap::RigidMotion RigidBody::motion() const
{
  return {_now.displacement, _now.increment, true, rotation(), _now.turn};
}

Vector RigidBody::position() const
{
  Vector out = _options.centre;
  for (int k = 0; k < 3; ++k)
    out[k] += _now.displacement[k];
  return out;
}

Matrix3 RigidBody::rotation() const
{
  return matrix_of(_now.rotation);
}

Vector RigidBody::momentum(double dt) const
{
  const Vector f = force();
  Vector out = _now.momentum;
  for (int k = 0; k < 3; ++k)
    out[k] += 0.5 * dt * f[k];
  return out;
}

Vector RigidBody::angular_momentum(double dt) const
{
  const Vector t = torque();
  Vector out = _now.angular_momentum;
  for (int k = 0; k < 3; ++k)
    out[k] += 0.5 * dt * t[k];
  return out;
}

Vector RigidBody::velocity(double dt) const
{
  Vector out = momentum(dt);
  for (int k = 0; k < 3; ++k)
    out[k] = _options.fixed_velocity[k] ? _options.velocity[k] : out[k] / _options.mass;
  return out;
}

Vector RigidBody::spin(double dt) const
{
  return _inertia.spin(angular_momentum(dt), _now.rotation);
}

double RigidBody::kinetic_energy(double dt) const
{
  RigidBodyState now = _now;
  now.momentum = momentum(dt);
  now.angular_momentum = angular_momentum(dt);
  return kinetic(now, now.momentum, now.angular_momentum);
}

bool RigidBody::translates() const
{
  return std::ranges::count(_options.fixed_velocity, false) > 0;
}

double RigidBody::mobility(double arm) const
{
  return (translates() ? 1.0 / _options.mass : 0.0) + (rotates() ? arm * arm / _inertia.least() : 0.0);
}
} // namespace dolfinx_impact::integrators
