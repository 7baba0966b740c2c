// SPDX-License-Identifier: MIT
#pragma once
#include "../solve/EquilibriumProblem.h"
#include "../solve/Increment.h"
#include "../solve/RigidEquations.h"
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
/// A rigid body that equilibrium moves.
struct RigidMember
{
  std::shared_ptr<solve::RigidEquations> equations;
  std::vector<std::size_t> contacts; ///< numbers of those whose master it is
};

/// Equilibrium of rigid bodies, static or in a step of implicit dynamics: values of their unknowns at which nothing is
/// missing, by Broyden's method. Each evaluation is a solution of the deformable bodies with the rigid ones held there;
/// docs/rigid_bodies.md, "Statics".
class RigidEquilibrium
{
public:
  /// Solves an increment with the rigid bodies held, from the present displacements. Collective.
  typedef std::function<solve::Increment(std::span<const double>)> Solver;

  /// Tolerance of the rigid bodies' equilibrium, relative to the largest force on one [1].
  static constexpr double tolerance = 1e-8;

  /// @throws std::invalid_argument for a body without contacts, or of a contact that has no rigid master, or one that
  /// cannot turn
  RigidEquilibrium(std::shared_ptr<const solve::EquilibriumProblem> problem, std::vector<RigidMember> bodies,
                   std::function<void(const std::string&)> log = {});

  /// Solve an increment that contacts have begun. Collective.
  /// @param[in] target displacements, owned and ghosts, of which prescribed entries are read [L]
  solve::Increment run(const Solver& solver, std::span<const double> target);
  /// Derivatives of contact forces that the last increment has found, which the next one begins with: what a restart
  /// needs; empty: none [F/L].
  const std::vector<double>& stiffness() const { return _stiffness; }
  void set_stiffness(std::vector<double> stiffness) { _stiffness = std::move(stiffness); }
  void set_log(std::function<void(const std::string&)> log) { _log = std::move(log); }
  /// Most iterations of one solution of the deformable bodies in the last increment.
  int most_iterations() const { return _most_iterations; }
  /// Values of the unknowns of a body in the last solution [L].
  std::vector<double> solution(std::size_t body) const;

private:
  struct Answer
  {
    solve::Increment increment;
    std::vector<double> missing; ///< force that equilibrium lacks, by unknown [F]
    double size = 0.0;           ///< largest of the forces that should balance [F]
    double round_off = 0.0;      ///< of these forces [F]
    bool touches = false;        ///< is there a contact force on each body that needs one?
  };
  Answer evaluate(const Solver& solver, std::span<const double> target, const std::vector<double>& q);
  /// Move bodies that touch nothing along the forces on them until they do. @returns whether they do
  bool approach(const Solver& solver, std::span<const double> target, std::vector<double>& q, Answer& now);
  solve::Increment fail(solve::Increment increment, std::string why) const;
  std::string component(std::size_t unknown) const;
  std::vector<double> derivatives() const;

  std::shared_ptr<const solve::EquilibriumProblem> _problem;
  std::vector<RigidMember> _bodies;
  std::vector<std::size_t> _first; ///< unknown of each body, and their number
  bool _needs_contact = false;
  std::function<void(const std::string&)> _log;
  double _size; ///< of the deformable bodies [L]
  // What an increment starts from.
  std::vector<double> _start;
  std::vector<state::State> _saved;
  std::vector<std::optional<std::array<double, 3>>> _obstacles;
  std::vector<std::optional<gap::Matrix3>> _rotations;
  /// Derivative of the missing forces of the last increment without that of the bodies' own equations, [i*n + j];
  /// empty: none [F/L].
  std::vector<double> _stiffness;
  std::vector<double> _solution;
  std::vector<std::int8_t> _unheld; ///< unknowns that nothing resisted when `_stiffness` was measured
  int _iterations = 0, _most_iterations = 0;
};
} // namespace dolfinx_impact::problems
