// SPDX-License-Identifier: MIT
#include "LinearSums.h"
#include "strain_rows.h"
#include <algorithm>
#include <cmath>
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
    const int components = batches.nodes_of(field).block_size, measures = batches.block_size();
    if (_components != 0 && (components != _components || measures != _measures))
      throw std::invalid_argument("kernels differ in the number of components of " + field + " or of their values");
    _components = components;
    _measures = measures;
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
              add_gradients(A, i, j, columns.size(), _entries.data() + _components * entry(rows[i], columns[j]));
        });
}

/// Adds the integral of N_a grad N_b, which the trace of what is summed up has as its coefficients.
/// @param A matrix of a cell, rows first
/// @param row number a of the cell's nodes
/// @param column number b
void LinearSums::add_gradients(std::span<const double> A, std::size_t row, std::size_t column, std::size_t num_columns,
                               double* to) const
{
  const auto at = [&](int r, int c)
  { return A[(_measures * row + r) * _components * num_columns + _components * column + c]; };
  const int d = _components;
  const bool whole = _measures == d * d; // the gradient; of others in the plane a strain has three sums, in space six
  double gradient[3] = {};
  for (int c = 0; c < d; ++c)
    gradient[c] = whole ? at(gradient_place(d, 0, c), 0) : at(_measures == 1 ? 0 : c, c);
  for (int c = 0; c < d; ++c)
    to[c] += gradient[c];
  if (_measures == 1)
    return;
  if (!whole && _measures != d * (d + 1) / 2)
    throw std::invalid_argument("a node has " + std::to_string(_measures) + " sums: these are no strain or gradient");
  const double size = std::abs(gradient[0]) + std::abs(gradient[1]) + std::abs(gradient[2]);
  const auto check = [&](int place, int c, double expected)
  {
    if (!(std::abs(at(place, c) - expected) <= 1e-12 * size)) // round-off of sums of a few products
      throw std::invalid_argument("the sums of a node are not those of a strain or gradient");
  };
  for (int i = 0; i < d; ++i)
    for (int j = 0; j < d; ++j)
      for (int c = 0; c < d; ++c)
        if (whole)
          check(gradient_place(d, i, j), c, c == i ? gradient[j] : 0.0);
        else
          check(strain_place(d, i, j), c, ((c == i ? gradient[j] : 0.0) + (c == j ? gradient[i] : 0.0)) / 2);
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

void LinearSums::check_size(std::span<const double> sums) const
{
  if (sums.size() < _measures * _ends.size())
    throw std::invalid_argument("the sums have " + std::to_string(sums.size() / _measures) + " nodes, their matrix " +
                                std::to_string(_ends.size()));
}

void LinearSums::check_law(const MeanStress& stress) const
{
  const int expected = num_means(stress.law, _components);
  if (_measures != expected && !_ends.empty())
    throw std::invalid_argument("a node has " + std::to_string(_measures) + " sums, the law of their stress takes " +
                                std::to_string(expected));
}

void LinearSums::multiply(const double* values, int stride, std::span<double> sums) const
{
  check_size(sums);
  if (_measures == 1)
  {
    const auto rows = _components == 2 ? multiply_rows<2> : multiply_rows<3>;
    rows(_ends, _columns.data(), _entries.data(), values, stride, sums.data());
  }
  else
  {
    const std::vector<std::int8_t> all(_ends.size(), 1);
    const bool whole = _measures == _components * _components;
    strain_rows({_ends, _columns.data(), _entries.data()}, _components, stride,
                {.stress = {.law = whole ? MeanLaw::neo_hookean : MeanLaw::linear_elastic},
                 .shared = all,
                 .values = values,
                 .sums = sums.data()});
  }
  std::ranges::fill(sums.subspan(_measures * _ends.size()), 0.0);
}

void LinearSums::add_forces(const MeanStress& stress, std::span<const double> inverse_volumes,
                            std::span<const std::int8_t> shared, const double* values, int stride,
                            std::span<double> sums, double* b) const
{
  check_size(sums);
  check_law(stress);
  strain_rows({_ends, _columns.data(), _entries.data()}, _components, stride,
              {stress, inverse_volumes, shared, values, sums.data(), b});
}

void LinearSums::add_forces_of(std::span<const std::int32_t> nodes, const MeanStress& stress,
                               std::span<const double> means, int stride, double* b) const
{
  check_size(means);
  check_law(stress);
  forces_of_rows({_ends, _columns.data(), _entries.data()}, _components, stride, nodes, stress, means.data(), b);
}
} // namespace dolfinx_impact::operators
