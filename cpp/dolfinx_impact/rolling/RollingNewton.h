// SPDX-License-Identifier: MIT
#pragma once
#include "../solve/Newton.h"
#include "ReducedContacts.h"
#include "TorqueControl.h"

namespace dolfinx_impact::rolling
{
/// Newton's method for steady rolling with friction: displacements and multipliers together, docs/rolling.md.
///
/// Each iteration linearises bodies and geometry once, and solves contact and friction of the linear bodies, reduced to
/// the multipliers of the nodes that touch (ReducedContacts).
class RollingNewton
{
public:
  /// @param[in] problem whose contacts are RollingContacts, all of them
  /// @param[in] options of Newton's method; the option contact_tolerance sets the largest violation of contact and
  /// friction
  /// @param[in] reduced contacts, which live as long as this
  /// @throws std::invalid_argument for another contact, or options that are not positive
  RollingNewton(std::shared_ptr<const solve::EquilibriumProblem> problem, const solve::NewtonOptions& options,
                ReducedContacts& reduced, solve::NewtonEvents events = {});

  /// Solve from the present displacements to prescribed values. Collective.
  /// @param[in] target displacements, owned and ghosts, of which prescribed entries are read [L]
  /// @returns iterations; their `fault` says why they did not converge
  solve::Increment run(std::span<const double> target);

  /// Torque control that makes a spin an unknown; null: rates are given. It lives as long as runs use it.
  const TorqueControl* control = nullptr;
  const solve::SolveSeconds& seconds() const { return _frictionless.seconds; }

private:
  /// A state of the linearised problem.
  struct Trial
  {
    Candidates::ByContact multipliers; ///< vectors [F/L^2]
    Candidates::ByContact gaps;        ///< [L]
    Candidates::ByContact slips;       ///< [L/T]
    std::vector<SteadyFriction> laws;  ///< contact and friction at these
    double off = 0.0; ///< what multipliers differ by from those that the laws make of them, over the largest [1]
  };

  solve::Increment with_friction(std::span<const double> target);
  std::pair<std::string, int> solve_linearised(Mat K, std::span<const double> residual, std::span<const double> jump);
  std::vector<std::vector<std::int8_t>> near(const Trial& trial) const;
  Trial trial(std::span<const double> moved, Candidates::ByContact multipliers, double change,
              const ReducedTorque* torque) const;
  double change(const Trial& trial) const;
  std::int64_t num_active() const;
  double norm(std::span<const double> values) const { return _frictionless.norm(values); }
  void log(const std::string& text) const;

  std::shared_ptr<const solve::EquilibriumProblem> _problem;
  solve::NewtonOptions _options;
  solve::NewtonEvents _events;
  ReducedContacts& _reduced;
  std::vector<RollingContact*> _contacts;
  /// Without friction, to begin with: active sets and forces to start from.
  solve::Newton _frictionless;
  double _violation; ///< largest of contact and friction in a solution
};
} // namespace dolfinx_impact::rolling
