// SPDX-License-Identifier: MIT
#include "CellValues.h"
#include "../common/dolfinx_api.h"
#include "../kernels/check.h"
#include "CellMatrix.h"
#include <algorithm>
#include <dolfinx/fem/DofMap.h>
#include <stdexcept>

namespace dolfinx_impact::operators
{
CellValues::CellValues(const impact_kernel& kernel, const FunctionSpace& V, const Coefficients& coefficients,
                       int num_cells)
    : CellValues(kernel, V, sources(kernel, coefficients, nullptr), nullptr, num_cells)
{
}

CellValues::CellValues(const impact_kernel& kernel, const FunctionSpace& V, std::vector<Source> sources,
                       std::shared_ptr<const PointHistory> history, int num_cells)
    : _kernel(kernel), _space(V), _sources(std::move(sources)), _fields(_sources.size()), _history(std::move(history)),
      _num_cells(num_cells), _w(std::size_t(kernel.size_w) * num_cells),
      _nodes((std::string(kernel.integral_type) == "interior_facet" ? 6 : 3) *
             common::geometry_dofmap(*V.mesh()).extent(1) * num_cells)
{
  kernels::check_mesh(kernel, *V.mesh());
  kernels::check_without_outputs(kernel);
  if (int(_sources.size()) != kernel.num_coefficients)
    throw std::invalid_argument(std::string("kernel ") + kernel.name + " reads " +
                                std::to_string(kernel.num_coefficients) + " coefficients, found " +
                                std::to_string(_sources.size()));
  for (int i = 0; i < kernel.num_coefficients; ++i)
  {
    if (!_sources[i].field.empty())
      _fields[i] = _history->find(_sources[i].field);
    check(i);
  }
  if (!_history)
    return;
  const auto cells = V.mesh()->topology()->index_map(V.mesh()->topology()->dim());
  _places.assign(cells->size_local() + cells->num_ghosts(), -1);
  for (std::size_t i = 0; i < _history->cells().size(); ++i)
    _places[_history->cells()[i]] = std::int32_t(i);
}

std::vector<CellValues::Source> CellValues::sources(const impact_kernel& kernel, const Coefficients& coefficients,
                                                    const PointHistory* history)
{
  std::vector<Source> out;
  for (int i = 0; i < kernel.num_coefficients; ++i)
  {
    const impact_coefficient& c = kernel.coefficients[i];
    const auto found = coefficients.find(c.name);
    if (found != coefficients.end() && found->second)
      out.push_back({found->second, ""});
    else if (std::string(c.name) == direction_name)
      out.emplace_back();
    else if (history && std::string(c.element.kind) == "quadrature")
      out.push_back({nullptr, c.name});
    else
      throw std::invalid_argument(std::string("kernel ") + kernel.name + " needs a coefficient named '" + c.name + "'");
  }
  return out;
}

void CellValues::check(int coefficient) const
{
  const impact_coefficient& c = _kernel.coefficients[coefficient];
  const std::string kernel = std::string("kernel ") + _kernel.name;
  if (const auto& f = _sources[coefficient].function)
  {
    kernels::check_space(_kernel, c.element, *f->function_space(), std::string("coefficient ") + c.name);
    if (f->function_space()->mesh() != _space.mesh())
      throw std::invalid_argument(kernel + ": coefficient " + c.name + " is on another mesh");
  }
  if (_sources[coefficient].field.empty())
    return;
  const int size = _history->num_points() * _history->num_components(_fields[coefficient]);
  if (size != c.element.num_dofs)
    throw std::invalid_argument(kernel + " reads " + std::to_string(c.element.num_dofs) + " values of '" + c.name +
                                "' in a cell, the history has " + std::to_string(size) +
                                ": use the same quadrature rule in both forms");
}

void CellValues::gather(std::span<const std::int32_t> cells)
{
  for (int lane = 0; lane < _num_cells; ++lane)
    gather(cells[std::min(std::size_t(lane), cells.size() - 1)], 0, lane);
}

void CellValues::gather(std::int32_t cell, int side, int lane)
{
  const std::size_t stride = _num_cells;
  const auto x_dofmap = common::geometry_dofmap(*_space.mesh());
  const auto x = _space.mesh()->geometry().x();
  double* nodes = _nodes.data() + 3 * side * x_dofmap.extent(1) * stride + lane;
  for (std::size_t i = 0; i < x_dofmap.extent(1); ++i)
    for (std::size_t d = 0; d < 3; ++d)
      nodes[(3 * i + d) * stride] = x[3 * std::size_t(x_dofmap(cell, i)) + d];
  for (std::size_t c = 0; c < _sources.size(); ++c)
  {
    if (!_sources[c].field.empty())
    {
      if (_places[cell] < 0)
        throw std::invalid_argument(std::string("kernel ") + _kernel.name + ": cell " + std::to_string(cell) +
                                    " of this rank has no history");
      _history_values.resize(_kernel.coefficients[c].element.num_dofs);
      _history->copy_cell(_fields[c], std::size_t(_places[cell]), _history_values.data());
      double* w = _w.data() + _kernel.coefficients[c].offset * stride + lane;
      for (std::size_t i = 0; i < _history_values.size(); ++i)
        w[i * stride] = _history_values[i];
    }
    if (!_sources[c].function)
      continue;
    const auto& map = *_sources[c].function->function_space()->dofmap();
    const auto dofs = map.cell_dofs(cell);
    const std::span<const double> values = _sources[c].function->x()->array();
    const std::size_t bs = map.bs();
    double* w = _w.data() + (_kernel.coefficients[c].offset + side * dofs.size() * bs) * stride + lane;
    for (std::size_t i = 0; i < dofs.size(); ++i)
      for (std::size_t b = 0; b < bs; ++b)
        w[(i * bs + b) * stride] = values[std::size_t(dofs[i]) * bs + b];
  }
}
} // namespace dolfinx_impact::operators
