// SPDX-License-Identifier: MIT
#include "lump.h"
#include "../kernels/KernelTable.h"
#include "../kernels/check.h"
#include "CellValues.h"
#include "lanes.h"
#include <algorithm>
#include <dolfinx/fem/DofMap.h>
#include <span>
#include <stdexcept>

namespace dolfinx_impact::operators
{
namespace
{
/// Element vectors or matrices of cells, one after the other; the kernel computes as many as it takes at a time.
class CellTensors
{
public:
  /// @param[in] integral kernel over cells without internal variables; it outlives this object, as V does
  CellTensors(const Integral& integral, const FunctionSpace& V, const Coefficients& coefficients)
      : _integral(integral), _width(kernels::width(*integral.kernel)),
        _tabulate(kernels::tabulate(*integral.kernel, _width)), _values(*integral.kernel, V, coefficients, _width),
        _all(std::size_t(integral.kernel->size_A) * _width), _one(integral.kernel->size_A)
  {
  }

  /// Of cell number e of the integral, row by row. Numbers are asked for in their order, from zero.
  std::span<const double> at(std::size_t e)
  {
    const std::size_t lane = e % _width;
    if (lane == 0)
    {
      const std::span<const std::int32_t> cells(_integral.entities);
      _values.gather(cells.subspan(e, std::min(std::size_t(_width), cells.size() - e)));
      std::ranges::fill(_all, 0.0);
      _tabulate(_all.data(), _values.w(), _integral.constants.data(), _values.nodes().data(), 0);
    }
    for (std::size_t i = 0; i < _one.size(); ++i)
      _one[i] = _all[i * _width + lane];
    return _one;
  }

private:
  const Integral& _integral;
  int _width;
  impact_tabulate _tabulate;
  CellValues _values;
  AlignedVector _all; ///< of all lanes
  std::vector<double> _one;
};
} // namespace

std::vector<double> cell_masses_hrz(const Integral& mass, const FunctionSpace& V, const Coefficients& coefficients)
{
  const impact_kernel& k = *mass.kernel;
  kernels::check_space(k, k.arguments[0], V, "space");
  if (k.rank != 2 || int(mass.constants.size()) != k.size_c)
    throw std::invalid_argument(std::string("kernel ") + k.name + " is not a mass matrix with its constants");
  CellTensors matrices(mass, V, coefficients);
  const int bs = V.dofmap()->bs(), n = k.shape[0];
  std::vector<double> masses(mass.entities.size() * n);
  for (std::size_t e = 0; e < mass.entities.size(); ++e)
  {
    const std::size_t start = e * n;
    const std::span<const double> M = matrices.at(e);
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
        throw std::runtime_error("cell " + std::to_string(mass.entities[e]) + " of this rank has mass " +
                                 std::to_string(total) + ": check the density and the shape of the cell");
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
  if (nodal.entities != row_sum.entities)
    throw std::invalid_argument("the masses at nodes and their sums are of other cells");
  const bool same = nodal.kernel == row_sum.kernel && nodal.constants == row_sum.constants;
  CellTensors nodal_masses(nodal, V, coefficients), row_sums(row_sum, V, coefficients);
  const int bs = V.dofmap()->bs(), n = nodal.kernel->shape[0];
  std::vector<double> masses;
  masses.reserve(nodal.entities.size() * n);
  for (std::size_t e = 0; e < nodal.entities.size(); ++e)
  {
    const std::span<const double> at_nodes = nodal_masses.at(e), exact = same ? at_nodes : row_sums.at(e);
    double sum = 0.0, mass = 0.0;
    for (int i = 0; i < n; ++i)
      sum += at_nodes[i], mass += exact[i];
    if (!(sum > 0.0) || !(mass > 0.0))
      throw std::runtime_error("cell " + std::to_string(nodal.entities[e]) + " of this rank has mass " +
                               std::to_string(mass / bs) + ": check the density and the shape of the cell");
    for (int i = 0; i < n; ++i)
      masses.push_back(mass / sum * at_nodes[i]);
  }
  return masses;
}
} // namespace dolfinx_impact::operators
