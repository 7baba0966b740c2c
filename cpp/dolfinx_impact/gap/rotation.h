// SPDX-License-Identifier: MIT
#pragma once
#include "RigidMotion.h"
#include <array>

namespace dolfinx_impact::gap
{
typedef std::array<double, 3> Vector3;
/// A rotation as a unit quaternion, scalar first [1].
typedef std::array<double, 4> Quaternion;

/// The second rotation, then the first.
Quaternion product(const Quaternion& first, const Quaternion& second);
Quaternion inverse(const Quaternion& rotation);
/// Of length one, as round-off of many products needs it.
Quaternion normalised(Quaternion rotation);
/// Rotation by the length of a vector about its direction.
Quaternion quaternion_of(const Vector3& angle);
/// The inverse of it, for angles up to pi.
Vector3 angle_of(const Quaternion& rotation);
Matrix3 matrix_of(const Quaternion& rotation);
/// Rotation matrix less the identity: small rotations keep their digits.
Matrix3 matrix_less_identity(const Quaternion& rotation);
/// What a rotation adds that is the last part of another one, see RigidMotion::turn: the identity less its inverse.
Matrix3 turn_of(const Quaternion& step);
/// The same of two rotations, as matrices: (after - before) after^T.
Matrix3 turn_between(const Matrix3& before, const Matrix3& after);
/// Matrix times vector.
Vector3 times(const Matrix3& A, const Vector3& x);
} // namespace dolfinx_impact::gap
