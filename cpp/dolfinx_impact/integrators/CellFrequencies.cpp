// SPDX-License-Identifier: MIT
#include "CellFrequencies.h"
#include "../common/OnAllRanks.h"
#include "../common/dolfinx_api.h"
#include "../common/gather.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/la/Vector.h>

namespace dolfinx_impact::integrators
{
CellFrequencies::CellFrequencies(std::shared_ptr<const operators::FunctionSpace> V,
                                 std::shared_ptr<operators::CellBounds> stiffness,
                                 std::shared_ptr<operators::CellBounds> damping, Masses masses)
    : _space(std::move(V)), _stiffness(std::move(stiffness)), _damping(std::move(damping)), _masses(std::move(masses))
{
}

std::size_t CellFrequencies::width() const
{
  return std::size_t(_space->dofmap()->bs()) * _space->dofmap()->element_dof_layout().num_dofs();
}

std::vector<double> CellFrequencies::masses(operators::CellMask only) const
{
  const std::size_t n = width(), bs = std::size_t(_space->dofmap()->bs());
  std::vector<double> out;
  if (!_kept)
  {
    out = _masses();
    if (_keeps)
    {
      _by_node = true;
      for (std::size_t i = 0; _by_node && i < out.size(); i += bs)
        _by_node = std::all_of(out.begin() + i, out.begin() + i + bs, [&](double m) { return m == out[i]; });
      const std::size_t step = _by_node ? bs : 1;
      _kept.emplace(out.size() / step);
      for (std::size_t i = 0; i < _kept->size(); ++i)
        (*_kept)[i] = out[i * step];
    }
  }
  else
  {
    const std::size_t step = _by_node ? bs : 1;
    out.resize(_kept->size() * step);
    for (std::size_t cell = 0; cell < out.size() / n; ++cell)
      if (!only || (*only)[cell])
        for (std::size_t i = cell * n; i < (cell + 1) * n; ++i)
          out[i] = (*_kept)[i / step];
  }
  for (std::size_t cell = 0; cell < _factor.size(); ++cell)
    for (std::size_t i = 0; i < n; ++i)
      out[cell * n + i] *= _factor[cell];
  return out;
}

CellFrequencies::Spectra CellFrequencies::by_cell(operators::CellMask only)
{
  // Facets belong to two cells, of which one may not be asked for.
  const bool joins = _stiffness->joins_cells() || (_damping && _damping->joins_cells());
  const std::vector<double> m = masses(joins ? std::nullopt : only);
  const std::size_t num = m.size() / width();
  const auto largest = [&](operators::CellBounds& bounds)
  {
    const std::vector<double> found = bounds.spectra(m, only);
    std::vector<double> out;
    out.reserve(num);
    for (std::size_t cell = 0; cell < num; ++cell)
      if (!only || (*only)[cell])
        out.push_back(std::max(found[3 * cell + 1], 0.0));
    return out;
  };
  Spectra out;
  out.squares = largest(*_stiffness);
  out.rates = _damping ? largest(*_damping) : std::vector<double>(out.squares.size(), 0.0);
  ++_num_looks;
  _num_cells += std::int64_t(out.squares.size());
  return out;
}

std::vector<double> CellFrequencies::nodal_stiffness(std::span<const std::int8_t> nodes)
{
  const auto& dofmap = *_space->dofmap();
  const std::vector<double> m = masses();
  const std::size_t n = width(), bs = dofmap.bs(), num = m.size() / n;
  std::vector<std::int8_t> near(num, 0);
  for (std::size_t cell = 0; cell < num; ++cell)
    near[cell] = std::ranges::any_of(dofmap.cell_dofs(cell), [&](std::int32_t node) { return nodes[node] != 0; });
  std::vector<double> spectra(3 * num, 0.0);
  try
  {
    spectra = _stiffness->spectra(m, near, false);
  }
  catch (const common::BadValue&) // on all ranks: a residual that is not a number at rest
  {
  }
  dolfinx::la::Vector<double> sums(dofmap.index_map, 1);
  common::fill(sums, 0.0);
  for (std::size_t cell = 0; cell < num; ++cell)
    if (near[cell])
      for (std::size_t i = 0; i < n / bs; ++i)
      {
        double mean = 0.0;
        for (std::size_t c = 0; c < bs; ++c)
          mean += m[cell * n + i * bs + c] / double(bs);
        common::array(sums)[dofmap.cell_dofs(cell)[i]] += mean * std::max(spectra[3 * cell + 1], 0.0);
      }
  sums.scatter_rev(std::plus<double>());
  sums.scatter_fwd();
  return {sums.array().begin(), sums.array().end()};
}

double CellFrequencies::scale_mass(double dt)
{
  const Spectra found = by_cell();
  const std::vector<double> m = masses();
  const std::size_t n = width();
  std::vector<double> factor(found.squares.size());
  double added = 0.0;
  for (std::size_t cell = 0; cell < factor.size(); ++cell)
  {
    factor[cell] = std::max(1.0, 0.25 * dt * dt * found.squares[cell] + 0.5 * dt * found.rates[cell]);
    for (std::size_t i = 0; i < n; ++i)
      added += (factor[cell] - 1.0) * m[cell * n + i];
  }
  _factor = std::move(factor);
  const auto& mesh = *_space->mesh();
  return common::sum(mesh.comm(), added) / double(mesh.geometry().dim());
}

std::vector<double> CellFrequencies::nodal_masses() const
{
  const auto& dofmap = *_space->dofmap();
  const std::vector<double> m = masses();
  const std::size_t n = width(), bs = dofmap.bs();
  dolfinx::la::Vector<double> sums(dofmap.index_map, dofmap.index_map_bs());
  common::fill(sums, 0.0);
  for (std::size_t cell = 0; cell < m.size() / n; ++cell)
    for (std::size_t i = 0; i < n / bs; ++i)
      for (std::size_t c = 0; c < bs; ++c)
        common::array(sums)[bs * dofmap.cell_dofs(cell)[i] + c] += m[cell * n + i * bs + c];
  sums.scatter_rev(std::plus<double>());
  sums.scatter_fwd();
  return {sums.array().begin(), sums.array().end()};
}
} // namespace dolfinx_impact::integrators
