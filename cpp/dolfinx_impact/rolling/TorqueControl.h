// SPDX-License-Identifier: MIT
#pragma once
#include "BodyResponse.h"
#include "Torque.h"
#include "TorqueOfCandidates.h"

namespace dolfinx_impact::rolling
{
/// The angular velocity at which a body's torque has a given value, an unknown of RollingNewton.
class TorqueControl
{
public:
  /// @param[in] problem bodies and contacts
  /// @param[in] motion a Spin of the flow, whose rate is changed
  /// @param[in] target wanted torque [F L]
  TorqueControl(std::shared_ptr<const solve::EquilibriumProblem> problem, const Flow& flow, const Motion& motion,
                double target);

  const Torque& torque() const { return _torque; }
  double target() const { return _target; }
  /// Present angular velocity [1/T].
  double omega() const { return _torque.motion().rate->value[0]; }
  void set_omega(double omega) const { _torque.motion().rate->value[0] = omega; }
  /// Torque less its target, over contact force times largest radius [1]. Collective.
  double error(std::span<RollingContact* const> contacts) const;
  /// The same of a torque and the forces that it belongs to, owned [F]. Collective.
  double relative(double torque, std::span<const std::vector<double>> forces) const;
  /// Derivative of the bodies' residual by the angular velocity, owned [F T]. Collective.
  std::vector<double> residual_slope() const;

private:
  std::shared_ptr<const solve::EquilibriumProblem> _problem;
  Torque _torque;
  double _target, _reach;
};

/// The torque of linearised bodies as a function of multipliers and of the change of spin.
class ReducedTorque
{
public:
  /// Collective.
  /// @param[in] control target and torque; lives as long as this
  /// @param[in] contacts at the state that is linearised about
  /// @param[in] response of the bodies; lives as long as this
  ReducedTorque(const TorqueControl& control, std::span<RollingContact* const> contacts, BodyResponse& response);

  /// What was wrong with the bodies' responses; empty if nothing was.
  const std::string& fault() const { return _fault; }
  /// Derivative of the residual by the angular velocity, owned [F T].
  const std::vector<double>& load() const { return _load; }
  /// Derivatives of the slip velocities of the contacts by the angular velocity, vectors [L].
  const Candidates::ByContact& slopes() const { return _slopes; }
  /// Torque less its target, relative [1]. Collective.
  /// @param[in] forces multipliers as nodal forces, vectors [F]
  /// @param[in] moved displacements from the state that is linearised about, owned [L]
  double missing(const ContactOperators& operators, const Candidates::ByContact& forces,
                 std::span<const double> moved) const;
  /// Take the state that `gathered` counts from. Collective.
  void count_from(const ContactOperators& operators, const Candidates::ByContact& forces,
                  std::span<const double> moved);
  /// What rank 0 needs; without values on others. Collective.
  TorqueOfCandidates gathered(const ContactOperators& operators, const Candidates& candidates) const;

private:
  double value(std::span<const double> nodal_forces, std::span<const double> moved) const;

  const TorqueControl& _control;
  std::vector<RollingContact*> _contacts;
  std::vector<double> _load;
  Candidates::ByContact _slopes;
  double _speed = 0.0;
  std::vector<double> _forces; ///< contact forces of the state that is linearised about, owned [F]
  std::vector<double> _turned; ///< displacements by the angular velocity at constant forces, owned [L T]
  std::vector<double> _lever;  ///< displacements under `lever_of` those forces, owned
  std::string _fault;
  double _now = 0.0; ///< torque that `gathered` counts from [F L]
};
} // namespace dolfinx_impact::rolling
