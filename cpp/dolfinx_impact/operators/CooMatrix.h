// SPDX-License-Identifier: MIT
#pragma once
#include <mpi.h>
#include <petscmat.h>
#include <span>
#include <vector>

namespace dolfinx_impact::operators
{
/// Sparse matrix from entries of any rows; entries at the same place add up, those of other ranks' rows are sent there.
/// PETSc's matrix is kept while the places stay the same.
class CooMatrix
{
public:
  /// Entries of this rank, global rows and columns.
  struct Entries
  {
    std::vector<PetscInt> rows, columns;
    std::vector<double> values;
    void add(PetscInt i, PetscInt j, double v)
    {
      rows.push_back(i);
      columns.push_back(j);
      values.push_back(v);
    }
  };

  CooMatrix() = default;
  ~CooMatrix();
  CooMatrix(const CooMatrix&) = delete;
  CooMatrix& operator=(const CooMatrix&) = delete;

  /// Collective.
  /// @param[in] num_rows, num_columns of this rank
  /// @param[in] block_size of the matrix; its entries are given one by one all the same
  void assign(MPI_Comm comm, PetscInt num_rows, PetscInt num_columns, int block_size, Entries entries);
  /// Borrowed, valid until the next assign; null before the first.
  Mat matrix() const { return _matrix; }

private:
  Entries _entries; ///< whose places the matrix has
  PetscInt _sizes[2] = {-1, -1};
  Mat _matrix = nullptr;
};
} // namespace dolfinx_impact::operators
