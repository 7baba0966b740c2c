// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/StaticContact.h"
#include "Body.h"
#include "LinearSolver.h"
#include <dolfinx/fem/Function.h>
#include <memory>
#include <vector>

namespace dolfinx_impact::solve
{
/// Bodies and contacts in equilibrium, as Newton's method sees them: those of a static problem, or of one step of an
/// implicit one.
struct EquilibriumProblem
{
  std::shared_ptr<dolfinx::fem::Function<double>> u; ///< displacement, the unknown [L]
  std::shared_ptr<Body> body;
  std::vector<std::shared_ptr<enforcement::StaticContact>> contacts;
  std::vector<std::int8_t> fixed; ///< mask of prescribed degrees of freedom, owned and ghosts
  std::shared_ptr<LinearSolver> linear_solver;
  bool axisymmetric = false;      ///< x is the radius
  bool keeps_multipliers = false; ///< multipliers stay in the linear systems; else they are condensed
  bool exact_tangent = true;      ///< what is not symmetric of the contact tangent is in the matrix
  /// Degrees of freedom of the fields of a mixed space, owned; empty: one field.
  std::vector<std::vector<std::int32_t>> fields;

  const dolfinx::fem::FunctionSpace<double>& space() const { return *u->function_space(); }
  MPI_Comm comm() const { return space().mesh()->comm(); }
  std::size_t num_owned() const
  {
    return std::size_t(space().dofmap()->index_map->size_local()) * space().dofmap()->index_map_bs();
  }
};
} // namespace dolfinx_impact::solve
