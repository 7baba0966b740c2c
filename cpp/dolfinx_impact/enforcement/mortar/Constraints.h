// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Constrained slave nodes of one contact on this rank, n of them: along some directions q_d of an orthonormal frame
///
///     u_j . q_d = sum_l P_jl u_l . m_d + known.
///
/// m_d is q_d; only where a component of u_j is prescribed and the normal has a part along it, for which q_d cannot
/// stand, m_d = normal / L with L the length of the normal's free part.
struct Constraints
{
  int gdim = 3;
  std::vector<std::int32_t> rows;       ///< number of the node among the contact's
  std::vector<std::int32_t> nodes;      ///< owned blocks of the space
  std::vector<double> frames;           ///< columns are the directions: [(i*gdim + a)*gdim + d]
  std::vector<double> over;             ///< the directions m_d, as frames
  std::vector<std::int8_t> constrained; ///< which of the directions, [i*gdim + d]
  std::vector<double> known;            ///< increments along constrained directions, [i*gdim + d] [L]
  std::vector<double> tilt;             ///< friction per normal force of slipping nodes, else 0: [i*gdim + a]
  std::vector<std::int32_t> normal;     ///< number of the normal direction
  std::vector<std::int64_t> pointers;   ///< rows of P = D^-1 M: of each node and the end
  std::vector<std::int64_t> columns;    ///< global nodes
  std::vector<double> values;           ///< of P: one for all directions, or [k*gdim + d] for each of them
  bool tied = false;                    ///< conditions of a tie: all of a node's directions come before contact's

  /// P_jl along a direction.
  /// @param[in] k place in `columns`
  double part(std::int64_t k, int d) const { return values[values.size() == columns.size() ? k : k * gdim + d]; }
  std::size_t size() const { return nodes.size(); }
};

/// Orthonormal frames at nodes: prescribed axes keep their place, one direction is the normal freed of them.
struct NodalFrames
{
  std::vector<double> frames;      ///< columns are the directions: [(i*gdim + a)*gdim + d]
  std::vector<std::int32_t> place; ///< of the normal direction; -1 where every direction that it has is prescribed
  std::vector<double> length;      ///< of the normal's free part
};

/// @param[in] normals unit vectors, [i*gdim + c]
/// @param[in] fixed prescribed components, [i*gdim + c]
NodalFrames frames_at(int gdim, std::span<const double> normals, std::span<const std::int8_t> fixed);
} // namespace dolfinx_impact::enforcement
