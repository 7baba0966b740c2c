// SPDX-License-Identifier: MIT
#include "cell_rotations.h"
#include <cmath>
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

template <int D>
CellGradient<D> cell_gradient(const CellVectors& v, std::int32_t cell)
{
  CellGradient<D> out;
  const std::size_t per_cell = v.derivatives.size() / D;
  const std::int32_t* nodes = v.nodes.data() + cell * per_cell;
  for (std::size_t n = 0; n < per_cell; ++n)
  {
    const double* value = v.values.data() + std::size_t(nodes[n]) * v.stride;
    for (int i = 0; i < D; ++i)
      for (int k = 0; k < D; ++k)
        out.at[i][k] += value[i] * v.derivatives[k * per_cell + n];
  }
  return out;
}

/// grad u = (du/dX)(dx/dX)^-1 by Cramer's rule.
double rotation_in_space(const CellGradient<3>& u, const CellGradient<3>& x)
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
  { return (u.at[i][0] * cofactor[j][0] + u.at[i][1] * cofactor[j][1] + u.at[i][2] * cofactor[j][2]) / determinant; };
  const double sine =
      std::hypot(gradient(1, 0) - gradient(0, 1), gradient(2, 0) - gradient(0, 2), gradient(2, 1) - gradient(1, 2));
  return std::abs(std::atan2(sine, 2.0 + gradient(0, 0) + gradient(1, 1) + gradient(2, 2)));
}

double rotation_in_plane(const CellGradient<2>& u, const CellGradient<2>& x)
{
  const auto& J = x.at;
  const double determinant = J[0][0] * J[1][1] - J[0][1] * J[1][0];
  const double inverse[2][2] = {{J[1][1] / determinant, -J[0][1] / determinant},
                                {-J[1][0] / determinant, J[0][0] / determinant}};
  const auto gradient = [&](int i, int j) { return u.at[i][0] * inverse[0][j] + u.at[i][1] * inverse[1][j]; };
  return std::abs(std::atan2(gradient(1, 0) - gradient(0, 1), 2.0 + gradient(0, 0) + gradient(1, 1)));
}
} // namespace

std::vector<double> cell_rotations(const CellVectors& positions, const CellVectors& displacements,
                                   std::span<const std::int32_t> cells, int gdim)
{
  if (gdim != 2 && gdim != 3)
    throw std::invalid_argument("cells turn in two or three dimensions, not in " + std::to_string(gdim));
  std::vector<double> out;
  out.reserve(cells.size());
  for (const std::int32_t cell : cells)
    out.push_back(gdim == 3
                      ? rotation_in_space(cell_gradient<3>(displacements, cell), cell_gradient<3>(positions, cell))
                      : rotation_in_plane(cell_gradient<2>(displacements, cell), cell_gradient<2>(positions, cell)));
  return out;
}
} // namespace dolfinx_impact::operators
