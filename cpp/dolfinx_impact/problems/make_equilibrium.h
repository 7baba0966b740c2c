// SPDX-License-Identifier: MIT
#pragma once
#include "../solve/EquilibriumProblem.h"
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace dolfinx_impact::problems
{
/// Options of the equations that Newton's method solves.
struct SolverOptions
{
  /// PETSc options by name, without prefix. Besides those of KSP and SNES: contact_tolerance, contact_max_updates,
  /// contact_responses (solve::NewtonOptions) and contact_condense: multipliers are condensed where they can be.
  solve::LinearSolver::Options petsc = {};
  std::string prefix = "";               ///< of options on the command line; empty: that of the kind of problem
  bool axisymmetric = false;             ///< x is the radius
  solve::LinearSolverLimits limits = {}; ///< which systems are factorised
  /// Is called on all ranks with a warning of the linear solver; empty: warnings are printed on rank 0.
  std::function<void(const std::string&)> warn = {};
};

/// Bodies and contacts in equilibrium. Collective.
/// @param[in] fixed mask of prescribed degrees of freedom, owned and ghosts
/// @param[in] prefix of options on the command line, where `options` have none
/// @throws std::invalid_argument for contacts that cannot share nodes, or options that PETSc does not take
std::shared_ptr<solve::EquilibriumProblem>
make_equilibrium(std::shared_ptr<dolfinx::fem::Function<double>> u, std::shared_ptr<solve::Body> body,
                 std::vector<std::shared_ptr<enforcement::StaticContact>> contacts, std::vector<std::int8_t> fixed,
                 const SolverOptions& options, const std::string& prefix);
} // namespace dolfinx_impact::problems
