// SPDX-License-Identifier: MIT
#include "TieSystem.h"
#include "../../common/gather.h"
#include "../../operators/petsc_check.h"
#include <algorithm>
#include <cmath>
#include <exception>
#include <numeric>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::enforcement
{
using operators::check;

namespace
{
/// The entries of a sparse matrix of this process, row by row.
struct TieEntries
{
  explicit TieEntries(Mat A)
  {
    PetscInt size = 0;
    check(MatGetSize(A, &size, nullptr), "a matrix is asked for its size");
    for (PetscInt row = 0; row < size; ++row)
    {
      PetscInt number = 0;
      const PetscInt* at = nullptr;
      const PetscScalar* value = nullptr;
      check(MatGetRow(A, row, &number, &at, &value), "a row is read");
      columns.insert(columns.end(), at, at + number);
      values.insert(values.end(), value, value + number);
      pointers.push_back(columns.size());
      check(MatRestoreRow(A, row, &number, &at, &value), "a row is read");
    }
  }
  std::size_t size() const { return pointers.size() - 1; }

  std::vector<std::size_t> pointers = {0};
  std::vector<PetscInt> columns;
  std::vector<double> values;
};

/// Rows that are connected by entries, ascending, set after set.
std::vector<std::vector<PetscInt>> connected_rows(const TieEntries& A)
{
  std::vector<std::vector<PetscInt>> out;
  std::vector<std::int8_t> known(A.size(), 0);
  for (std::size_t start = 0; start < A.size(); ++start)
  {
    if (known[start])
      continue;
    known[start] = 1;
    std::vector<PetscInt>& rows = out.emplace_back(1, PetscInt(start));
    for (std::size_t next = 0; next < rows.size(); ++next)
      for (std::size_t k = A.pointers[std::size_t(rows[next])]; k < A.pointers[std::size_t(rows[next]) + 1]; ++k)
        if (std::int8_t& here = known[std::size_t(A.columns[k])]; !here && A.values[k] != 0.0)
        {
          here = 1;
          rows.push_back(A.columns[k]);
        }
    std::ranges::sort(rows);
  }
  return out;
}

/// Have two blocks the same entries, to the last digit? Entries of zero do not count.
bool equal_blocks(const TieEntries& A, std::span<const PetscInt> one, std::span<const PetscInt> other)
{
  if (one.size() != other.size())
    return false;
  for (std::size_t k = 0; k < one.size(); ++k)
  {
    std::size_t i = A.pointers[std::size_t(one[k])], j = A.pointers[std::size_t(other[k])];
    const std::size_t i_end = A.pointers[std::size_t(one[k]) + 1], j_end = A.pointers[std::size_t(other[k]) + 1];
    while (true)
    {
      while (i < i_end && A.values[i] == 0.0)
        ++i;
      while (j < j_end && A.values[j] == 0.0)
        ++j;
      if (i == i_end || j == j_end)
        break;
      const auto place = [&](std::span<const PetscInt> rows, PetscInt column)
      { return std::ranges::lower_bound(rows, column) - rows.begin(); };
      if (A.values[i] != A.values[j] || place(one, A.columns[i]) != place(other, A.columns[j]))
        return false;
      ++i;
      ++j;
    }
    if (i != i_end || j != j_end)
      return false;
  }
  return true;
}
} // namespace

TieSystem::TieSystem(std::vector<const TieConditions*> ties, std::span<const double> inverse_mass)
    : _comm(ties.at(0)->comm()), _ties(std::move(ties)), _inverse_mass(inverse_mass.begin(), inverse_mass.end())
{
  if (_inverse_mass.size() !=
      std::size_t(_ties[0]->space().dofmap()->index_map->size_local()) * std::size_t(_ties[0]->gdim()))
    throw std::invalid_argument("an inverse mass of every owned degree of freedom is needed");
  Mat scaled = nullptr, transposed = nullptr, product = nullptr;
  for (const TieConditions* tie : _ties)
    if (!scaled)
      check(MatDuplicate(tie->matrix(), MAT_COPY_VALUES, &scaled), "a matrix is copied");
    else
      check(MatAXPY(scaled, 1.0, tie->matrix(), DIFFERENT_NONZERO_PATTERN), "matrices are added");
  Vec root = nullptr;
  check(MatCreateVecs(scaled, &root, nullptr), "a vector is made");
  {
    operators::Entries values(root);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = std::sqrt(_inverse_mass[i]);
  }
  check(MatDiagonalScale(scaled, nullptr, root), "a matrix is scaled");
  check(VecDestroy(&root), "a vector is destroyed");
  check(MatTranspose(scaled, MAT_INITIAL_MATRIX, &transposed), "a matrix is transposed");
  check(MatMatMult(scaled, transposed, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &product), "matrices are multiplied");
  check(MatDestroy(&scaled), "a matrix is destroyed");
  check(MatDestroy(&transposed), "a matrix is destroyed");

  find_rows();
  IS rows = nullptr;
  Mat* parts = nullptr;
  check(ISCreateGeneral(PETSC_COMM_SELF, PetscInt(_all_rows.size()), _all_rows.data(), PETSC_COPY_VALUES, &rows),
        "rows are named");
  check(MatCreateSubMatrices(product, 1, &rows, &rows, MAT_INITIAL_MATRIX, &parts), "a matrix is gathered");
  check(MatDestroy(&product), "a matrix is destroyed");
  check(ISDestroy(&rows), "rows are destroyed");
  std::exception_ptr failed;
  try
  {
    factorise(parts[0]);
  }
  catch (...)
  {
    failed = std::current_exception();
  }
  check(MatDestroySubMatrices(1, &parts), "a matrix is destroyed");
  if (failed)
    std::rethrow_exception(failed);
}

/// Conditions of this rank and of all ranks, and the order that PETSc gives to the rows of a submatrix. Collective.
void TieSystem::find_rows()
{
  const PetscInt first = PetscInt(_ties[0]->space().dofmap()->index_map->local_range()[0] * _ties[0]->gdim());
  for (const TieConditions* tie : _ties)
  {
    const Constraints& rows = tie->rows();
    const PetscInt g = tie->gdim();
    for (std::size_t k = 0; k < rows.size(); ++k)
      for (PetscInt d = 0; d < g; ++d)
        if (rows.constrained[k * g + d])
          _rows.push_back(first + g * rows.nodes[k] + d);
  }
  int size = 0;
  const int mine = int(_rows.size());
  MPI_Comm_size(_comm, &size);
  _counts.resize(size);
  MPI_Allgather(&mine, 1, MPI_INT, _counts.data(), 1, MPI_INT, _comm);
  _starts.assign(size, 0);
  std::partial_sum(_counts.begin(), _counts.end() - 1, _starts.begin() + 1);
  // PETSc takes the rows of a submatrix in ascending order; those of a rank are tie after tie.
  const std::vector<std::int64_t> wide = common::gather(_comm, std::vector<std::int64_t>(_rows.begin(), _rows.end()));
  _all_rows.assign(wide.begin(), wide.end());
  std::ranges::sort(_all_rows);
  for (std::int64_t row : wide)
    _order.push_back(std::size_t(std::ranges::lower_bound(_all_rows, PetscInt(row)) - _all_rows.begin()));
  for (std::vector<double>* values : {&_received, &_b, &_z})
    values->assign(_all_rows.size(), 0.0);
}

/// Find the blocks of S and factorise those that differ.
void TieSystem::factorise(Mat S)
{
  const TieEntries entries(S);
  for (std::vector<PetscInt>& rows : connected_rows(entries))
    _blocks.push_back({std::move(rows), 0});
  std::vector<const Block*> factorised;
  for (Block& block : _blocks)
  {
    const auto same = std::ranges::find_if(factorised, [&](const Block* other)
                                           { return equal_blocks(entries, block.rows, other->rows); });
    block.factors = std::size_t(same - factorised.begin());
    if (same != factorised.end())
      continue;
    factorised.push_back(&block);
    IS rows = nullptr;
    Mat part = nullptr;
    check(ISCreateGeneral(PETSC_COMM_SELF, PetscInt(block.rows.size()), block.rows.data(), PETSC_COPY_VALUES, &rows),
          "rows are named");
    check(MatCreateSubMatrix(S, rows, rows, MAT_INITIAL_MATRIX, &part), "a block is taken");
    check(ISDestroy(&rows), "rows are destroyed");
    std::string error;
    try
    {
      _factors.push_back(std::make_unique<operators::CholeskyFactors>(part));
    }
    catch (const std::runtime_error& e)
    {
      error = e.what();
    }
    check(MatDestroy(&part), "a block is destroyed");
    if (!error.empty())
      throw std::runtime_error(
          "the conditions of the ties imply each other: leave common nodes out of one of the tags (" + error + ")");
  }
}

void TieSystem::solve(std::span<const double> b, std::span<double> z)
{
  int rank = 0;
  MPI_Comm_rank(_comm, &rank);
  MPI_Allgatherv(b.data(), int(_rows.size()), MPI_DOUBLE, _received.data(), _counts.data(), _starts.data(), MPI_DOUBLE,
                 _comm);
  for (std::size_t k = 0; k < _order.size(); ++k)
    _b[_order[k]] = _received[k];
  for (const Block& block : _blocks)
    _factors[block.factors]->solve(block.rows, _b, _z);
  for (std::size_t k = 0; k < _rows.size(); ++k)
    z[k] = _z[_order[_starts[rank] + k]];
}

std::vector<double> TieSystem::project(std::span<const double> v)
{
  std::vector<double> b(size()), z(size()), out(v.begin(), v.end());
  const auto for_each = [&](const auto& act)
  {
    std::size_t at = 0;
    for (const TieConditions* tie : _ties)
    {
      const Constraints& rows = tie->rows();
      const int g = tie->gdim();
      std::vector<double> values = tie->jump(v), forces(values.size(), 0.0);
      for (std::size_t k = 0; k < rows.size(); ++k)
        for (int d = 0; d < g; ++d)
          if (rows.constrained[k * g + d])
            act(at++, tie->weight()[k * g + d] * values[rows.rows[k] * g + d], forces[rows.rows[k] * g + d]);
      const std::vector<double> nodal = tie->forces(forces);
      for (std::size_t i = 0; i < out.size(); ++i)
        out[i] -= _inverse_mass[i] * nodal[i];
    }
  };
  for_each([&](std::size_t at, double jump, double&) { b[at] = jump; });
  solve(b, z);
  for_each([&](std::size_t at, double, double& force) { force = z[at]; });
  return out;
}

double TieSystem::largest_jump(std::span<const double> v) const
{
  double here = 0.0;
  for (const TieConditions* tie : _ties)
    for (double jump : tie->jump(v))
      here = std::max(here, std::abs(jump));
  return common::largest(_comm, here);
}
} // namespace dolfinx_impact::enforcement
