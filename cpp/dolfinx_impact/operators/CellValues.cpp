// SPDX-License-Identifier: MIT
#include "CellValues.h"
#include "../kernels/check.h"
#include "CellMatrix.h"
#include <algorithm>
#include <dolfinx/fem/DofMap.h>
#include <stdexcept>

namespace dolfinx_impact::operators
{
CellValues::CellValues(const impact_kernel& kernel, const FunctionSpace& V, const Coefficients& coefficients,
                       std::shared_ptr<const PointHistory> history)
    : _kernel(kernel), _space(V), _history(std::move(history)), _w(kernel.size_w),
      _nodes((std::string(kernel.integral_type) == "interior_facet" ? 6 : 3) * V.mesh()->geometry().dofmap().extent(1))
{
  kernels::check_mesh(kernel, *V.mesh());
  kernels::check_without_outputs(kernel);
  for (int i = 0; i < kernel.num_coefficients; ++i)
    _sources.push_back(source(kernel.coefficients[i], coefficients));
  if (!_history)
    return;
  const auto cells = V.mesh()->topology()->index_map(V.mesh()->topology()->dim());
  _places.assign(cells->size_local() + cells->num_ghosts(), -1);
  for (std::size_t i = 0; i < _history->cells().size(); ++i)
    _places[_history->cells()[i]] = std::int32_t(i);
}

CellValues::Source CellValues::source(const impact_coefficient& c, const Coefficients& coefficients) const
{
  const std::string kernel = std::string("kernel ") + _kernel.name;
  const auto found = coefficients.find(c.name);
  if (found != coefficients.end() && found->second)
  {
    const FunctionSpace& space = *found->second->function_space();
    kernels::check_space(_kernel, c.element, space, std::string("coefficient ") + c.name);
    if (space.mesh() != _space.mesh())
      throw std::invalid_argument(kernel + ": coefficient " + c.name + " is on another mesh");
    return {found->second, std::nullopt};
  }
  if (std::string(c.name) == direction_name)
    return {};
  if (!_history || std::string(c.element.kind) != "quadrature")
    throw std::invalid_argument(kernel + " needs a coefficient named '" + c.name + "'");
  const std::size_t field = _history->find(c.name);
  const int size = _history->num_points() * _history->num_components(field);
  if (size != c.element.num_dofs)
    throw std::invalid_argument(kernel + " reads " + std::to_string(c.element.num_dofs) + " values of '" + c.name +
                                "' in a cell, the history has " + std::to_string(size) +
                                ": use the same quadrature rule in both forms");
  return {nullptr, field};
}

void CellValues::gather(std::int32_t cell, int side)
{
  const auto x_dofmap = _space.mesh()->geometry().dofmap();
  const auto x = _space.mesh()->geometry().x();
  double* nodes = _nodes.data() + 3 * side * x_dofmap.extent(1);
  for (std::size_t i = 0; i < x_dofmap.extent(1); ++i)
    std::copy_n(x.data() + 3 * std::size_t(x_dofmap(cell, i)), 3, nodes + 3 * i);
  for (std::size_t c = 0; c < _sources.size(); ++c)
  {
    if (_sources[c].field)
    {
      if (_places[cell] < 0)
        throw std::invalid_argument(std::string("kernel ") + _kernel.name + ": cell " + std::to_string(cell) +
                                    " of this rank has no history");
      _history->copy_cell(*_sources[c].field, std::size_t(_places[cell]), _w.data() + _kernel.coefficients[c].offset);
    }
    if (!_sources[c].function)
      continue;
    const auto& map = *_sources[c].function->function_space()->dofmap();
    const auto dofs = map.cell_dofs(cell);
    const std::span<const double> values = _sources[c].function->x()->array();
    double* w = _w.data() + _kernel.coefficients[c].offset + side * dofs.size() * map.bs();
    for (std::size_t i = 0; i < dofs.size(); ++i)
      for (int b = 0; b < map.bs(); ++b)
        w[i * map.bs() + b] = values[std::size_t(dofs[i]) * map.bs() + b];
  }
}
} // namespace dolfinx_impact::operators
