// SPDX-License-Identifier: MIT
#include "LinearSums.h"
#include <algorithm>
#include <stdexcept>
#include <utility>

namespace dolfinx_impact::operators
{
namespace
{
template <int components>
void multiply_rows(std::span<const std::size_t> ends, const std::int32_t* columns, const double* entries,
                   const double* values, int stride, double* sums)
{
  std::size_t k = 0;
  for (std::size_t row = 0; row < ends.size(); ++row)
  {
    double sum[components] = {}; // which do not wait for each other
    for (; k < ends[row]; ++k)
    {
      const double* value = values + std::size_t(columns[k]) * stride;
      for (int c = 0; c < components; ++c)
        sum[c] += entries[components * k + c] * value[c];
    }
    sums[row] = sum[0];
    for (int c = 1; c < components; ++c)
      sums[row] += sum[c];
  }
}
} // namespace

LinearSums::LinearSums(std::span<const Batches> integrals, const std::string& field)
{
  for (const Batches& batches : integrals)
  {
    const int components = batches.nodes_of(field).block_size;
    if (_components != 0 && components != _components)
      throw std::invalid_argument("kernels differ in the number of components of " + field);
    _components = components;
  }
  if (_components != 2 && _components != 3 && !integrals.empty())
    throw std::invalid_argument("sums that are linear in " + field + " are for fields with two or three components");
  set_pattern(integrals, field);
  _entries.assign(_columns.size() * _components, 0.0);
  for (const Batches& batches : integrals)
    batches.each_matrix(
        field,
        [this](std::span<const std::int32_t> rows, std::span<const std::int32_t> columns, std::span<const double> A)
        {
          for (std::size_t i = 0; i < rows.size(); ++i)
            for (std::size_t j = 0; j < columns.size(); ++j)
            {
              double* to = _entries.data() + _components * entry(rows[i], columns[j]);
              const double* from = A.data() + _components * (i * columns.size() + j);
              for (int c = 0; c < _components; ++c)
                to[c] += from[c];
            }
        });
}

/// Columns of each row: first those of every cell, then each of them once.
void LinearSums::set_pattern(std::span<const Batches> integrals, const std::string& field)
{
  const auto each = [&](auto&& work)
  {
    for (const Batches& batches : integrals)
    {
      const auto rows = batches.nodes_of_test(), columns = batches.nodes_of(field);
      const std::size_t width = std::size_t(batches.width());
      for (std::size_t b = 0; b * rows.num_nodes * width < rows.numbers.size(); ++b)
        for (int i = 0; i < rows.num_nodes; ++i)
          for (std::size_t l = 0; l < width; ++l)
            for (int j = 0; j < columns.num_nodes; ++j)
              work(rows.numbers[(b * rows.num_nodes + i) * width + l],
                   columns.numbers[(b * columns.num_nodes + j) * width + l]);
    }
  };
  std::vector<std::size_t> counts;
  each(
      [&](std::int32_t row, std::int32_t)
      {
        if (std::size_t(row) >= counts.size())
          counts.resize(std::size_t(row) + 1, 0);
        ++counts[row];
      });
  std::vector<std::size_t> next(counts.size());
  std::size_t total = 0;
  for (std::size_t row = 0; row < counts.size(); ++row)
    next[row] = std::exchange(total, total + counts[row]);
  std::vector<std::int32_t> all(total);
  each([&](std::int32_t row, std::int32_t column) { all[next[row]++] = column; });
  _ends.reserve(counts.size());
  for (std::size_t row = 0; row < counts.size(); ++row)
  {
    const auto begin = all.begin() + std::ptrdiff_t(next[row] - counts[row]), end = begin + std::ptrdiff_t(counts[row]);
    std::sort(begin, end);
    _columns.insert(_columns.end(), begin, std::unique(begin, end));
    _ends.push_back(_columns.size());
  }
}

std::size_t LinearSums::entry(std::int32_t row, std::int32_t column) const
{
  const auto begin = _columns.begin() + std::ptrdiff_t(row == 0 ? 0 : _ends[row - 1]);
  return std::size_t(std::lower_bound(begin, _columns.begin() + std::ptrdiff_t(_ends[row]), column) - _columns.begin());
}

void LinearSums::multiply(const double* values, int stride, std::span<double> sums) const
{
  if (sums.size() < _ends.size())
    throw std::invalid_argument("the sums have " + std::to_string(sums.size()) + " nodes, their matrix " +
                                std::to_string(_ends.size()));
  const auto rows = _components == 2 ? multiply_rows<2> : multiply_rows<3>;
  rows(_ends, _columns.data(), _entries.data(), values, stride, sums.data());
  std::ranges::fill(sums.subspan(_ends.size()), 0.0);
}
} // namespace dolfinx_impact::operators
