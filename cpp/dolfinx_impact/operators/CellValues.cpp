// SPDX-License-Identifier: MIT
#include "CellValues.h"
#include "../kernels/check.h"
#include <algorithm>
#include <dolfinx/fem/DofMap.h>
#include <stdexcept>

namespace dolfinx_impact::operators
{
CellValues::CellValues(const impact_kernel& kernel, const FunctionSpace& V,
                       const std::map<std::string, std::shared_ptr<const Function>>& coefficients)
    : _kernel(kernel), _space(V), _w(kernel.size_w),
      _nodes((std::string(kernel.integral_type) == "interior_facet" ? 6 : 3) * V.mesh()->geometry().dofmap().extent(1))
{
  kernels::check_mesh(kernel, *V.mesh());
  kernels::check_without_outputs(kernel);
  for (int i = 0; i < kernel.num_coefficients; ++i)
  {
    const impact_coefficient& c = kernel.coefficients[i];
    const auto found = coefficients.find(c.name);
    if (found == coefficients.end() || !found->second)
      throw std::invalid_argument(std::string("kernel ") + kernel.name + " needs a coefficient named '" + c.name + "'");
    const FunctionSpace& space = *found->second->function_space();
    kernels::check_space(kernel, c.element, space, std::string("coefficient ") + c.name);
    if (space.mesh() != V.mesh())
      throw std::invalid_argument(std::string("kernel ") + kernel.name + ": coefficient " + c.name +
                                  " is on another mesh");
    _functions.push_back(found->second);
  }
}

void CellValues::gather(std::int32_t cell, int side)
{
  const auto x_dofmap = _space.mesh()->geometry().dofmap();
  const auto x = _space.mesh()->geometry().x();
  double* nodes = _nodes.data() + 3 * side * x_dofmap.extent(1);
  for (std::size_t i = 0; i < x_dofmap.extent(1); ++i)
    std::copy_n(x.data() + 3 * std::size_t(x_dofmap(cell, i)), 3, nodes + 3 * i);
  for (std::size_t c = 0; c < _functions.size(); ++c)
  {
    const auto& map = *_functions[c]->function_space()->dofmap();
    const auto dofs = map.cell_dofs(cell);
    const std::span<const double> values = _functions[c]->x()->array();
    double* w = _w.data() + _kernel.coefficients[c].offset + side * dofs.size() * map.bs();
    for (std::size_t i = 0; i < dofs.size(); ++i)
      for (int b = 0; b < map.bs(); ++b)
        w[i * map.bs() + b] = values[std::size_t(dofs[i]) * map.bs() + b];
  }
}
} // namespace dolfinx_impact::operators
