// SPDX-License-Identifier: MIT
#include "arrays.h"
#include <petscsys.h>

void dolfinx_impact::bindings::linear(nb::module_& m)
{
  m.def(
      "option_used",
      [](const std::string& name)
      {
        PetscBool used = PETSC_FALSE;
        if (PetscOptionsUsed(nullptr, name.c_str(), &used))
          throw std::runtime_error("PETSc cannot tell whether the option " + name + " was used");
        return used == PETSC_TRUE;
      },
      nb::arg("name"), "Has anything read this option of PETSc's database? Its name has prefix and no dash");
}
