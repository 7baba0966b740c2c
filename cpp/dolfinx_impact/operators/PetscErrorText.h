// SPDX-License-Identifier: MIT
#pragma once
#include <petscsys.h>
#include <string>

namespace dolfinx_impact::operators
{
/// Takes PETSc's words on an error instead of printing them, as long as it lives.
class PetscErrorText
{
public:
  PetscErrorText() { PetscPushErrorHandler(&note, this); }
  ~PetscErrorText() { PetscPopErrorHandler(); }
  PetscErrorText(const PetscErrorText&) = delete;
  PetscErrorText& operator=(const PetscErrorText&) = delete;
  const std::string& text() const { return _text; }

private:
  static PetscErrorCode note(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType type,
                             const char* message, void* context)
  {
    if (type == PETSC_ERROR_INITIAL && message)
      static_cast<PetscErrorText*>(context)->_text = message;
    return code;
  }

  std::string _text;
};
} // namespace dolfinx_impact::operators
