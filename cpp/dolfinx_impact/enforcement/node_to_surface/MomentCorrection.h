// SPDX-License-Identifier: MIT
#pragma once
#include "../../surface/Facets.h"

namespace dolfinx_impact::enforcement
{
/// Calls each(j) for the nodes of a facet; unrolled for quadrilaterals, and where the compiler knows the number.
template <typename Each>
inline void for_nodes(int num, Each&& each)
{
  if (num == 4)
#pragma GCC unroll 4
    for (int j = 0; j < 4; ++j)
      each(j);
  else
#pragma GCC unroll 3
    for (int j = 0; j < num; ++j)
      each(j);
}

/// Forces without resultant on the nodes of a facet that give back the moment which a contact force and its reaction
/// leave: c_j = omega x (x_j - mean), sum_j (x_j - mean) x c_j = e x f, e from the slave's node to the master's point
/// (docs/explicit/penalty.md, "Moment correction").
/// @tparam T double, or a vector of doubles: a node in each lane
template <typename T>
struct MomentCorrectionOf
{
  T e[3], inverse[6];

  /// @param[in] num nodes of the facet
  /// @param[in] at at(j, c): position of node j
  /// @param[in] phi shape functions at the master's point
  /// @param[in] x position of the slave's node
  /// @param[out] r x_j - mean, [j*D + c]
  template <int D>
  void set(int num, auto&& at, const T* phi, const T* x, T* r)
  {
    T mean[D] = {}, squares[D][D] = {};
    const double part = 1.0 / num;
#pragma GCC unroll 4
    for (int c = 0; c < D; ++c)
      e[c] = -x[c];
    for_nodes(num,
              [&](int j)
              {
#pragma GCC unroll 4
                for (int c = 0; c < D; ++c)
                {
                  r[j * D + c] = at(j, c);
                  mean[c] += part * r[j * D + c];
                  e[c] += phi[j] * r[j * D + c];
                }
              });
    for_nodes(num,
              [&](int j)
              {
#pragma GCC unroll 4
                for (int c = 0; c < D; ++c)
                  r[j * D + c] -= mean[c];
#pragma GCC unroll 4
                for (int c = 0; c < D; ++c)
#pragma GCC unroll 4
                  for (int d = 0; d <= c; ++d)
                    squares[c][d] += r[j * D + c] * r[j * D + d];
              });
    if constexpr (D == 2)
      inverse[0] = 1.0 / (squares[0][0] + squares[1][1]);
    else
    {
      // Inverse of sum |r|^2 I - r r^T, symmetric: xx, yy, zz, xy, xz, yz.
      const T trace = squares[0][0] + squares[1][1] + squares[2][2];
      const T xx = trace - squares[0][0], yy = trace - squares[1][1], zz = trace - squares[2][2];
      const T xy = -squares[1][0], xz = -squares[2][0], yz = -squares[2][1];
      const T a = yy * zz - yz * yz, b = xz * yz - xy * zz, c = xy * yz - xz * yy;
      const T per = 1.0 / (xx * a + xy * b + xz * c);
      inverse[0] = a * per;
      inverse[1] = (xx * zz - xz * xz) * per;
      inverse[2] = (xx * yy - xy * xy) * per;
      inverse[3] = b * per;
      inverse[4] = c * per;
      inverse[5] = (xy * xz - xx * yz) * per;
    }
  }

  /// Add what the rotation of the facet's nodes gives to the increment of the slave's node relative to the master's
  /// point: what forces with their correction do work on, and no rotation of both bodies changes.
  /// @param[in] num,r as in `set`
  /// @param[in] increment increment(j, c) of node j [L]
  /// @param[in,out] motion relative to the point, which does not turn [L]
  template <int D>
  void add_rotation(int num, const T* r, auto&& increment, T* motion) const
  {
    if constexpr (D == 2)
    {
      T spin = {};
      for_nodes(num,
                [&](int j) { spin += inverse[0] * (r[2 * j] * increment(j, 1) - r[2 * j + 1] * increment(j, 0)); });
      motion[0] -= spin * e[1];
      motion[1] += spin * e[0];
    }
    else
    {
      T m[3] = {};
      for_nodes(num,
                [&](int j)
                {
                  const T* a = r + 3 * j;
                  const T du[3] = {increment(j, 0), increment(j, 1), increment(j, 2)};
                  m[0] += a[1] * du[2] - a[2] * du[1];
                  m[1] += a[2] * du[0] - a[0] * du[2];
                  m[2] += a[0] * du[1] - a[1] * du[0];
                });
      const T w[3] = {inverse[0] * m[0] + inverse[3] * m[1] + inverse[4] * m[2],
                      inverse[3] * m[0] + inverse[1] * m[1] + inverse[5] * m[2],
                      inverse[4] * m[0] + inverse[5] * m[1] + inverse[2] * m[2]};
      motion[0] += w[1] * e[2] - w[2] * e[1];
      motion[1] += w[2] * e[0] - w[0] * e[2];
      motion[2] += w[0] * e[1] - w[1] * e[0];
    }
  }

  /// @param[in] num,r as in `set`
  /// @param[in] f force on the slave's node
  /// @param[in,out] add add(j, c, value): value is component c of node j's force
  template <int D>
  void forces(int num, const T* r, const T* f, auto&& add) const
  {
    if constexpr (D == 2)
    {
      const T omega = inverse[0] * (e[0] * f[1] - e[1] * f[0]);
      for_nodes(num,
                [&](int j)
                {
                  add(j, 0, -omega * r[j * D + 1]);
                  add(j, 1, omega * r[j * D]);
                });
    }
    else
    {
      const T m[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
      const T w[3] = {inverse[0] * m[0] + inverse[3] * m[1] + inverse[4] * m[2],
                      inverse[3] * m[0] + inverse[1] * m[1] + inverse[5] * m[2],
                      inverse[4] * m[0] + inverse[5] * m[1] + inverse[2] * m[2]};
      for_nodes(num,
                [&](int j)
                {
                  const T* a = r + j * D;
                  add(j, 0, w[1] * a[2] - w[2] * a[1]);
                  add(j, 1, w[2] * a[0] - w[0] * a[2]);
                  add(j, 2, w[0] * a[1] - w[1] * a[0]);
                });
    }
  }
};
using MomentCorrection = MomentCorrectionOf<double>;
} // namespace dolfinx_impact::enforcement
