// SPDX-License-Identifier: MIT
#include "stable_step.h"
#include "../common/dolfinx_api.h"
#include <algorithm>
#include <basix/cell.h>
#include <cmath>
#include <limits>

namespace dolfinx_impact::integrators
{
double UniformDamping::rate(double square) const
{
  return alpha + beta * square + 2.0 * viscosity * std::sqrt(square);
}

double stable_step(double square, double rate, const UniformDamping& uniform, Scheme scheme)
{
  const double half = 0.5 * (rate + (scheme == Scheme::classical ? 0.0 : uniform.rate(square)));
  const double largest = half + std::sqrt(half * half + square);
  return largest > 0.0 ? 2.0 / largest : std::numeric_limits<double>::infinity();
}

std::vector<double> CellSteps::operator()(std::span<const double> squares, std::span<const double> rates) const
{
  std::vector<double> out(squares.size());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = stable_step(squares[i] + springs * springs, rates[i] + dampers, uniform, scheme);
  return out;
}

std::vector<double> cell_sizes(const dolfinx::mesh::Mesh<double>& mesh)
{
  const auto& topology = *mesh.topology();
  const auto edges = basix::cell::topology(dolfinx::mesh::cell_type_to_basix_type(topology.cell_type()))[1];
  const auto dofs = common::geometry_dofmap(mesh);
  const std::span<const double> x = mesh.geometry().x();
  std::vector<double> out(topology.index_map(topology.dim())->size_local(), std::numeric_limits<double>::infinity());
  for (std::size_t cell = 0; cell < out.size(); ++cell)
    for (const auto& edge : edges)
    {
      const double *a = x.data() + 3 * dofs(cell, edge[0]), *b = x.data() + 3 * dofs(cell, edge[1]);
      double square = 0.0;
      for (int c = 0; c < 3; ++c)
        square += (a[c] - b[c]) * (a[c] - b[c]);
      out[cell] = std::min(out[cell], std::sqrt(square));
    }
  return out;
}
} // namespace dolfinx_impact::integrators
