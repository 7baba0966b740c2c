// SPDX-License-Identifier: MIT
#include "StaticRigidBody.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dolfinx_impact::problems
{
StaticRigidBody::StaticRigidBody(const std::array<bool, 6>& fixed, std::span<const double> force,
                                 std::span<const double> torque, const gap::Vector3& centre, double length)
    : _force(force), _torque(torque), _centre(centre), _length(length)
{
  if (force.size() != 3 || torque.size() != 3 || !(length > 0.0))
    throw std::invalid_argument("a rigid body of a static problem has a force and a torque of three components");
  for (int c = 0; c < 6; ++c)
    if (!fixed[c])
      _free.push_back(c);
}

std::string StaticRigidBody::component(std::size_t unknown) const
{
  static const char* const names[] = {"x", "y", "z", "rx", "ry", "rz"};
  return names[_free.at(unknown)];
}

solve::RigidPlace StaticRigidBody::place(std::span<const double> q) const
{
  solve::RigidPlace out = _start;
  gap::Vector3 angle{};
  for (std::size_t i = 0; i < _free.size(); ++i)
    if (_free[i] < 3)
      out.displacement[_free[i]] += q[i];
    else
      angle[_free[i] - 3] = q[i] / _length;
  if (!turns())
    return out;
  const gap::Matrix3 step = gap::matrix_of(gap::quaternion_of(angle));
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
    {
      out.rotation[3 * a + b] = 0.0;
      for (int k = 0; k < 3; ++k)
        out.rotation[3 * a + b] += step[3 * a + k] * _start.rotation[3 * k + b];
    }
  return out;
}

solve::RigidBalance StaticRigidBody::balance(std::span<const double>, const gap::Vector3& force,
                                             const gap::Vector3& torque) const
{
  solve::RigidBalance out;
  for (int c : _free)
  {
    const double scale = c < 3 ? 1.0 : 1.0 / _length;
    const double external = scale * (c < 3 ? _force[c] : _torque[c - 3]);
    const double contact = scale * (c < 3 ? force[c] : torque[c - 3]);
    out.missing.push_back(external + contact);
    out.size = std::max({out.size, std::abs(external), std::abs(contact)});
  }
  return out;
}
} // namespace dolfinx_impact::problems
