// SPDX-License-Identifier: MIT
#include "OtherPins.h"
#include "../operators/petsc_check.h"
#include <cmath>
#include <stdexcept>

using dolfinx_impact::operators::check;
using dolfinx_impact::operators::Entries;
using dolfinx_impact::operators::let_go;

namespace dolfinx_impact::solve
{
OtherPins::OtherPins(PC preconditioner, const CondensedSystem& system, std::span<const std::int8_t> pinned)
    : _preconditioner(preconditioner), _symmetric(system.symmetric())
{
  const MPI_Comm comm = PetscObjectComm(PetscObject(preconditioner));
  const std::span<const std::int8_t> now = system.pinned();
  if (now.size() != pinned.size())
    throw std::invalid_argument("pinned unknowns of a system of the same size are needed");
  check(PetscObjectReference(PetscObject(_preconditioner)), "a preconditioner is kept");
  check(MatCreateVecs(system.K(), &_right, nullptr), "a vector is made");
  check(MatGetDiagonal(system.K(), _right), "a diagonal is read");
  {
    Entries diagonal(_right);
    for (std::size_t i = 0; i < now.size(); ++i)
      if (now[i] && !pinned[i])
      {
        // Rows of pinned unknowns have a mean diagonal, which where the mesh is fine is larger than the stiffness by
        // orders of magnitude.
        const double stiffness = std::abs(diagonal[i]);
        _pinned.push_back(PetscInt(i));
        _inverse_stiffness.push_back(stiffness > 0.0 ? 1.0 / stiffness : 1.0);
      }
      else if (!now[i] && pinned[i])
        _freed.push_back(PetscInt(i));
  }
  int any = !_freed.empty();
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, comm);
  if (any)
  {
    _columns = system.columns(_freed);
    check(MatCreateVecs(_columns, &_moved, nullptr), "vectors are made");
    check(VecDuplicate(_moved, &_sums), "vectors are made");
    std::vector<double> size(now.size(), 0.0);
    PetscInt first = 0;
    check(MatGetOwnershipRange(_columns, &first, nullptr), "a matrix is asked for its rows");
    for (PetscInt i : _freed)
    {
      // With the sum of absolute entries in the place of the diagonal the relaxation converges whatever the couplings.
      double sum = 0.0;
      PetscInt num = 0;
      const double* values = nullptr;
      check(MatGetRow(_columns, first + i, &num, nullptr, &values), "a row is read");
      for (PetscInt k = 0; k < num; ++k)
        sum += std::abs(values[k]);
      check(MatRestoreRow(_columns, first + i, &num, nullptr, &values), "a row is read");
      _relaxation.push_back(sum > 0.0 ? 1.0 / sum : 1.0);
    }
  }
  check(PCCreate(comm, &_shell), "a preconditioner is made");
  check(PCSetType(_shell, PCSHELL), "a preconditioner is made");
  check(PCShellSetContext(_shell, this), "a preconditioner is made");
  check(PCShellSetApply(_shell, &OtherPins::apply), "a preconditioner is made");
}

OtherPins::~OtherPins()
{
  let_go(PetscObject(_shell));
  let_go(PetscObject(_preconditioner));
  let_go(PetscObject(_columns));
  for (Vec v : {_right, _moved, _sums})
    let_go(PetscObject(v));
}

PetscErrorCode OtherPins::apply(PC pc, Vec r, Vec z)
{
  OtherPins* self = nullptr;
  const PetscScalar* given = nullptr;
  PetscScalar *entries = nullptr, *moved = nullptr;
  const PetscScalar* sums = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &self));
  PetscCall(VecGetArrayRead(r, &given));
  PetscCall(VecCopy(r, self->_right));
  if (self->_columns)
  {
    PetscCall(VecGetArray(self->_moved, &moved));
    for (std::size_t k = 0; k < self->_freed.size(); ++k)
      moved[k] = self->_relaxation[k] * given[self->_freed[k]];
    PetscCall(VecRestoreArray(self->_moved, &moved));
    PetscCall(MatMult(self->_columns, self->_moved, z));
    PetscCall(VecAXPY(self->_right, -1.0, z));
  }
  PetscCall(VecGetArray(self->_right, &entries));
  for (PetscInt i : self->_freed)
    entries[i] = 0.0;
  for (PetscInt i : self->_pinned)
    entries[i] = 0.0;
  PetscCall(VecRestoreArray(self->_right, &entries));
  PetscCall(PCApply(self->_preconditioner, self->_right, z));
  PetscCall(VecGetArray(z, &entries));
  for (std::size_t k = 0; k < self->_pinned.size(); ++k)
    entries[self->_pinned[k]] = self->_inverse_stiffness[k] * given[self->_pinned[k]];
  for (std::size_t k = 0; k < self->_freed.size(); ++k)
    entries[self->_freed[k]] = self->_relaxation[k] * given[self->_freed[k]];
  PetscCall(VecRestoreArray(z, &entries));
  if (self->_columns && self->_symmetric)
  {
    // The rows of the freed unknowns are their columns.
    PetscCall(MatMultTranspose(self->_columns, z, self->_sums));
    PetscCall(VecGetArrayRead(self->_sums, &sums));
    PetscCall(VecGetArray(z, &entries));
    for (std::size_t k = 0; k < self->_freed.size(); ++k)
      entries[self->_freed[k]] += self->_relaxation[k] * (given[self->_freed[k]] - sums[k]);
    PetscCall(VecRestoreArray(z, &entries));
    PetscCall(VecRestoreArrayRead(self->_sums, &sums));
  }
  PetscCall(VecRestoreArrayRead(r, &given));
  PetscFunctionReturn(PETSC_SUCCESS);
}
} // namespace dolfinx_impact::solve
