// SPDX-License-Identifier: MIT
#include "NodalMatrix.h"
#include "petsc_check.h"
#include <algorithm>
#include <dolfinx/la/SparsityPattern.h>
#include <dolfinx/la/petsc.h>

namespace dolfinx_impact::operators
{
void NodalMatrix::Couplings::add(std::int64_t key, std::span<const std::int32_t> r, std::span<const std::int32_t> c)
{
  keys.push_back(key);
  rows.insert(rows.end(), r.begin(), r.end());
  columns.insert(columns.end(), c.begin(), c.end());
  row_ends.push_back(rows.size());
  column_ends.push_back(columns.size());
}

NodalMatrix::~NodalMatrix()
{
  MatDestroy(&_matrix);
}

bool NodalMatrix::fits(const Couplings& couplings) const
{
  return std::all_of(couplings.keys.begin(), couplings.keys.end(), [&](std::int64_t key)
                     { return std::binary_search(_sorted_keys.begin(), _sorted_keys.end(), key); });
}

void NodalMatrix::reset(const std::shared_ptr<const dolfinx::common::IndexMap>& map, int block_size,
                        const Couplings& couplings)
{
  int make = !_matrix || _map != map || _block_size != block_size || !fits(couplings);
  MPI_Allreduce(MPI_IN_PLACE, &make, 1, MPI_INT, MPI_MAX, map->comm());
  if (!make)
  {
    check(MatZeroEntries(_matrix), "a matrix is zeroed");
    return;
  }
  if (_map != map || _block_size != block_size)
  {
    _known = {};
    _sorted_keys.clear();
  }
  _map = map;
  _block_size = block_size;
  std::size_t row = 0, column = 0;
  for (std::size_t i = 0; i < couplings.keys.size(); ++i)
  {
    const std::size_t rows = couplings.row_ends[i] - row, columns = couplings.column_ends[i] - column;
    if (!std::binary_search(_sorted_keys.begin(), _sorted_keys.end(), couplings.keys[i]))
      _known.add(couplings.keys[i], {couplings.rows.data() + row, rows}, {couplings.columns.data() + column, columns});
    row = couplings.row_ends[i];
    column = couplings.column_ends[i];
  }
  _sorted_keys = _known.keys;
  std::sort(_sorted_keys.begin(), _sorted_keys.end());
  dolfinx::la::SparsityPattern pattern(map->comm(), {map, map}, {block_size, block_size});
  row = column = 0;
  for (std::size_t i = 0; i < _known.keys.size(); ++i)
  {
    pattern.insert(std::span(_known.rows).subspan(row, _known.row_ends[i] - row),
                   std::span(_known.columns).subspan(column, _known.column_ends[i] - column));
    row = _known.row_ends[i];
    column = _known.column_ends[i];
  }
  std::vector<std::int32_t> diagonal(map->size_local());
  for (std::size_t i = 0; i < diagonal.size(); ++i)
    diagonal[i] = std::int32_t(i);
  pattern.insert_diagonal(diagonal);
  pattern.finalize();
  check(MatDestroy(&_matrix), "a matrix is destroyed");
  _matrix = dolfinx::la::petsc::create_matrix(map->comm(), pattern);
  check(MatSetOption(_matrix, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE), "a matrix is made");
  ++_num_created;
  // PETSc gives places back that hold nothing when a matrix is assembled first: all get a zero.
  std::vector<double> zeros(block_size * block_size, 0.0);
  for (std::int32_t node : diagonal)
    add({&node, 1}, {&node, 1}, zeros);
  row = column = 0;
  for (std::size_t i = 0; i < _known.keys.size(); ++i)
  {
    const auto rows = std::span(_known.rows).subspan(row, _known.row_ends[i] - row);
    const auto columns = std::span(_known.columns).subspan(column, _known.column_ends[i] - column);
    zeros.resize(rows.size() * columns.size() * block_size * block_size, 0.0);
    add(rows, columns, zeros);
    row = _known.row_ends[i];
    column = _known.column_ends[i];
  }
  finish();
}

void NodalMatrix::add(std::span<const std::int32_t> rows, std::span<const std::int32_t> columns,
                      std::span<const double> block)
{
  check(MatSetValuesBlockedLocal(_matrix, PetscInt(rows.size()), rows.data(), PetscInt(columns.size()), columns.data(),
                                 block.data(), ADD_VALUES),
        "a block is added to a matrix");
}

void NodalMatrix::finish()
{
  check(MatAssemblyBegin(_matrix, MAT_FINAL_ASSEMBLY), "a matrix is assembled");
  check(MatAssemblyEnd(_matrix, MAT_FINAL_ASSEMBLY), "a matrix is assembled");
}
} // namespace dolfinx_impact::operators
