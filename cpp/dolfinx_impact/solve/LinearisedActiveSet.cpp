// SPDX-License-Identifier: MIT
#include "LinearisedActiveSet.h"
#include "../common/gather.h"
#include "../common/vectors.h"
#include "../operators/petsc_check.h"
#include "dense.h"
#include <algorithm>
#include <dolfinx/common/IndexMap.h>
#include <numeric>

using dolfinx_impact::operators::check;
using dolfinx_impact::operators::Entries;

namespace dolfinx_impact::solve
{
namespace
{
constexpr std::int64_t most_entries = 50'000'000; // of all columns
constexpr int most_changes = 60;                  // updates of the active set

/// Numbers that any rank has, sorted, each once. Collective.
std::vector<std::int64_t> united(MPI_Comm comm, const std::vector<std::int64_t>& mine)
{
  std::vector<std::int64_t> all = common::gather(comm, mine);
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}
} // namespace

LinearisedActiveSet::LinearisedActiveSet(enforcement::MultiplierContact& contact, CondensedSystem& system, Mat factors,
                                         Product product, const dolfinx::common::IndexMap& nodes)
    : _contact(contact), _system(system), _factors(factors), _product(std::move(product)), _comm(nodes.comm()),
      _base(common::copy_of(contact.active())), _gap(common::copy_of(contact.linearised_gap())),
      _multiplier(common::copy_of(contact.multiplier()))
{
}

std::optional<std::pair<std::vector<double>, int>> LinearisedActiveSet::update()
{
  const std::span<const std::int64_t> numbers = _contact.numbers();
  std::size_t owned = _system.pinned().size();
  std::vector<double> z;
  int changes = 0;
  for (int k = 0; k < most_changes; ++k)
  {
    const int found = _contact.update_active_set(false);
    if (found == 0)
    {
      std::vector<double> moved(owned, 0.0);
      for (std::size_t c = 0; c < z.size(); ++c)
        for (std::size_t i = 0; i < owned; ++i)
          moved[i] += z[c] * _increments[c][i];
      return std::pair{std::move(moved), changes};
    }
    changes += found;
    const std::vector<std::int8_t> active = common::copy_of(_contact.active());
    std::vector<std::int64_t> differ;
    for (std::size_t i = 0; i < active.size(); ++i)
      if (active[i] != _base[i])
        differ.push_back(numbers[i]);
    const std::vector<std::int64_t> wanted = united(_comm, differ);
    std::vector<std::int64_t> fresh;
    std::ranges::copy_if(wanted, std::back_inserter(fresh),
                         [&](std::int64_t n) { return !std::ranges::count(_columns, n); });
    std::int64_t rows = std::int64_t(owned);
    MPI_Allreduce(MPI_IN_PLACE, &rows, 1, MPI_INT64_T, MPI_SUM, _comm);
    if (rows * std::int64_t(_columns.size() + fresh.size()) > most_entries)
      break;
    if (!fresh.empty())
      add(fresh);
    std::optional<std::vector<double>> found_z = solve(wanted);
    if (!found_z) // a set that does not hold the bodies: the same on all ranks
      break;
    z = std::move(*found_z);
    std::vector<double> gap(_gap), multiplier(active.size(), 0.0);
    for (std::size_t i = 0; i < active.size(); ++i)
    {
      double pressed = _base[i] ? _multiplier[i] : column_value(numbers[i], z);
      for (std::size_t c = 0; c < z.size(); ++c)
      {
        gap[i] += z[c] * _gaps[c][i];
        if (_base[i])
          pressed += z[c] * _multipliers[c][i];
      }
      multiplier[i] = active[i] ? pressed : 0.0;
    }
    _contact.set_linearised(active, gap, multiplier);
  }
  _contact.set_linearised(_base, _gap, _multiplier);
  return {};
}

std::unique_ptr<UpdatedFactors>
LinearisedActiveSet::updated_factors(std::shared_ptr<enforcement::Condensation> condensation)
{
  std::vector<UpdatedFactors::Column> columns;
  for (std::size_t k = 0; k < _columns.size(); ++k)
    columns.push_back({_columns[k], _opened[k] != 0,
                       _opened[k] ? std::vector<double>() : _contact.unit_force(_columns[k]),
                       std::move(_increments[k])});
  const std::span<const std::int8_t> pinned = _system.pinned();
  return std::make_unique<UpdatedFactors>(_comm, _factors, std::move(condensation),
                                          std::vector<std::int8_t>(pinned.begin(), pinned.end()), _base,
                                          std::move(columns), _product);
}

/// Value of a node's column, zero without one.
double LinearisedActiveSet::column_value(std::int64_t number, const std::vector<double>& z) const
{
  const auto at = std::ranges::find(_columns, number);
  return at == _columns.end() ? 0.0 : z[at - _columns.begin()];
}

/// Forces of closed and gaps of opened nodes, one value per column, zero for the others; nothing if the matrix is
/// singular. Collective.
/// @param[in] wanted nodes whose state differs from that of the system
std::optional<std::vector<double>> LinearisedActiveSet::solve(const std::vector<std::int64_t>& wanted) const
{
  const std::span<const std::int64_t> numbers = _contact.numbers();
  const std::size_t n = wanted.size();
  std::vector<std::size_t> columns;
  for (std::int64_t number : wanted)
    columns.push_back(std::ranges::find(_columns, number) - _columns.begin());
  std::vector<double> system(n * n + n, 0.0); // column after column, then the right side
  for (std::size_t i = 0; i < numbers.size(); ++i)
  {
    const auto at = std::ranges::lower_bound(wanted, numbers[i]);
    if (at == wanted.end() || *at != numbers[i])
      continue;
    const std::size_t row = at - wanted.begin();
    for (std::size_t c = 0; c < n; ++c)
      system[c * n + row] = (_base[i] ? _multipliers : _gaps)[columns[c]][i];
    system[n * n + row] = -(_base[i] ? _multiplier : _gap)[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, system.data(), int(system.size()), MPI_DOUBLE, MPI_SUM, _comm);
  const std::optional<std::vector<double>> found =
      solve_dense({system.begin(), system.begin() + n * n}, {system.begin() + n * n, system.end()});
  if (!found)
    return {};
  std::vector<double> z(_columns.size(), 0.0);
  for (std::size_t c = 0; c < n; ++c)
    z[columns[c]] = (*found)[c];
  return z;
}

/// Add the columns of nodes. Collective.
void LinearisedActiveSet::add(const std::vector<std::int64_t>& fresh)
{
  enforcement::Condensation& condensation = *_system.condensation();
  const std::vector<double> known = condensation.known;
  const std::span<const std::int64_t> numbers = _contact.numbers();
  const PetscInt rows = PetscInt(_system.pinned().size());
  // Which of them have opened: the owner of a node tells all ranks.
  std::vector<int> opened(fresh.size(), 0);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (const auto at = std::ranges::find(fresh, numbers[i]); at != fresh.end() && _base[i])
      opened[at - fresh.begin()] = 1;
  MPI_Allreduce(MPI_IN_PLACE, opened.data(), int(opened.size()), MPI_INT, MPI_MAX, _comm);
  Mat right = nullptr, answer = nullptr;
  check(MatCreateDense(_comm, rows, PETSC_DECIDE, PETSC_DETERMINE, PetscInt(fresh.size()), nullptr, &right),
        "right sides are made");
  Vec x = _system.create_vector(), b = _system.create_vector(), moved = _system.create_vector();
  check(VecSet(x, 0.0), "a vector is set");
  const std::vector<double> none(rows, 0.0);
  const std::span<const std::int8_t> pinned = _system.pinned();
  double* columns = nullptr;
  check(MatDenseGetArrayWrite(right, &columns), "right sides are written");
  for (std::size_t k = 0; k < fresh.size(); ++k)
  {
    double* column = columns + k * rows;
    if (opened[k])
    {
      condensation.known = _contact.unit_gap(fresh[k]);
      _system.load(none, x, b);
      Entries load(b);
      std::copy_n(&load[0], rows, column);
    }
    else
    {
      {
        const std::vector<double> force = _contact.unit_force(fresh[k]);
        Entries at(moved);
        std::ranges::copy(force, &at[0]);
      }
      check(MatMultTranspose(condensation.left(), moved, b), "a force is condensed");
      Entries load(b);
      for (PetscInt i = 0; i < rows; ++i)
        column[i] = pinned[i] ? 0.0 : load[i];
    }
  }
  check(MatDenseRestoreArrayWrite(right, &columns), "right sides are written");
  check(MatAssemblyBegin(right, MAT_FINAL_ASSEMBLY), "right sides are made");
  check(MatAssemblyEnd(right, MAT_FINAL_ASSEMBLY), "right sides are made");
  check(MatDuplicate(right, MAT_DO_NOT_COPY_VALUES, &answer), "solutions are made");
  check(MatMatSolve(_factors, right, answer), "responses are solved for");
  const double* values = nullptr;
  check(MatDenseGetArrayRead(answer, &values), "solutions are read");
  for (std::size_t k = 0; k < fresh.size(); ++k)
  {
    {
      Entries unknowns(x);
      std::copy_n(values + k * rows, rows, &unknowns[0]);
    }
    check(MatMult(condensation.right(), x, moved), "displacements are found");
    _increments.push_back(operators::values_of(moved, rows));
    if (opened[k])
    {
      const std::vector<double> apart = _contact.unit_gap(fresh[k]);
      for (PetscInt i = 0; i < rows; ++i)
        _increments.back()[i] += apart[i];
    }
    auto [gap, multiplier] = _contact.linearised_response(_increments.back(), _product(_increments.back()));
    _gaps.push_back(std::move(gap));
    _multipliers.push_back(std::move(multiplier));
    _columns.push_back(fresh[k]);
    _opened.push_back(opened[k]);
  }
  check(MatDenseRestoreArrayRead(answer, &values), "solutions are read");
  condensation.known = known;
  check(MatDestroy(&right), "right sides are destroyed");
  check(MatDestroy(&answer), "solutions are destroyed");
  for (Vec* v : {&x, &b, &moved})
    check(VecDestroy(v), "a vector is destroyed");
}
} // namespace dolfinx_impact::solve
