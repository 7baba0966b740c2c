// SPDX-License-Identifier: MIT
#include "largest_rotation.h"
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::operators
{
namespace
{
template <int D>
struct CellGradient
{
  double at[D][D] = {}; ///< [i][k]: derivative of component i with respect to reference coordinate k
};

/// @tparam N nodes of a cell, so that the loop is unrolled; 0: any number
template <int D, int N>
CellGradient<D> cell_gradient(const CellVectors& v, std::size_t per_cell, std::int32_t cell)
{
  CellGradient<D> out;
  const std::size_t count = N > 0 ? N : per_cell;
  const std::int32_t* nodes = v.nodes.data() + cell * count;
  for (std::size_t n = 0; n < count; ++n)
  {
    const double* value = v.values.data() + std::size_t(nodes[n]) * v.stride;
    for (int i = 0; i < D; ++i)
      for (int k = 0; k < D; ++k)
        out.at[i][k] += value[i] * v.derivatives[k * count + n];
  }
  return out;
}

/// The legs of a right-angled triangle with the angle of rotation; that beside it is negative beyond a right angle, and
/// not a number for a cell without volume.
struct Legs
{
  double opposite_squared, beside;
};

/// The sign of a determinant, which is not that of a cell where it is zero.
double sign(double determinant)
{
  return determinant != 0.0 ? std::copysign(1.0, determinant) : std::numeric_limits<double>::quiet_NaN();
}

/// grad u = (du/dX)(dx/dX)^-1 by Cramer's rule, times the determinant.
Legs legs(const CellGradient<3>& u, const CellGradient<3>& x)
{
  const auto& J = x.at;
  double cofactor[3][3]; // of J[i][k]
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
    {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
      cofactor[i][k] = J[i1][k1] * J[i2][k2] - J[i1][k2] * J[i2][k1];
    }
  const double determinant = J[0][0] * cofactor[0][0] + J[0][1] * cofactor[0][1] + J[0][2] * cofactor[0][2];
  const auto gradient = [&](int i, int j)
  { return u.at[i][0] * cofactor[j][0] + u.at[i][1] * cofactor[j][1] + u.at[i][2] * cofactor[j][2]; };
  const double a = gradient(1, 0) - gradient(0, 1), b = gradient(2, 0) - gradient(0, 2),
               c = gradient(2, 1) - gradient(1, 2);
  const double beside = 2.0 * determinant + gradient(0, 0) + gradient(1, 1) + gradient(2, 2);
  return {a * a + b * b + c * c, sign(determinant) * beside};
}

Legs legs(const CellGradient<2>& u, const CellGradient<2>& x)
{
  const auto& J = x.at;
  const double determinant = J[0][0] * J[1][1] - J[0][1] * J[1][0];
  const double cofactor[2][2] = {{J[1][1], -J[1][0]}, {-J[0][1], J[0][0]}};
  const auto gradient = [&](int i, int j) { return u.at[i][0] * cofactor[j][0] + u.at[i][1] * cofactor[j][1]; };
  const double a = gradient(1, 0) - gradient(0, 1);
  return {a * a, sign(determinant) * (2.0 * determinant + gradient(0, 0) + gradient(1, 1))};
}

template <int D, int NU, int NX>
CellRotation search(const CellVectors& positions, const CellVectors& displacements, std::span<const std::int32_t> cells,
                    double beyond)
{
  const std::size_t num_u = displacements.derivatives.size() / D, num_x = positions.derivatives.size() / D;
  const double tangent = std::tan(beyond);
  CellRotation out{beyond, -1};
  for (const std::int32_t cell : cells)
  {
    const Legs l = legs(cell_gradient<D, NU>(displacements, num_u, cell), cell_gradient<D, NX>(positions, num_x, cell));
    const double bound = tangent * l.beside;
    if (l.beside > 0.0 && l.opposite_squared <= bound * bound)
      continue;
    const double angle = std::atan2(std::sqrt(l.opposite_squared), l.beside);
    if (angle > out.angle) // not where it is not a number
      out = {angle, cell};
  }
  return out.cell < 0 ? CellRotation{} : out;
}

template <int D>
CellRotation search(const CellVectors& positions, const CellVectors& displacements, std::span<const std::int32_t> cells,
                    double beyond)
{
  const std::size_t u = displacements.derivatives.size() / D, x = positions.derivatives.size() / D;
  return u == D + 1 && x == D + 1                  ? search<D, D + 1, D + 1>(positions, displacements, cells, beyond)
         : u == 1 << D && x == std::size_t(1) << D ? search<D, 1 << D, 1 << D>(positions, displacements, cells, beyond)
                                                   : search<D, 0, 0>(positions, displacements, cells, beyond);
}
} // namespace

CellRotation largest_rotation(const CellVectors& positions, const CellVectors& displacements,
                              std::span<const std::int32_t> cells, int gdim, double beyond)
{
  if (gdim != 2 && gdim != 3)
    throw std::invalid_argument("cells turn in two or three dimensions, not in " + std::to_string(gdim));
  if (!(beyond >= 0.0 && beyond < 0.5 * std::numbers::pi))
    throw std::invalid_argument("rotations beyond an angle from 0 to below pi/2 are looked for, not beyond " +
                                std::to_string(beyond));
  return gdim == 3 ? search<3>(positions, displacements, cells, beyond)
                   : search<2>(positions, displacements, cells, beyond);
}
} // namespace dolfinx_impact::operators
