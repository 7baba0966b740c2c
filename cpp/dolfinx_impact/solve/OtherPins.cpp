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
OtherPins::OtherPins(PC preconditioner, const LinearSystem& system, std::span<const std::int8_t> pinned)
    : _preconditioner(preconditioner)
{
  check(PetscObjectReference(PetscObject(_preconditioner)), "a preconditioner is kept");
  check(MatCreateVecs(system.K(), &_right, nullptr), "a vector is made");
  check(MatGetDiagonal(system.K(), _right), "a diagonal is read");
  const std::span<const std::int8_t> now = system.pinned();
  if (now.size() != pinned.size())
    throw std::invalid_argument("pinned unknowns of a system of the same size are needed");
  {
    Entries diagonal(_right);
    for (std::size_t i = 0; i < now.size(); ++i)
      if (bool(now[i]) != bool(pinned[i]))
      {
        const double stiffness = std::abs(diagonal[i]);
        _differ.push_back(PetscInt(i));
        _inverse_stiffness.push_back(stiffness > 0.0 ? 1.0 / stiffness : 1.0);
      }
  }
  check(PCCreate(PetscObjectComm(PetscObject(_preconditioner)), &_shell), "a preconditioner is made");
  check(PCSetType(_shell, PCSHELL), "a preconditioner is made");
  check(PCShellSetContext(_shell, this), "a preconditioner is made");
  check(PCShellSetApply(_shell, &OtherPins::apply), "a preconditioner is made");
}

OtherPins::~OtherPins()
{
  let_go(PetscObject(_shell));
  let_go(PetscObject(_preconditioner));
  let_go(PetscObject(_right));
}

PetscErrorCode OtherPins::apply(PC pc, Vec r, Vec z)
{
  OtherPins* self = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &self));
  PetscCall(VecCopy(r, self->_right));
  PetscScalar* right = nullptr;
  PetscCall(VecGetArray(self->_right, &right));
  for (PetscInt i : self->_differ)
    right[i] = 0.0;
  PetscCall(VecRestoreArray(self->_right, &right));
  PetscCall(PCApply(self->_preconditioner, self->_right, z));
  const PetscScalar* given = nullptr;
  PetscScalar* out = nullptr;
  PetscCall(VecGetArrayRead(r, &given));
  PetscCall(VecGetArray(z, &out));
  for (std::size_t k = 0; k < self->_differ.size(); ++k)
    out[self->_differ[k]] = self->_inverse_stiffness[k] * given[self->_differ[k]];
  PetscCall(VecRestoreArray(z, &out));
  PetscCall(VecRestoreArrayRead(r, &given));
  PetscFunctionReturn(PETSC_SUCCESS);
}
} // namespace dolfinx_impact::solve
