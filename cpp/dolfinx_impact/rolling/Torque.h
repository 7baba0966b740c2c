// SPDX-License-Identifier: MIT
#pragma once
#include "../solve/EquilibriumProblem.h"
#include "Flow.h"

namespace dolfinx_impact::rolling
{
/// Moment of the contact forces on a body about the axis of its spin, which moves with the body's supports.
class Torque
{
public:
  /// @param[in] problem bodies and contacts
  /// @param[in] motion a Spin of the flow, which lives as long as this
  Torque(std::shared_ptr<const solve::EquilibriumProblem> problem, const Flow& flow, const Motion& motion);

  const Motion& motion() const { return *_motion; }
  /// Displacement of the axis: in each component the mean of the body's prescribed ones [L]. Collective.
  std::array<double, 3> axle() const;
  /// Torque that forces take: minus their moment at deformed places [F L]. Collective.
  /// @param[in] forces contact forces, owned [F]
  double of(std::span<const double> forces) const;
  /// What displacements add to it [F L]. Collective.
  /// @param[in] moved displacements by which places change, owned [L]
  double of(std::span<const double> forces, std::span<const double> moved) const;
  /// Derivative of the torque by forces, owned [L]. Collective.
  std::vector<double> lever() const;
  /// Derivative of `of(forces, moved)` by the displacements, owned [F].
  std::vector<double> lever_of(std::span<const double> forces) const;
  /// Set the velocities of the body's owned nodes to those of a rigid body that turns with the spin about the axis.
  /// Collective.
  /// @param[in,out] velocities [node*gdim + c] [L/T]
  void set_rigid_velocities(std::vector<double>& velocities) const;
  /// Largest distance of a node from the axis [L]. Collective.
  double reach() const;

private:
  std::vector<double> deformed() const;
  void turned(const double* vector, double* out) const;
  std::size_t num_owned() const { return _problem->num_owned(); }
  double sum_over_ranks(double here) const;

  std::shared_ptr<const solve::EquilibriumProblem> _problem;
  const Motion* _motion;
  int _gdim;
  std::vector<std::int32_t> _nodes; ///< of the body, owned
  std::vector<double> _arm;         ///< from the point on the axis to the nodes, [i*3 + c] [L]
};
} // namespace dolfinx_impact::rolling
