// SPDX-License-Identifier: MIT
#include "CooMatrix.h"
#include "petsc_check.h"

namespace dolfinx_impact::operators
{
CooMatrix::~CooMatrix()
{
  MatDestroy(&_matrix);
}

void CooMatrix::assign(MPI_Comm comm, PetscInt num_rows, PetscInt num_columns, int block_size, Entries entries)
{
  int make = !_matrix || num_rows != _sizes[0] || num_columns != _sizes[1] || entries.rows != _entries.rows ||
             entries.columns != _entries.columns;
  MPI_Allreduce(MPI_IN_PLACE, &make, 1, MPI_INT, MPI_MAX, comm);
  if (make)
  {
    check(MatDestroy(&_matrix), "a matrix is destroyed");
    _sizes[0] = num_rows;
    _sizes[1] = num_columns;
    check(MatCreate(comm, &_matrix), "a matrix is made");
    check(MatSetSizes(_matrix, num_rows, num_columns, PETSC_DETERMINE, PETSC_DETERMINE), "a matrix is made");
    check(MatSetBlockSize(_matrix, block_size), "a matrix is made");
    check(MatSetType(_matrix, MATAIJ), "a matrix is made");
    _entries.rows = entries.rows;
    _entries.columns = entries.columns;
    // PETSc changes the arrays of places.
    check(MatSetPreallocationCOO(_matrix, PetscCount(entries.rows.size()), entries.rows.data(), entries.columns.data()),
          "the places of a matrix are set");
  }
  check(MatSetValuesCOO(_matrix, entries.values.data(), INSERT_VALUES), "a matrix is filled");
}
} // namespace dolfinx_impact::operators
