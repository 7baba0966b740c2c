// SPDX-License-Identifier: MIT
#pragma once
#include "../solve/IncrementSolver.h"
#include "../solve/LoadSteps.h"
#include "RigidEquilibrium.h"
#include "StaticRigidBody.h"
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
  double rtol = 1e-10;                         ///< of the free residual, see solve::NewtonOptions [1]
  double atol = 0.0;                           ///< of the free residual [F]
  int max_iterations = 25;                     ///< per increment
  std::optional<int> cut_backs = std::nullopt; ///< nothing: 8 with contact or several steps, else 0
  bool brings_together = true;                 ///< see solve::LoadStepOptions
};

/// Whom a solve tells what it does.
struct SolveEvents
{
  solve::NewtonEvents newton = {};
  solve::LoadStepEvents steps = {};
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

  /// Solve for the present values of boundary conditions, loads and obstacles, in steps from those of the last solve,
  /// by the SNES that PETSc's options choose (solve::IncrementSolver). Collective.
  /// @throws std::runtime_error no convergence; the problem is in its last converged state, as after exceptions of
  /// events
  /// @throws std::invalid_argument options out of range, or what PETSc does not take
  /// @throws common::Failure if a solve is under way, that has called an event
  solve::LoadStepReport solve(const SolveOptions& options = {}, const SolveEvents& events = {});
  /// The same, but increments are solved by a function of one's own; of `options` steps and cut_backs are read.
  /// Collective.
  solve::LoadStepReport solve(const solve::LoadSteps::Solver& solver, const SolveOptions& options = {},
                              const solve::LoadStepEvents& events = {});

  /// Solve with the linear solver of another problem in the place of one's own: its options, and its factors as long as
  /// they need few iterations. Both may solve afterwards, one at a time. Collective.
  /// @throws std::invalid_argument if the spaces have other degrees of freedom, or multipliers stay in the linear
  /// systems of one of them
  void share_linear_solver(const StaticProblem& other);

  /// External forces that are applied in parts, beside those of the body: a view of them, which must stay valid.
  void add_load(std::span<double> forces);
  /// The same, with a view of those that were reached, which are the caller's then.
  void add_load(solve::Ramp load);
  /// Displacement of a contact's rigid master that the next solve leads to [L].
  /// @throws std::invalid_argument if its master is deformable
  void move_obstacle(std::size_t contact, const std::array<double, 3>& displacement);
  /// Turn a contact's rigid master about its centre, as a load that is applied in parts.
  /// @param[in] angle rotation vector since the reference configuration, three components [1]
  /// @throws std::invalid_argument for a master that cannot turn
  void turn_obstacle(std::size_t contact, solve::Ramp angle);
  /// A rigid master that loads and contacts move: solves look for its equilibrium, too.
  /// @param[in] contacts whose master it is
  /// @param[in] fixed components that stay: x, y, z, rx, ry, rz
  /// @param[in] force, torque views of three components, which must stay valid, and be those of loads of `add_load` if
  /// they are to be applied in parts [F], [F L]
  /// @throws std::invalid_argument as the constructors of RigidEquilibrium and StaticRigidBody
  void add_rigid_body(std::vector<std::size_t> contacts, const std::array<bool, 6>& fixed,
                      std::span<const double> force, std::span<const double> torque);
  /// Displacements, state of bodies and contacts, and loads as reached: copied, the problem can be brought back to it.
  state::State state();
  /// Compute what follows from a state that was assigned: ghosts. Collective.
  void resume();
  /// Residual of equilibrium at the present displacements, owned: support forces at prescribed degrees of freedom,
  /// round-off elsewhere [F]. Collective.
  std::vector<double> reactions();
  /// External forces that are applied in parts, and those that were reached.
  const std::vector<solve::Ramp>& loads() const { return _loads; }
  std::shared_ptr<const solve::EquilibriumProblem> equilibrium() const { return _equilibrium; }
  /// Forget what `state` does not have, factors and candidates of the search: a problem that was copied and one that
  /// was brought back go on alike. Collective.
  void forget();

private:
  void check(const SolveOptions& options) const;

  std::shared_ptr<solve::EquilibriumProblem> _equilibrium;
  BoundaryConditions _bcs;
  std::vector<solve::LoadSteps::Displacement> _obstacles;
  std::vector<solve::Ramp> _loads;
  struct Rigid
  {
    std::shared_ptr<StaticRigidBody> body;
    std::vector<std::size_t> contacts;
  };
  std::vector<Rigid> _rigid_bodies;
  std::vector<std::pair<std::size_t, std::span<const double>>> _angles; ///< of contacts whose master turns
  std::vector<std::unique_ptr<std::vector<double>>> _reached; ///< loads of the last solve, of those without a view
  /// Of the present solve. After an exception, which may be that of one rank, it stays until ranks are together again.
  std::unique_ptr<solve::IncrementSolver> _solver;
  bool _solving = false;
};
} // namespace dolfinx_impact::problems
