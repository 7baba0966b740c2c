// SPDX-License-Identifier: MIT
#pragma once
// Communicators, vectors and matrices of mpi4py and petsc4py as arguments: DOLFINx's own conversions, which 0.10 moved.
// The folder that they lie in now has a petsc.h too, so it is not among the include paths: it would hide PETSc's.
#if __has_include(<dolfinx_wrappers/caster_petsc.h>)
#include <dolfinx_wrappers/caster_mpi.h>
#include <dolfinx_wrappers/caster_petsc.h>
#else
#include <caster_mpi.h>
#include <caster_petsc.h>
#endif
