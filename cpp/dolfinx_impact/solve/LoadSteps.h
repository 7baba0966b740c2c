// SPDX-License-Identifier: MIT
#pragma once
#include "EquilibriumProblem.h"
#include "Increment.h"
#include "SolveSeconds.h"
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::solve
{
/// A load that is applied in parts: views of its present value and of the value that the last solve has reached.
struct Ramp
{
  std::span<double> value, reached;
};

/// Course of a solve; lists have one entry per converged increment.
struct LoadStepReport
{
  bool converged = true;
  std::vector<int> iterations;                             ///< linearised problems
  std::vector<std::vector<double>> residual_norms;         ///< by increment and iteration [F]
  std::vector<std::vector<std::int64_t>> active_set_sizes; ///< by increment and iteration
  std::vector<std::vector<std::int64_t>> contact_changes;  ///< by increment and iteration
  std::vector<double> fractions;                           ///< of the load step, reached at the end
  int cut_backs = 0;                                       ///< increments that were halved
  std::vector<int> rejected_iterations;                    ///< of each increment that was halved
  std::vector<int> unsettled;                              ///< iterations whose active set did not converge
  SolveSeconds seconds;                                    ///< time spent on this rank
  std::vector<std::string> brought_together;               ///< what bring_together has moved, in words
  std::vector<std::string> lost;                           ///< contacts that were closed and carry no force at the end

  void add(const Increment& increment, double fraction);
};

/// Whom a solve tells what it does; functions may be empty. They are called on all ranks, and may throw.
struct LoadStepEvents
{
  std::function<void(const std::string&)> log;     ///< a line of the log
  std::function<void(int, double, double)> begins; ///< an increment: number, fractions of the step at start and end
  std::function<void(double)> accepted;            ///< a converged increment: fraction of the step
};

struct LoadStepOptions
{
  int steps = 1;     ///< number of equal increments
  int cut_backs = 0; ///< largest number of times that the increment is halved
  /// Whether bodies that are apart are brought together where an increment finds no equilibrium (bring_together).
  bool brings_together = true;
};

/// Loads, prescribed displacements and obstacles go from their values at the last solve to their present ones, in
/// increments that are halved where they do not converge: seed figure 3.5.
class LoadSteps
{
public:
  /// Solves from the present displacements to prescribed ones, owned and ghosts. Collective.
  typedef std::function<Increment(std::span<const double>)> Solver;
  /// Displacement of a rigid master; nothing for deformable ones [L].
  typedef std::optional<std::array<double, 3>> Displacement;

  /// @param[in] problem bodies and contacts
  /// @param[in] target displacements at the end, owned and ghosts, of which prescribed entries are read [L]
  /// @param[in] loads that are applied in parts, at their values of the end
  /// @param[in] obstacles displacement of each contact's rigid master at the end [L]
  LoadSteps(std::shared_ptr<const EquilibriumProblem> problem, std::vector<double> target, std::vector<Ramp> loads,
            std::vector<Displacement> obstacles, LoadStepEvents events = {});

  /// Turn the rigid master of a contact.
  /// @param[in] angle view of its rotation vector since the reference configuration, of a load that is applied in
  /// parts [1]
  void turn(std::size_t contact, std::span<const double> angle) { _angles[contact] = angle; }
  /// Solve all increments. Collective.
  /// @throws std::runtime_error an increment did not converge; the problem is in its last converged state then, as
  /// after exceptions of `solver` and events
  LoadStepReport run(const Solver& solver, LoadStepOptions options);

private:
  std::vector<double> target(double fraction) const;
  void begin(double fraction);
  void go_back(std::span<const double> u, const std::vector<state::State>& contacts);
  void finish(double fraction);
  void log(const std::string& text) const;

  std::shared_ptr<const EquilibriumProblem> _problem;
  std::vector<double> _start, _target;
  std::vector<Ramp> _loads;
  std::vector<std::vector<double>> _load_ends;
  std::vector<Displacement> _obstacle_starts, _obstacles;
  std::vector<std::span<const double>> _angles; ///< of rigid masters that turn as prescribed; empty: of others
  LoadStepEvents _events;
};
} // namespace dolfinx_impact::solve
