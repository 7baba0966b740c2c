// SPDX-License-Identifier: MIT
#include "arrays.h"
#include <caster_petsc.h>
#include <petscmat.h>

void dolfinx_impact::bindings::triplets(nb::module_& m)
{
  m.def(
      "add_triplets",
      [](Mat A, nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> rows,
         nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu> cols, Values values)
      {
        if (rows.size() != cols.size() || rows.size() != values.size())
          throw std::invalid_argument("rows, columns and values differ in number");
        std::vector<PetscInt> i(rows.data(), rows.data() + rows.size()), j(cols.data(), cols.data() + cols.size());
        PetscErrorCode error = MatSetPreallocationCOO(A, PetscCount(i.size()), i.data(), j.data());
        if (!error)
          error = MatSetValuesCOO(A, values.data(), ADD_VALUES);
        if (error)
          throw std::runtime_error("PETSc error " + std::to_string(error) + " while a matrix was filled");
      },
      nb::arg("A"), nb::arg("rows"), nb::arg("cols"), nb::arg("values"),
      "Fill an empty matrix with entries of any rows, of any rank; entries at the same place add up. Collective");
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
