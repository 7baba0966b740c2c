// SPDX-License-Identifier: MIT
#include "UpdatedFactors.h"
#include "dense.h"
#include <algorithm>
#include <array>
#include <utility>

namespace dolfinx_impact::solve
{
namespace
{
double product_of(std::span<const double> a, std::span<const double> b)
{
  // Several sums, as one would wait for every addition.
  constexpr std::size_t num = 8;
  std::array<double, num> sums{};
  const std::size_t whole = a.size() / num * num;
  for (std::size_t i = 0; i < whole; i += num)
    for (std::size_t k = 0; k < num; ++k)
      sums[k] += a[i + k] * b[i + k];
  double out = 0.0;
  for (double sum : sums)
    out += sum;
  for (std::size_t i = whole; i < a.size(); ++i)
    out += a[i] * b[i];
  return out;
}

/// Entries that are not zero: forces on a node and the facets that face it are few.
std::vector<std::pair<std::size_t, double>> entries_of(std::span<const double> values)
{
  std::vector<std::pair<std::size_t, double>> out;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] != 0.0)
      out.emplace_back(i, values[i]);
  return out;
}
} // namespace

UpdatedFactors::UpdatedFactors(MPI_Comm comm, Mat factors, std::shared_ptr<enforcement::Condensation> condensation,
                               std::vector<std::int8_t> pinned, std::vector<std::int8_t> active,
                               std::vector<Column> columns, const Product& product)
    : _comm(comm), _factors(factors, std::move(condensation), std::move(pinned)), _active(std::move(active)),
      _columns(std::move(columns))
{
  const std::size_t n = _columns.size();
  const bool any_opened = std::ranges::any_of(_columns, &Column::opened);
  _matrix.assign(n * n, 0.0);
  std::vector<std::vector<std::pair<std::size_t, double>>> pressed;
  for (Column& column : _columns)
  {
    pressed.push_back(entries_of(column.force));
    column.force = {};
  }
  for (std::size_t j = 0; j < n; ++j)
  {
    const std::vector<double> forces = any_opened ? product(_columns[j].increment) : std::vector<double>();
    for (std::size_t i = 0; i < n; ++i)
      // The gap of a node that has closed is zero, and so is the force along the gap of one that has opened.
      if (_columns[i].opened)
        _matrix[i * n + j] = product_of(_columns[i].increment, forces);
      else
        for (const auto& [at, force] : pressed[i])
          _matrix[i * n + j] += force * _columns[j].increment[at];
  }
  MPI_Allreduce(MPI_IN_PLACE, _matrix.data(), int(_matrix.size()), MPI_DOUBLE, MPI_SUM, _comm);
}

void UpdatedFactors::select(CondensedSystem& system, std::span<const std::int64_t> numbers,
                            std::span<const std::int8_t> active)
{
  const std::size_t n = _columns.size();
  std::vector<std::int8_t> wanted(n, 0);
  _num_missing = active.size() == _active.size() ? 0 : std::int64_t(active.size());
  for (std::size_t i = 0; i < active.size() && active.size() == _active.size(); ++i)
  {
    if (bool(active[i]) == bool(_active[i]))
      continue;
    const auto at = std::ranges::find(_columns, numbers[i], &Column::node);
    if (at == _columns.end())
      ++_num_missing;
    else
      wanted[at - _columns.begin()] = 1;
  }
  MPI_Allreduce(MPI_IN_PLACE, wanted.data(), int(n), MPI_INT8_T, MPI_MAX, _comm);
  MPI_Allreduce(MPI_IN_PLACE, &_num_missing, 1, MPI_INT64_T, MPI_SUM, _comm);
  _chosen.clear();
  for (std::size_t k = 0; k < n; ++k)
    if (wanted[k])
      _chosen.push_back(k);
  std::vector<double> part;
  for (std::size_t i : _chosen)
    for (std::size_t j : _chosen)
      part.push_back(_matrix[i * n + j]);
  _inverse.clear();
  if (!_chosen.empty())
  {
    if (auto found = inverse(std::move(part), int(_chosen.size())))
      _inverse = std::move(*found);
    else
    {
      // The set of active nodes does not hold the bodies: the factors serve as they are.
      _num_missing += std::int64_t(_chosen.size());
      _chosen.clear();
    }
  }
  _system = &system;
  _system_id = system.id();
}

void UpdatedFactors::apply(Vec r, Vec z) const
{
  // Nodal forces of which the residual is the condensed one, and the displacements by the factors.
  const std::vector<double> forces = _system->forces(r);
  std::vector<double> moved = _factors.solve(forces);
  // What closed nodes are pressed with, and how far opened ones move.
  std::vector<double> sides;
  for (std::size_t k : _chosen)
    sides.push_back((_columns[k].opened ? 1.0 : -1.0) * product_of(_columns[k].increment, forces));
  MPI_Allreduce(MPI_IN_PLACE, sides.data(), int(sides.size()), MPI_DOUBLE, MPI_SUM, _comm);
  const std::vector<double> factors = dense_product(_inverse, sides, int(sides.size()));
  for (std::size_t k = 0; k < factors.size(); ++k)
  {
    const double* const column = _columns[_chosen[k]].increment.data();
    for (std::size_t i = 0; i < moved.size(); ++i)
      moved[i] += factors[k] * column[i];
  }
  _system->set_unknowns(moved, r, z);
}
} // namespace dolfinx_impact::solve
