// SPDX-License-Identifier: MIT
#include "lump.h"
#include "../kernels/KernelTable.h"
#include "../kernels/check.h"
#include "CellValues.h"
#include <algorithm>
#include <dolfinx/fem/DofMap.h>
#include <stdexcept>

namespace dolfinx_impact::operators
{
std::vector<double> cell_masses_hrz(const Integral& mass, const FunctionSpace& V, const Coefficients& coefficients)
{
  const impact_kernel& k = *mass.kernel;
  kernels::check_space(k, k.arguments[0], V, "space");
  if (k.rank != 2 || int(mass.constants.size()) != k.size_c)
    throw std::invalid_argument(std::string("kernel ") + k.name + " is not a mass matrix with its constants");
  const impact_tabulate tabulate = kernels::tabulate(k, 1);
  CellValues values(k, V, coefficients);
  const int bs = V.dofmap()->bs(), n = k.shape[0];
  std::vector<double> M(std::size_t(n) * n), masses;
  masses.reserve(mass.entities.size() * n);
  for (std::int32_t cell : mass.entities)
  {
    const std::size_t start = masses.size();
    masses.resize(start + n);
    values.gather(cell);
    std::fill(M.begin(), M.end(), 0.0);
    tabulate(M.data(), values.w(), mass.constants.data(), values.nodes().data(), 0);
    for (int c = 0; c < bs; ++c)
    {
      double total = 0.0, trace = 0.0;
      for (int i = c; i < n; i += bs)
      {
        trace += M[std::size_t(n) * i + i];
        for (int j = c; j < n; j += bs)
          total += M[std::size_t(n) * i + j];
      }
      if (!(total > 0.0) || !(trace > 0.0))
        throw std::runtime_error("cell " + std::to_string(cell) + " of this rank has mass " + std::to_string(total) +
                                 ": check the density and the shape of the cell");
      for (int i = c; i < n; i += bs)
        masses[start + i] = total / trace * M[std::size_t(n) * i + i];
    }
  }
  return masses;
}

std::vector<double> cell_masses_nodal(const Integral& nodal, const Integral& row_sum, const FunctionSpace& V,
                                      const Coefficients& coefficients)
{
  for (const Integral* i : {&nodal, &row_sum})
  {
    if (i->kernel->rank != 1 || int(i->constants.size()) != i->kernel->size_c)
      throw std::invalid_argument(std::string("kernel ") + i->kernel->name +
                                  " is not a mass vector with its constants");
    kernels::check_space(*i->kernel, i->kernel->arguments[0], V, "test space");
  }
  CellValues nodal_values(*nodal.kernel, V, coefficients), row_values(*row_sum.kernel, V, coefficients);
  const int bs = V.dofmap()->bs(), n = nodal.kernel->shape[0];
  std::vector<double> at_nodes(n), exact(n), masses;
  masses.reserve(nodal.entities.size() * n);
  for (std::int32_t cell : nodal.entities)
  {
    nodal_values.gather(cell);
    row_values.gather(cell);
    std::fill(at_nodes.begin(), at_nodes.end(), 0.0);
    std::fill(exact.begin(), exact.end(), 0.0);
    kernels::tabulate(*nodal.kernel, 1)(at_nodes.data(), nodal_values.w(), nodal.constants.data(),
                                        nodal_values.nodes().data(), 0);
    kernels::tabulate(*row_sum.kernel, 1)(exact.data(), row_values.w(), row_sum.constants.data(),
                                          row_values.nodes().data(), 0);
    double sum = 0.0, mass = 0.0;
    for (int i = 0; i < n; ++i)
      sum += at_nodes[i], mass += exact[i];
    if (!(sum > 0.0) || !(mass > 0.0))
      throw std::runtime_error("cell " + std::to_string(cell) + " of this rank has mass " + std::to_string(mass / bs) +
                               ": check the density and the shape of the cell");
    for (int i = 0; i < n; ++i)
      masses.push_back(mass / sum * at_nodes[i]);
  }
  return masses;
}
} // namespace dolfinx_impact::operators
