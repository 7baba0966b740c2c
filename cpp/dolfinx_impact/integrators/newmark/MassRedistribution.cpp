// SPDX-License-Identifier: MIT
#include "MassRedistribution.h"
#include "../../common/dolfinx_api.h"
#include <dolfinx/fem/DirichletBC.h>
#include <dolfinx/la/Vector.h>
#include <functional>

namespace dolfinx_impact::integrators
{
namespace
{
/// Make a mask positive on all ranks that know a node where it is positive on one. Collective.
std::vector<std::int8_t> shared(dolfinx::la::Vector<double>& mask)
{
  mask.scatter_rev(std::plus<double>());
  mask.scatter_fwd();
  std::vector<std::int8_t> out;
  for (double value : mask.array())
    out.push_back(value > 0.0);
  return out;
}
} // namespace

MassRedistribution::MassRedistribution(std::shared_ptr<const Space> V, std::span<const std::int32_t> facets)
    : _space(std::move(V))
{
  const auto& dofmap = *_space->dofmap();
  const auto topology = _space->mesh()->topology_mutable();
  const int tdim = topology->dim();
  topology->create_connectivity(tdim - 1, tdim);
  dolfinx::la::Vector<double> mask(dofmap.index_map, 1), keeping(dofmap.index_map, 1);
  common::fill(mask, 0.0);
  common::fill(keeping, 0.0);
  for (std::int32_t node : dolfinx::fem::locate_dofs_topological(*topology, dofmap, tdim - 1, facets))
    common::array(mask)[node] = 1.0;
  _on_surface = shared(mask);
  const std::int32_t num_cells = topology->index_map(tdim)->size_local();
  for (std::int32_t cell = 0; cell < num_cells; ++cell)
  {
    std::size_t on = 0;
    const auto nodes = dofmap.cell_dofs(cell);
    for (std::int32_t node : nodes)
      on += _on_surface[node];
    if (on == nodes.size())
      for (std::int32_t node : nodes)
        common::array(keeping)[node] = 1.0;
    else if (on > 0)
      _cells.push_back(cell);
  }
  const std::vector<std::int8_t> keeps = shared(keeping);
  for (std::size_t i = 0; i < keeps.size(); ++i)
    _massless.push_back(_on_surface[i] && !keeps[i]);
  _x = _space->tabulate_dof_coordinates(false);
}

std::vector<double> MassRedistribution::weights(std::int32_t cell) const
{
  const auto nodes = _space->dofmap()->cell_dofs(cell);
  const std::size_t n = nodes.size();
  std::vector<double> T(n * n, 0.0);
  for (std::size_t i = 0; i < n; ++i)
  {
    if (!_on_surface[nodes[i]])
    {
      T[i * n + i] = 1.0;
      continue;
    }
    double sum = 0.0;
    for (std::size_t j = 0; j < n; ++j)
    {
      if (_on_surface[nodes[j]])
        continue;
      double square = 0.0;
      for (int c = 0; c < 3; ++c)
      {
        const double d = _x[3 * nodes[j] + c] - _x[3 * nodes[i] + c];
        square += d * d;
      }
      sum += T[i * n + j] = 1.0 / square;
    }
    for (std::size_t j = 0; j < n; ++j)
      T[i * n + j] /= sum;
  }
  return T;
}

std::vector<double> MassRedistribution::matrix(std::int32_t cell, std::span<const double> M) const
{
  const std::vector<double> T = weights(cell);
  const std::size_t n = _space->dofmap()->cell_dofs(cell).size(), bs = _space->dofmap()->bs(), size = n * bs;
  // The components of T are those of its nodes: first M T, then T^T (M T).
  std::vector<double> product(size * size, 0.0), out(size * size, 0.0);
  for (std::size_t row = 0; row < size; ++row)
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t j = 0; j < n; ++j)
        for (std::size_t c = 0; c < bs; ++c)
          product[row * size + j * bs + c] += M[row * size + k * bs + c] * T[k * n + j];
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t c = 0; c < bs; ++c)
        for (std::size_t column = 0; column < size; ++column)
          out[(i * bs + c) * size + column] += T[k * n + i] * product[(k * bs + c) * size + column];
  return out;
}

std::vector<double> MassRedistribution::lumped(std::int32_t cell, std::span<const double> masses) const
{
  const std::vector<double> T = weights(cell);
  const std::size_t n = _space->dofmap()->cell_dofs(cell).size(), bs = masses.size() / n;
  std::vector<double> out(masses.size(), 0.0);
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t c = 0; c < bs; ++c)
        out[i * bs + c] += T[k * n + i] * masses[k * bs + c];
  return out;
}
} // namespace dolfinx_impact::integrators
