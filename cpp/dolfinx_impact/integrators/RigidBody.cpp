// SPDX-License-Identifier: MIT
#include "RigidBody.h"
#include "../common/vectors.h"
#include "../solve/dense.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace dolfinx_impact::integrators
{
namespace
{
using gap::Matrix3;
typedef std::array<double, 3> Vector;
typedef std::array<double, 4> Quaternion; // scalar first

Quaternion product(const Quaternion& p, const Quaternion& q)
{
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}

Quaternion inverse(const Quaternion& q)
{
  return {q[0], -q[1], -q[2], -q[3]};
}

double length(const Vector& v)
{
  return std::sqrt(dot(v.data(), v.data(), 3));
}

/// Rotation by the length of a vector about its direction.
Quaternion quaternion_of(const Vector& angle)
{
  const double size = length(angle), half = 0.5 * size;
  const double part = half > 1e-8 ? std::sin(half) / size : 0.5;
  return {std::cos(half), part * angle[0], part * angle[1], part * angle[2]};
}

/// The inverse of it, for angles up to pi.
Vector angle_of(const Quaternion& q)
{
  const Vector v{q[1], q[2], q[3]};
  const double size = length(v), angle = 2.0 * std::atan2(size, q[0]);
  const double part = size > 1e-8 ? angle / size : 2.0 / q[0];
  return {part * v[0], part * v[1], part * v[2]};
}

/// Rotation matrix less the identity: small rotations keep their digits.
Matrix3 rotation_less_identity(const Quaternion& q)
{
  const auto [w, x, y, z] = q;
  return {-2.0 * (y * y + z * z), 2.0 * (x * y - w * z),  2.0 * (x * z + w * y),
          2.0 * (x * y + w * z),  -2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
          2.0 * (x * z - w * y),  2.0 * (y * z + w * x),  -2.0 * (x * x + y * y)};
}

Matrix3 matrix_of(const Quaternion& q)
{
  Matrix3 out = rotation_less_identity(q);
  for (int k = 0; k < 3; ++k)
    out[4 * k] += 1.0;
  return out;
}

Vector times(const Matrix3& A, const Vector& x)
{
  return {dot(A.data(), x.data(), 3), dot(A.data() + 3, x.data(), 3), dot(A.data() + 6, x.data(), 3)};
}

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
  return out;
}

RigidBody::RigidBody(const RigidBodyOptions& options) : _options(options)
{
  const RigidBodyOptions& o = options;
  for (int k = 0; k < 3; ++k)
    if (!o.fixed_velocity[k] && !(o.mass > 0.0))
      throw std::invalid_argument("a rigid body that moves needs a positive mass");
  const int num_fixed = int(std::ranges::count(o.fixed_spin, true));
  _rotation = num_fixed == 3 ? Rotation::fixed : num_fixed == 0 ? Rotation::free : Rotation::partly;
  for (int k = 0; k < 3; ++k)
    if (_rotation == Rotation::partly && o.fixed_spin[k] && o.spin[k] != 0.0)
      throw std::invalid_argument(
          "a rigid body whose spin is fixed in some components, not in all, has no spin in them");
  _now.displacement = o.displacement;
  for (int k = 0; k < 3; ++k)
    _now.momentum[k] = o.mass * o.velocity[k];
  if (_rotation == Rotation::fixed)
    return;
  const solve::SymmetricEigen found = solve::symmetric_eigen({o.inertia.begin(), o.inertia.end()}, 3);
  _least = found.values.front();
  if (!(_least > 0.0))
    throw std::invalid_argument("a rigid body that rotates needs an inertia with three positive principal moments");
  // The axis that differs from the two others: its rotation and that of a top about it are exact.
  const bool first = 1.0 / found.values[0] - 1.0 / found.values[1] > 1.0 / found.values[1] - 1.0 / found.values[2];
  const std::array<int, 3> order = first ? std::array{1, 2, 0} : std::array{0, 1, 2};
  for (int k = 0; k < 3; ++k)
  {
    _moments[k] = found.values[order[k]];
    std::copy_n(found.vectors.begin() + 3 * order[k], 3, _axes[k].begin());
  }
  cross(_axes[0].data(), _axes[1].data(), _axes[2].data());
  _now.angular_momentum = times(o.inertia, o.spin);
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
  if (_rotation == Rotation::fixed)
    work += dot(motion.turn.data(), _now.force_moment.data(), 9);
  else
    work += inner(motion.angle, _load_torque);
  return 0.5 * work;
}

// --- kinetics

Matrix3 RigidBody::inertia_at(const Quaternion& rotation) const
{
  const Matrix3 R = matrix_of(rotation);
  Matrix3 out{};
  for (int k = 0; k < 3; ++k)
  {
    const Vector axis = times(R, _axes[k]);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        out[3 * a + b] += _moments[k] * axis[a] * axis[b];
  }
  return out;
}

Vector RigidBody::spin_of(const Vector& momentum, const Quaternion& rotation) const
{
  if (_rotation == Rotation::fixed)
    return _options.spin;
  Vector out{};
  if (_rotation == Rotation::free)
  {
    const Matrix3 R = matrix_of(rotation);
    for (int k = 0; k < 3; ++k)
    {
      const Vector axis = times(R, _axes[k]);
      const double along = inner(axis, momentum) / _moments[k];
      for (int a = 0; a < 3; ++a)
        out[a] += along * axis[a];
    }
    return out;
  }
  // One or two components are free: their equations alone.
  const Matrix3 J = inertia_at(rotation);
  int free[2] = {-1, -1}, num = 0;
  for (int k = 0; k < 3; ++k)
    if (!_options.fixed_spin[k])
      free[num++] = k;
  const int a = free[0], b = free[1];
  if (num == 1)
    out[a] = momentum[a] / J[4 * a];
  else
  {
    const double determinant = J[4 * a] * J[4 * b] - J[3 * a + b] * J[3 * a + b];
    out[a] = (J[4 * b] * momentum[a] - J[3 * a + b] * momentum[b]) / determinant;
    out[b] = (J[4 * a] * momentum[b] - J[3 * a + b] * momentum[a]) / determinant;
  }
  return out;
}

/// Kinetic energy of two momenta, as p q/2m.
double RigidBody::kinetic(const RigidBodyState& at, const Vector& momentum, const Vector& angular) const
{
  double out = 0.0;
  if (_options.mass > 0.0)
    out += 0.5 * inner(at.momentum, momentum) / _options.mass;
  if (_rotation != Rotation::fixed)
    out += 0.5 * inner(at.angular_momentum, spin_of(angular, at.rotation));
  return out;
}

void RigidBody::rotate(double dt)
{
  const Quaternion before = _now.rotation;
  const Vector& L = _now.angular_momentum;
  Quaternion q = before;
  if (_rotation == Rotation::free)
  {
    const double about_second = 1.0 / _moments[1] - 1.0 / _moments[0];
    const double about_third = 1.0 / _moments[2] - 1.0 / _moments[0];
    const auto along = [&](int k) { return inner(times(matrix_of(q), _axes[k]), L); };
    const auto half = [&] { q = product(q, quaternion_of(scaled(0.5 * dt * about_second * along(1), _axes[1]))); };
    half();
    const double third = along(2);
    q = product(quaternion_of(scaled(dt / _moments[0], L)),
                product(q, quaternion_of(scaled(dt * about_third * third, _axes[2]))));
    half();
  }
  else
  {
    // Midpoint of the rotation (Simo and Vu-Quoc 1988): the spin of the middle of the step turns the whole step. With
    // one free component, or a constant spin, the first value is the solution.
    Vector spin = spin_of(L, before);
    for (int k = 0; k < 50; ++k)
    {
      const Vector next = spin_of(L, product(quaternion_of(scaled(0.5 * dt, spin)), before));
      double change = 0.0, size = 0.0;
      for (int c = 0; c < 3; ++c)
      {
        change = std::max(change, std::abs(next[c] - spin[c]));
        size = std::max(size, std::abs(next[c]));
      }
      spin = next;
      if (change <= 4.0 * std::numeric_limits<double>::epsilon() * size)
        break;
    }
    q = product(quaternion_of(scaled(dt, spin)), before);
  }
  const double norm = std::sqrt(dot(q.data(), q.data(), 4));
  for (double& value : q)
    value /= norm;
  const Quaternion step = product(q, inverse(before));
  _now.rotation = q;
  _now.angle = angle_of(step);
  _now.turn = rotation_less_identity(inverse(step));
  for (double& value : _now.turn)
    value = -value;
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
  moved.turn = rotation_less_identity(quaternion_of(_now.angle));
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
  return spin_of(angular_momentum(dt), _now.rotation);
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
  return (translates() ? 1.0 / _options.mass : 0.0) + (rotates() ? arm * arm / _least : 0.0);
}
} // namespace dolfinx_impact::integrators
