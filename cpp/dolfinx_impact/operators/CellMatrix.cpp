// SPDX-License-Identifier: MIT
#include "CellMatrix.h"
#include "../kernels/KernelTable.h"
#include <algorithm>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::operators
{
CellMatrix::CellMatrix(const impact_kernel& kernel)
    : _tabulate(kernels::tabulate(kernel, 1)), _num_rows(kernel.shape[0]), _num_columns(kernel.shape[1]),
      _size_w(kernel.size_w)
{
  if (kernel.rank == 2)
    return;
  for (int i = 0; i < kernel.num_coefficients; ++i)
    if (std::string(kernel.coefficients[i].name) == direction_name)
    {
      _first = kernel.coefficients[i].offset;
      _num_columns =
          (std::string(kernel.integral_type) == "interior_facet" ? 2 : 1) * kernel.coefficients[i].element.num_dofs;
    }
  if (kernel.rank != 1 || _first < 0)
    throw std::invalid_argument(std::string("kernel ") + kernel.name + " is of rank " + std::to_string(kernel.rank) +
                                ", not 2, and is linear in no direction: it has no matrix");
  _w.resize(_size_w);
  _column.resize(_num_rows);
}

void CellMatrix::add(double* A, const double* w, std::span<const double> c, const double* x, int facet)
{
  if (_first < 0)
    return _tabulate(A, w, c.data(), x, facet);
  std::copy_n(w, _size_w, _w.begin());
  std::fill_n(_w.begin() + _first, _num_columns, 0.0);
  for (int j = 0; j < _num_columns; ++j)
  {
    _w[_first + j] = 1.0;
    std::ranges::fill(_column, 0.0);
    _tabulate(_column.data(), _w.data(), c.data(), x, facet);
    for (int i = 0; i < _num_rows; ++i)
      A[std::size_t(_num_columns) * i + j] += _column[i];
    _w[_first + j] = 0.0;
  }
}
} // namespace dolfinx_impact::operators
