// SPDX-License-Identifier: MIT
#include "RigidInertia.h"
#include "../common/vectors.h"
#include "../solve/dense.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace dolfinx_impact::integrators
{
using gap::Matrix3;
using gap::matrix_of;
using gap::product;
using gap::Quaternion;
using gap::quaternion_of;
using gap::times;
typedef gap::Vector3 Vector;

namespace
{
double along(const Vector& a, const Vector& b)
{
  return dot(a.data(), b.data(), 3);
}

Vector multiple(double factor, const Vector& x)
{
  return {factor * x[0], factor * x[1], factor * x[2]};
}
} // namespace

RigidInertia::RigidInertia(const Matrix3& inertia, const std::array<bool, 3>& fixed, const Vector& spin)
    : _fixed(fixed), _spin(spin)
{
  const int num_fixed = int(std::ranges::count(fixed, true));
  _rotation = num_fixed == 3 ? Rotation::fixed : num_fixed == 0 ? Rotation::free : Rotation::partly;
  for (int k = 0; k < 3; ++k)
    if (_rotation == Rotation::partly && fixed[k] && spin[k] != 0.0)
      throw std::invalid_argument(
          "a rigid body whose spin is fixed in some components, not in all, has no spin in them");
  if (_rotation == Rotation::fixed)
    return;
  const solve::SymmetricEigen found = solve::symmetric_eigen({inertia.begin(), inertia.end()}, 3);
  _least = found.values.front();
  _largest = found.values.back();
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
}

Matrix3 RigidInertia::inertia_at(const Quaternion& rotation) const
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

Vector RigidInertia::spin(const Vector& momentum, const Quaternion& rotation) const
{
  if (_rotation == Rotation::fixed)
    return _spin;
  Vector out{};
  if (_rotation == Rotation::free)
  {
    const Matrix3 R = matrix_of(rotation);
    for (int k = 0; k < 3; ++k)
    {
      const Vector axis = times(R, _axes[k]);
      const double part = along(axis, momentum) / _moments[k];
      for (int a = 0; a < 3; ++a)
        out[a] += part * axis[a];
    }
    return out;
  }
  // One or two components are free: their equations alone.
  const Matrix3 J = inertia_at(rotation);
  int free[2] = {-1, -1}, num = 0;
  for (int k = 0; k < 3; ++k)
    if (!_fixed[k])
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

Quaternion RigidInertia::turned(const Quaternion& before, const Vector& L, double dt) const
{
  Quaternion q = before;
  if (_rotation == Rotation::free)
  {
    const double about_second = 1.0 / _moments[1] - 1.0 / _moments[0];
    const double about_third = 1.0 / _moments[2] - 1.0 / _moments[0];
    const auto component = [&](int k) { return along(times(matrix_of(q), _axes[k]), L); };
    const auto half = [&]
    { q = product(q, quaternion_of(multiple(0.5 * dt * about_second * component(1), _axes[1]))); };
    half();
    const double third = component(2);
    q = product(quaternion_of(multiple(dt / _moments[0], L)),
                product(q, quaternion_of(multiple(dt * about_third * third, _axes[2]))));
    half();
  }
  else
  {
    // Midpoint of the rotation (Simo and Vu-Quoc 1988): the spin of the middle of the step turns the whole step. With
    // one free component, or a constant spin, the first value is the solution.
    Vector now = spin(L, before);
    for (int k = 0; k < 50; ++k)
    {
      const Vector next = spin(L, product(quaternion_of(multiple(0.5 * dt, now)), before));
      double change = 0.0, size = 0.0;
      for (int c = 0; c < 3; ++c)
      {
        change = std::max(change, std::abs(next[c] - now[c]));
        size = std::max(size, std::abs(next[c]));
      }
      now = next;
      if (change <= 4.0 * std::numeric_limits<double>::epsilon() * size)
        break;
    }
    q = product(quaternion_of(multiple(dt, now)), before);
  }
  return gap::normalised(q);
}
} // namespace dolfinx_impact::integrators
