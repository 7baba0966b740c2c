// SPDX-License-Identifier: MIT
#pragma once
// PETSc's objects in and out, where nanobind's arguments do not do.
#include "casters.h"
#include "module.h"
#include <vector>

namespace dolfinx_impact::bindings
{
/// PETSc's object behind a Python one, which must be kept alive by somebody else.
template <typename T>
T as_petsc(const nanobind::handle& value)
{
  nanobind::detail::make_caster<T> caster;
  if (!caster.from_python(value, 0, nullptr))
    throw nanobind::type_error("a PETSc vector or matrix is needed");
  return static_cast<T&>(caster);
}

typedef nanobind::typed<nanobind::list, Mat> Matrices;

inline std::vector<Mat> matrices(const Matrices& values)
{
  std::vector<Mat> out;
  for (nanobind::handle value : values)
    out.push_back(as_petsc<Mat>(value));
  return out;
}
} // namespace dolfinx_impact::bindings
