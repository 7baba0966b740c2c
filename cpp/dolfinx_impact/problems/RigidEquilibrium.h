// SPDX-License-Identifier: MIT
#pragma once
#include "../solve/EquilibriumProblem.h"
#include "../solve/Increment.h"
#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::problems
{
/// A rigid body of a static problem, which loads and contacts move; it does not rotate.
struct StaticRigidBody
{
  std::vector<std::size_t> contacts; ///< numbers of those whose master it is
  std::array<bool, 3> fixed{};       ///< components that stay
  std::span<const double> force;     ///< external, three components, at the present part of the load step [F]
};

/// Equilibrium of rigid bodies: places at which external forces and contact forces cancel, by Broyden's method over
/// their free components. Each evaluation is a solution of the deformable bodies with the rigid ones held there;
/// docs/rigid_bodies.md, "Statics".
class RigidEquilibrium
{
public:
  /// Solves an increment with the rigid bodies held, from the present displacements. Collective.
  typedef std::function<solve::Increment(std::span<const double>)> Solver;

  /// Tolerance of the rigid bodies' equilibrium, relative to the largest external or contact force on one [1].
  static constexpr double tolerance = 1e-8;

  /// @throws std::invalid_argument for a body without contacts, or of a contact that has no rigid master
  RigidEquilibrium(std::shared_ptr<const solve::EquilibriumProblem> problem, std::vector<StaticRigidBody> bodies,
                   std::function<void(const std::string&)> log = {});

  /// Solve an increment that contacts have begun. Collective.
  /// @param[in] target displacements, owned and ghosts, of which prescribed entries are read [L]
  solve::Increment run(const Solver& solver, std::span<const double> target);

private:
  struct Free
  {
    std::size_t body;
    int component;
  };
  struct Answer
  {
    solve::Increment increment;
    std::vector<double> missing; ///< force that equilibrium lacks, by free component [F]
    double size = 0.0;           ///< largest external or contact force [F]
    bool touches = false;        ///< is there a contact force on each body that has free components?
  };
  Answer evaluate(const Solver& solver, std::span<const double> target, const std::vector<double>& q);
  /// Move bodies that touch nothing along the forces on them until they do. @returns whether they do
  bool approach(const Solver& solver, std::span<const double> target, std::vector<double>& q, Answer& now);
  solve::Increment fail(solve::Increment increment, std::string why) const;

  std::shared_ptr<const solve::EquilibriumProblem> _problem;
  std::vector<StaticRigidBody> _bodies;
  std::vector<Free> _free;
  std::function<void(const std::string&)> _log;
  double _size; ///< of the deformable bodies [L]
  // What an increment starts from.
  std::vector<double> _start;
  std::vector<state::State> _saved;
  std::vector<std::optional<std::array<double, 3>>> _obstacles;
  std::vector<double> _stiffness; ///< derivative of the missing forces of the last increment, [i*n + j]; empty: none
  int _iterations = 0;
};
} // namespace dolfinx_impact::problems
