// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace dolfinx_impact::rolling
{
/// Nodes of a contact at which the law of steady friction is evaluated; vectors [i*gdim + c].
struct FrictionNodes
{
  int gdim = 3;
  std::span<const std::int8_t> carriers;        ///< nodes with a multiplier
  std::span<const double> normal;               ///< unit vectors out of the master
  std::span<const double> normal_stiffness;     ///< c_n > 0 [F/L^3]
  std::span<const double> tangential_stiffness; ///< c_t > 0 [F T/L^3]
};

/// Contact and Coulomb friction of nodes against their steady slip velocity s, as equations of semi-smooth functions of
/// trial values p = lambda_n - c_n g and tau = lambda_T - c_t s (Alart and Curnier 1991); docs/rolling.md.
struct SteadyFriction
{
  std::vector<std::int8_t> active;  ///< p is positive: the node is in contact
  std::vector<std::int8_t> sliding; ///< tau exceeds friction times p
  /// Multipliers that the law makes of the trial values, vectors; in a solution they are the same [F/L^2].
  std::vector<double> target;

  /// @param[in] friction coefficient by node [1]
  /// @param[in] gap by node [L]
  /// @param[in] slip tangential slip velocities, vectors [L/T]
  /// @param[in] multipliers vectors [F/L^2]
  SteadyFriction(const FrictionNodes& nodes, std::span<const double> friction, std::span<const double> gap,
                 std::span<const double> slip, std::span<const double> multipliers);
};

/// Orthonormal tangent vectors of a surface at a node, [t*gdim + c] with gdim - 1 of them. A prescribed component along
/// the surface, as on a plane of symmetry, gets a tangent vector of its own.
/// @param[in] normal unit vector
/// @param[in] first direction that the first tangent follows where no component is prescribed
/// @param[in] fixed prescribed components
std::vector<double> tangents(std::span<const double> normal, std::span<const double> first,
                             std::span<const std::int8_t> fixed);
} // namespace dolfinx_impact::rolling
