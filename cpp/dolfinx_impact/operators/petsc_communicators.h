// SPDX-License-Identifier: MIT
#pragma once
#include <dolfinx/fem/FunctionSpace.h>

namespace dolfinx_impact::operators
{
/// Keep PETSc's own copies of the communicators of a space, those of its mesh and of its degrees of freedom, for as
/// long as these live. Collective.
///
/// PETSc copies a communicator when the first object is made on it, which all ranks must do together, and frees the
/// copy with the last object. Python's garbage collector ends objects at another time on each rank. Without this a rank
/// whose last object is gone would wait, at the next one, for ranks that have the copy still.
void keep_petsc_communicators(const dolfinx::fem::FunctionSpace<double>& V);
} // namespace dolfinx_impact::operators
