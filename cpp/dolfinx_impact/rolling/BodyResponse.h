// SPDX-License-Identifier: MIT
#pragma once
#include "../solve/LinearSolver.h"
#include "../solve/LinearSystem.h"
#include "ContactOperators.h"
#include "FrictionProblem.h"
#include <memory>

namespace dolfinx_impact::rolling
{
/// Solutions of (K + E) u = f with prescribed values, by factors of K, and the compliance that candidate nodes of
/// contacts see. The factors serve later matrices as a preconditioner. The matrix is symmetric but for E, what the
/// turning of normals adds.
class BodyResponse
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] fixed mask of prescribed degrees of freedom, owned
  BodyResponse(const surface::FunctionSpace& V, std::vector<std::int8_t> fixed);

  /// Take another matrix; it must stay as it is until the next one. Collective.
  /// @param[in] K tangent of the bodies, symmetric [F/L]
  /// @param[in] extra matrices that are added to it
  void update(Mat K, const std::vector<Mat>& extra);
  /// How many times factors were made so far.
  int num_factors() const { return _solver.num_set_ups(); }
  /// Motions of the bodies that nothing holds but contact.
  int null_pivots() const { return _solver.null_pivots(); }

  /// Displacements, owned [L], and what is wrong with them; empty if nothing is.
  struct Solution
  {
    std::vector<double> displacements;
    std::string fault;
  };
  /// Displacements under a load. Collective.
  /// @param[in] load nodal forces, owned [F]
  /// @param[in] jump values at the prescribed degrees of freedom, in their order; empty: zero [L]
  Solution solve(std::vector<double> load, std::span<const double> jump = {});
  /// Jumps and velocities that unit forces at the candidates cause, on rank 0; empty on others. Collective.
  ///
  /// Without E: good enough for what leads to a solution, which is then checked by `solve`.
  Compliance compliance(const ContactOperators& operators, const Candidates& candidates);
  /// Factors are made anew, when they are used next. Collective.
  void forget_factors() { _solver.reset(); }

private:
  std::vector<std::int8_t> _pinned;
  std::vector<std::int32_t> _fixed;
  solve::LinearSolver _solver;
  std::unique_ptr<solve::PerturbedSystem> _system;
};
} // namespace dolfinx_impact::rolling
