// SPDX-License-Identifier: MIT
#include "ReleasedFactors.h"
#include "../operators/petsc_check.h"
#include "column_products.h"
#include "dense.h"
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>

using dolfinx_impact::operators::check;
using dolfinx_impact::operators::Entries;

namespace dolfinx_impact::solve
{
namespace
{
// Stiffness of combinations of columns that move nothing but what the system pins, over the largest: round-off.
constexpr double least_stiffness = 1e-9;
constexpr int block = 32; // columns that are multiplied together
} // namespace

std::int64_t ReleasedFactors::num_columns(MPI_Comm comm, const enforcement::Condensation& condensation)
{
  std::int64_t out = std::ranges::count_if(condensation.pinned(), [](std::int8_t pinned) { return pinned != 0; });
  MPI_Allreduce(MPI_IN_PLACE, &out, 1, MPI_INT64_T, MPI_SUM, comm);
  return out;
}

ReleasedFactors::ReleasedFactors(Mat factors, std::shared_ptr<enforcement::Condensation> condensation,
                                 std::vector<std::int8_t> pinned, Mat K)
    : _comm(PetscObjectComm(PetscObject(K))), _num_columns(int(num_columns(_comm, *condensation))),
      _factors(factors, std::move(condensation), std::move(pinned))
{
  const enforcement::Condensation& conditions = _factors.condensation();
  const std::size_t owned = _factors.num_owned();
  check(MatCreateVecs(K, &_moved, &_force), "vectors are made");
  // The constrained components of this rank, and the number of the first of them among those of all ranks.
  std::vector<std::int32_t> own;
  for (std::size_t i = 0; i < owned; ++i)
    if (conditions.pinned()[i])
      own.push_back(std::int32_t(i));
  int count = int(own.size()), first = 0;
  MPI_Exscan(&count, &first, 1, MPI_INT, MPI_SUM, _comm);
  int rank = 0;
  MPI_Comm_rank(_comm, &rank);
  first = rank == 0 ? 0 : first; // MPI_Exscan leaves it undefined there
  _columns.assign(owned * std::size_t(_num_columns), 0.0);
  for (int k = 0; k < count; ++k)
    conditions.add_constrained(own[k], {_columns.data() + std::size_t(first + k) * owned, owned});
  std::vector<double> forces; // that hold the other nodes where they are
  for (int begin = 0; begin < _num_columns; begin += block)
    std::ranges::transform(forces_of({&K, 1}, begin, {}), std::back_inserter(forces), std::negate{});
  _factors.add_solutions(_num_columns, forces, _columns);
}

ReleasedFactors::~ReleasedFactors()
{
  operators::let_go(PetscObject(_moved));
  operators::let_go(PetscObject(_force));
}

/// X^T times owned values. Collective.
std::vector<double> ReleasedFactors::products(std::span<const double> values) const
{
  std::vector<double> out(_num_columns, 0.0);
  if (!values.empty())
    out = dense_product(_columns, values, _num_columns);
  MPI_Allreduce(MPI_IN_PLACE, out.data(), _num_columns, MPI_DOUBLE, MPI_SUM, _comm);
  return out;
}

/// Forces of the columns of a block, zero at pinned unknowns. Collective.
/// @param[in] stiffness matrices that are added
/// @param[in] begin number of the first column
/// @param[in] pinned unknowns that do not move; empty: there are none
/// @returns those of k at [(k - begin)*num_owned, (k - begin + 1)*num_owned)
std::vector<double> ReleasedFactors::forces_of(std::span<const Mat> stiffness, int begin,
                                               std::span<const std::int8_t> pinned) const
{
  const std::size_t owned = _factors.num_owned();
  const int num = std::min(block, _num_columns - begin);
  const double* const start = _columns.data() + std::size_t(begin) * owned;
  const auto pin = [&](std::vector<double>& values)
  {
    for (int k = 0; k < num && !pinned.empty(); ++k)
      for (std::size_t i = 0; i < owned; ++i)
        if (pinned[i])
          values[std::size_t(k) * owned + i] = 0.0;
  };
  std::vector<double> moved(start, start + std::size_t(num) * owned);
  pin(moved);
  std::vector<double> forces = column_products(stiffness, num, std::move(moved));
  pin(forces);
  return forces;
}

/// Forces of increments in the selected system, zero at its pinned unknowns. Collective.
std::vector<double> ReleasedFactors::forces_of(std::span<const double> increments) const
{
  const std::span<const std::int8_t> pinned = _system->pinned();
  {
    Entries moved(_moved);
    for (std::size_t i = 0; i < increments.size(); ++i)
      moved[i] = pinned[i] ? 0.0 : increments[i];
  }
  _system->mult(_moved, _force);
  return operators::values_of(_force, increments.size());
}

bool ReleasedFactors::select(CondensedSystem& system)
{
  _system = &system;
  _system_id = 0;
  const std::size_t owned = _factors.num_owned();
  std::vector<double> matrix(std::size_t(_num_columns) * _num_columns);
  for (int begin = 0; begin < _num_columns; begin += block)
  {
    const std::vector<double> forces = forces_of(system.stiffness(), begin, system.pinned());
    for (int j = begin; j < std::min(begin + block, _num_columns); ++j)
    {
      const std::vector<double> column = products({forces.data() + std::size_t(j - begin) * owned, owned});
      for (int i = 0; i < _num_columns; ++i)
        matrix[std::size_t(i) * _num_columns + j] = column[i];
    }
  }
  // A body that is held as a whole and that the others' conditions left free is not opened by columns that move it
  // alone: those have no part in the system.
  const SymmetricEigen found = symmetric_eigen(std::move(matrix), _num_columns);
  _inverse.assign(std::size_t(_num_columns) * _num_columns, 0.0);
  for (int k = 0; k < _num_columns; ++k)
  {
    if (!(found.values[k] > least_stiffness * found.values.back()))
      continue;
    const double* const vector = &found.vectors[std::size_t(k) * _num_columns];
    for (int i = 0; i < _num_columns; ++i)
      for (int j = 0; j < _num_columns; ++j)
        _inverse[std::size_t(i) * _num_columns + j] += vector[i] * vector[j] / found.values[k];
  }
  if (!std::isfinite(found.values.back()) || found.values.back() <= 0.0)
    return false;
  _system_id = system.id();
  return true;
}

void ReleasedFactors::apply(Vec r, Vec z) const
{
  const std::span<const std::int8_t> now = _system->pinned();
  const std::vector<double> forces = _system->forces(r);
  std::vector<double> moved = _factors.solve(forces);
  std::vector<double> left = forces_of(moved);
  for (std::size_t i = 0; i < left.size(); ++i)
    left[i] = now[i] ? 0.0 : forces[i] - left[i];
  const std::vector<double> openings = dense_product(_inverse, products(left), _num_columns);
  for (int k = 0; k < _num_columns; ++k)
  {
    const double* const column = _columns.data() + std::size_t(k) * moved.size();
    for (std::size_t i = 0; i < moved.size(); ++i)
      moved[i] += openings[k] * column[i];
  }
  _system->set_unknowns(moved, r, z);
}
} // namespace dolfinx_impact::solve
