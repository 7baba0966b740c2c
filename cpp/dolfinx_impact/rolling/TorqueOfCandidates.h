// SPDX-License-Identifier: MIT
#pragma once
#include "FrictionProblem.h"

namespace dolfinx_impact::rolling
{
/// Why a torque is not reached.
inline constexpr const char* no_friction = "it does not depend on the spin: nothing touches, or nothing rubs";
inline constexpr const char* out_of_reach =
    "friction cannot bear it, or the spin to begin with is too far from the solution";

/// Torque of linearised bodies as a function of the forces of candidate nodes and of the change of spin. On rank 0;
/// nothing communicates.
struct TorqueOfCandidates
{
  double wanted = 0.0;     ///< change of the torque [F L]
  std::vector<double> row; ///< derivatives by the forces of the candidates, [i*gdim + c] [L]
  double by_spin = 0.0;    ///< derivative by the angular velocity at constant forces [F L T]
  LinearState slope;       ///< derivative of the state by the angular velocity
  double speed = 0.0;      ///< of the surfaces [L/T]

  struct Solution
  {
    std::vector<double> forces; ///< [i*gdim + c] [F]
    double change = 0.0;        ///< of the angular velocity [1/T]
    std::string fault;          ///< what went wrong; empty if nothing did
  };
  /// Forces and the change of spin that make the wanted change of torque.
  /// @param[in] problem contact and friction of the candidates
  /// @param[in] state of the bodies without a change of spin
  Solution solve(const FrictionProblem& problem, const LinearState& state) const;
};
} // namespace dolfinx_impact::rolling
