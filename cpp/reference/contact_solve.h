// SPDX-License-Identifier: MIT
#pragma once
#include "BodyForces.h"
#include "contact_mortar.h"
#include "solve.h"
#include <functional>

namespace impact_reference
{
/// What drives a contact problem.
struct ContactLoads
{
  std::vector<std::int64_t> fixed_dofs;
  Vector values;    ///< on the fixed degrees of freedom [L]
  Vector load;      ///< (num_dofs) [F]
  RigidPlace place; ///< of the rigid obstacle
};

struct ContactOptions
{
  int steps = 1;            ///< equal steps from the state before; one that fails is halved, up to eight times
  int max_iterations = 60;  ///< of Newton's method in a step
  double tolerance = 1e-12; ///< on the residual over the forces, or on the correction over the displacement
  bool augmented = false;   ///< Uzawa's method on multipliers at the corners of the slave's facets
  bool halve = true;        ///< false: a step that fails is an error
  int in_a_row = 1;         ///< iterations in a row that must meet the tolerance
};

/// A converged state; another analysis may start from it.
struct ContactState
{
  Vector u;               ///< [L]
  Vector load;            ///< [F]
  ContactHistory history; ///< of this state
  Vector multiplier;      ///< of the augmented method, per corner of the slave's facets; empty before the first step
  Matrix z;               ///< multipliers of the mortar method (num_nodes, gdim) [F/L^2]
};

struct ContactSolution
{
  ContactState state;
  Vector contact_force; ///< (num_dofs) [F]
  Vector reactions;     ///< on fixed degrees of freedom, zero elsewhere [F]
  std::vector<int> iterations;
  std::vector<double> residuals;
  ContactPoints points; ///< penalty method
  // Mortar method, per field node:
  Vector pressure, gap; ///< gap +infinity where no multiplier lives
  std::vector<ContactStatus> status;
};

/// Penalty method: Newton's method with the full tangent and sparse LU.
/// @param bodies forces of the bodies
/// @param contact_rule of the slave's facets
/// @throws std::runtime_error if it does not converge
ContactSolution solve_penalty(const ContactPair& pair, const BodyForces& bodies, const Rule& contact_rule, double chi,
                              double chi_t, const ContactState& start, const ContactLoads& loads,
                              const ContactOptions& options);

class SteadySlip;

/// Multipliers at the slave's nodes: semismooth Newton method on the saddle-point system.
/// @param contact_rule of segments, or of the slave's facets if the master is rigid
/// @param steady nullptr: friction counts the slip since the last converged state; else that of a steady flow
ContactSolution solve_lagrange(const ContactPair& pair, const BodyForces& bodies, const Rule& contact_rule, Basis basis,
                               const ContactState& start, const ContactLoads& loads, const ContactOptions& options,
                               const SteadySlip* steady = nullptr);

/// A step without contact.
struct FreeSolution
{
  Vector u;         ///< [L]
  Vector reactions; ///< on fixed degrees of freedom, zero elsewhere [F]
  int iterations = 0;
  double residual = 0; ///< relative
};

/// Newton's method for bodies without contact.
/// @param u where it starts
/// @throws std::runtime_error if it does not converge
FreeSolution solve_free(const Model& model, const BodyForces& bodies, Vector u, const ContactLoads& loads,
                        const ContactOptions& options);

namespace detail
{
/// Free degrees of freedom, prescribed values and the linear algebra of both methods.
class System
{
public:
  System(const Model& model, const BodyForces& bodies, const ContactLoads& loads);

  Vector body_force(const Vector& u) const { return bodies_.force(u); }
  double size(const Vector& u, const Vector& force) const { return bodies_.size(u, force); }
  Entries stiffness(const Vector& u) const;
  std::int64_t num_free() const { return num_free_; }
  const std::vector<std::int64_t>& numbers() const { return numbers_; } ///< -1 where fixed
  Vector free(const Vector& r) const;
  /// u + change at the fixed degrees of freedom, and free(u) + correction elsewhere.
  void correct(Vector& u, const Vector& change, const Vector& correction) const;
  /// What is missing to `values` on the fixed degrees of freedom.
  Vector missing(const Vector& u, const Vector& values) const;
  Vector reactions(const Vector& u, const Vector& load, const Vector& contact) const;

  const ContactLoads& loads_;

private:
  const BodyForces& bodies_;
  std::vector<std::int64_t> numbers_;
  std::int64_t num_free_;
};

/// Solution of a sparse system, or nothing if it is singular.
std::optional<Vector> solve(const Entries& entries, const Vector& right);

/// Part of a correction that is taken: some rounds of half steps end an iteration that jumps to and fro between two
/// states of contact; full steps converge quadratically.
inline double relaxation(int iteration)
{
  return (iteration / 10) % 2 == 0 ? 1 : 0.5;
}

/// Loads between two states.
struct Target
{
  Vector values, load;
};

/// Runs `newton(pair, state, target)` from state to state; it returns false, and may spoil the state, if it fails. The
/// pair it is given has the obstacle where the step wants it.
using Step = std::function<bool(const ContactPair&, ContactState&, const Target&, ContactSolution&)>;
ContactSolution solve_in_steps(const System& system, const ContactPair& pair, const ContactState& start,
                               const ContactOptions& options, const Step& step);
} // namespace detail
} // namespace impact_reference
