// SPDX-License-Identifier: MIT
#include "CellMatrix.h"
#include "../kernels/KernelTable.h"
#include "lanes.h"
#include <algorithm>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::operators
{
CellMatrix::CellMatrix(const impact_kernel& kernel, std::optional<int> direction)
    : _width(kernels::width(kernel)), _tabulate(kernels::tabulate(kernel, _width)), _num_rows(kernel.shape[0]),
      _num_columns(kernel.shape[1]), _size_w(kernel.size_w), _size_A(kernel.size_A)
{
  if (kernel.rank == 2)
    return;
  for (int i = 0; i < kernel.num_coefficients; ++i)
    if (direction ? i == *direction : std::string(kernel.coefficients[i].name) == direction_name)
    {
      _first = kernel.coefficients[i].offset;
      _num_columns =
          (std::string(kernel.integral_type) == "interior_facet" ? 2 : 1) * kernel.coefficients[i].element.num_dofs;
    }
  if (kernel.rank != 1 || _first < 0)
    throw std::invalid_argument(std::string("kernel ") + kernel.name + " is of rank " + std::to_string(kernel.rank) +
                                ", not 2, and is linear in no direction: it has no matrix");
}

void CellMatrix::add(double* A, const double* w, std::span<const double> c, std::span<const double> x, int facet)
{
  if (_first < 0)
    _tabulate(A, w, c.data(), x.data(), facet);
  else
    add_columns(A, w, c, x, facet);
}

void CellMatrix::add_columns(double* A, const double* w, std::span<const double> c, std::span<const double> x,
                             int facet)
{
  const std::size_t size_A = whole_lines(std::size_t(_size_A) * _width),
                    size_w = whole_lines(std::size_t(_size_w) * _width), size_x = whole_lines(x.size() * _width);
  _buffer.resize(size_A + size_w + size_x + doubles_per_line);
  double *columns = aligned(_buffer.data()), *all_w = columns + size_A, *all_x = all_w + size_w;
  for (int i = 0; i < _size_w; ++i)
    std::fill_n(all_w + std::size_t(i) * _width, _width, w[i]);
  for (std::size_t i = 0; i < x.size(); ++i)
    std::fill_n(all_x + i * _width, _width, x[i]);
  double* direction = all_w + std::size_t(_first) * _width;
  std::fill_n(direction, std::size_t(_num_columns) * _width, 0.0);
  for (int j = 0; j < _num_columns; j += _width)
  {
    const int used = std::min(_width, _num_columns - j);
    for (int lane = 0; lane < used; ++lane)
      direction[std::size_t(j + lane) * _width + lane] = 1.0;
    std::fill_n(columns, size_A, 0.0);
    _tabulate(columns, all_w, c.data(), all_x, facet);
    for (int i = 0; i < _num_rows; ++i)
      for (int lane = 0; lane < used; ++lane)
        A[std::size_t(_num_columns) * i + j + lane] += columns[std::size_t(i) * _width + lane];
    for (int lane = 0; lane < used; ++lane)
      direction[std::size_t(j + lane) * _width + lane] = 0.0;
  }
}
} // namespace dolfinx_impact::operators
