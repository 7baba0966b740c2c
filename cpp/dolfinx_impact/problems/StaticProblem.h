// SPDX-License-Identifier: MIT
#pragma once
#include "../solve/LoadSteps.h"
#include "../solve/Newton.h"
#include "make_equilibrium.h"
#include <array>
#include <dolfinx/fem/DirichletBC.h>
#include <memory>
#include <optional>
#include <vector>

/// Last stage: problems, composed of bodies, supports and contacts.
namespace dolfinx_impact::problems
{
typedef std::vector<std::shared_ptr<const dolfinx::fem::DirichletBC<double>>> BoundaryConditions;

/// Mask of the degrees of freedom that boundary conditions prescribe, owned and ghosts.
std::vector<std::int8_t> prescribed_dofs(const dolfinx::fem::FunctionSpace<double>& V, const BoundaryConditions& bcs);

struct SolveOptions
{
  int steps = 1;                               ///< equal increments
  double rtol = 1e-10;                         ///< of the free residual, relative to the largest force so far [1]
  double atol = 0.0;                           ///< of the free residual [F]
  int max_iterations = 25;                     ///< per increment
  std::optional<int> cut_backs = std::nullopt; ///< nothing: 8 with contact or several steps, else 0
};

/// Equilibrium of bodies, in contact or not: internal virtual work and that of contact equal external virtual work.
class StaticProblem
{
public:
  /// Collective.
  /// @param[in] u displacement: initial guess, becomes the solution [L]
  /// @param[in] body residual of the bodies and its tangent
  /// @param[in] contacts made with prescribed_dofs of the same boundary conditions
  /// @throws std::invalid_argument for contacts that cannot share nodes, or options that PETSc does not take
  StaticProblem(std::shared_ptr<dolfinx::fem::Function<double>> u, std::shared_ptr<solve::Body> body,
                BoundaryConditions bcs, std::vector<std::shared_ptr<enforcement::StaticContact>> contacts = {},
                const SolverOptions& options = {});

  /// Solve for the present values of boundary conditions, loads and obstacles, in steps from those of the last solve.
  /// Collective.
  /// @throws std::runtime_error no convergence; the problem is in its last converged state
  /// @throws std::invalid_argument options out of range
  solve::LoadStepReport solve(const SolveOptions& options = {});

  /// External forces that are applied in parts, beside those of the body: a view of them, which must stay valid.
  void add_load(std::span<double> forces);
  /// Displacement of a contact's rigid master that the next solve leads to [L].
  /// @throws std::invalid_argument if its master is deformable
  void move_obstacle(std::size_t contact, const std::array<double, 3>& displacement);
  /// Displacements, state of bodies and contacts, and loads as reached: copied, the problem can be brought back to it.
  /// Of displacements it has the owned ones; `solve` updates ghosts.
  state::State state();
  const solve::EquilibriumProblem& equilibrium() const { return *_equilibrium; }

private:
  std::shared_ptr<solve::EquilibriumProblem> _equilibrium;
  BoundaryConditions _bcs;
  std::vector<solve::LoadSteps::Displacement> _obstacles;
  std::vector<std::span<double>> _loads;
  std::vector<std::vector<double>> _reached; ///< loads of the last solve
};
} // namespace dolfinx_impact::problems
