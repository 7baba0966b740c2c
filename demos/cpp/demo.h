// SPDX-License-Identifier: MIT
// What the demos beside this file have in common: their main function, and a call of DOLFINx whose arguments differ
// between its releases.
#pragma once
#include <cstdio>
#include <dolfinx_impact/common/create_functionspace.h>
#include <exception>
#include <petscsys.h>
#include <spdlog/spdlog.h>

using dolfinx_impact::common::create_functionspace;

/// Start PETSc and MPI, run a demo, and end them.
/// @param[in] name of the demo, for errors
/// @param[in] run returns whether the numbers are those expected. Collective.
/// @returns exit status: zero if they are
inline int run_demo(int argc, char* argv[], const char* name, bool (*run)())
{
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  spdlog::set_level(spdlog::level::warn); // DOLFINx tells every step otherwise
  bool passed = false;
  try
  {
    passed = run();
  }
  catch (const std::exception& e)
  {
    std::fprintf(stderr, "%s: %s\n", name, e.what());
  }
  PetscFinalize();
  return passed ? 0 : 1;
}
