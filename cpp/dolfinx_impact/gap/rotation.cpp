// SPDX-License-Identifier: MIT
#include "rotation.h"
#include "../common/vectors.h"
#include <cmath>

namespace dolfinx_impact::gap
{
Quaternion product(const Quaternion& p, const Quaternion& q)
{
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}

Quaternion inverse(const Quaternion& q)
{
  return {q[0], -q[1], -q[2], -q[3]};
}

Quaternion normalised(Quaternion q)
{
  const double norm = std::sqrt(dot(q.data(), q.data(), 4));
  for (double& value : q)
    value /= norm;
  return q;
}

Quaternion quaternion_of(const Vector3& angle)
{
  const double size = std::sqrt(dot(angle.data(), angle.data(), 3)), half = 0.5 * size;
  const double part = half > 1e-8 ? std::sin(half) / size : 0.5;
  return {std::cos(half), part * angle[0], part * angle[1], part * angle[2]};
}

Vector3 angle_of(const Quaternion& q)
{
  const Vector3 v{q[1], q[2], q[3]};
  const double size = std::sqrt(dot(v.data(), v.data(), 3)), angle = 2.0 * std::atan2(size, q[0]);
  const double part = size > 1e-8 ? angle / size : 2.0 / q[0];
  return {part * v[0], part * v[1], part * v[2]};
}

Matrix3 matrix_less_identity(const Quaternion& q)
{
  const auto [w, x, y, z] = q;
  return {-2.0 * (y * y + z * z), 2.0 * (x * y - w * z),  2.0 * (x * z + w * y),
          2.0 * (x * y + w * z),  -2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
          2.0 * (x * z - w * y),  2.0 * (y * z + w * x),  -2.0 * (x * x + y * y)};
}

Matrix3 matrix_of(const Quaternion& q)
{
  Matrix3 out = matrix_less_identity(q);
  for (int k = 0; k < 3; ++k)
    out[4 * k] += 1.0;
  return out;
}

Matrix3 turn_of(const Quaternion& step)
{
  Matrix3 out = matrix_less_identity(inverse(step));
  for (double& value : out)
    value = -value;
  return out;
}

Matrix3 turn_between(const Matrix3& before, const Matrix3& after)
{
  Matrix3 out{};
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      for (int k = 0; k < 3; ++k)
        out[3 * a + b] += (after[3 * a + k] - before[3 * a + k]) * after[3 * b + k];
  return out;
}

Vector3 times(const Matrix3& A, const Vector3& x)
{
  return {dot(A.data(), x.data(), 3), dot(A.data() + 3, x.data(), 3), dot(A.data() + 6, x.data(), 3)};
}
} // namespace dolfinx_impact::gap
