// SPDX-License-Identifier: MIT
#pragma once
#include "BodyForces.h"
#include <memory>

namespace impact_reference
{
/// Acceleration and velocity at the end of a step as functions of the displacement there, each degree of freedom by
/// itself: a = a_slope (u - start) + a_rest, v = v_slope (u - start) + v_rest.
struct StepMotion
{
  Vector start;           ///< displacement at the start of the step [L]
  Vector a_slope, a_rest; ///< [1/T^2], [L/T^2]
  Vector v_slope, v_rest; ///< [1/T], [L/T]
};

/// Bodies at the end of a time step: inertia M a, Rayleigh damping C v with C = alpha M + beta K(u), internal forces.
class MovingBodies : public BodyForces
{
public:
  /// @param internal internal forces
  /// @param mass on the pattern of the model [M]
  /// @param alpha, beta factors of mass [1/T] and tangent stiffness [T]
  MovingBodies(std::unique_ptr<BodyForces> internal, Csr mass, double alpha, double beta);

  /// Call it before every step. @throws std::invalid_argument for wrong sizes
  void set_motion(StepMotion motion);

  Vector acceleration(const Vector& u) const; ///< [L/T^2]
  Vector velocity(const Vector& u) const;     ///< [L/T]
  Vector internal_force(const Vector& u) const { return internal_->force(u); }
  Vector inertia_force(const Vector& a) const { return mass_.dot(a); }
  Vector damping_force(const Vector& u, const Vector& v) const;
  const Csr& mass() const { return mass_; }

  Vector force(const Vector& u) const override;
  /// Without the derivative of K(u) in the damping, which Newton's method converges without.
  Csr tangent(const Vector& u) const override;
  double size(const Vector& u, const Vector& force) const override;

private:
  std::unique_ptr<BodyForces> internal_;
  Csr mass_;
  double alpha_, beta_, unit_size_;
  StepMotion motion_;
};

/// Mass matrix on the pattern of the model.
/// @param lumping "consistent", or a scheme of LumpedMass
/// @param redistributed by field node: nodes whose velocity in a cell's kinetic energy is the mean of the cell's other
/// nodes, weighted with the inverse squares of the distances; a cell that has no other nodes keeps its mass. Empty for
/// none. A lumped mass goes to the other nodes with the same weights.
Csr inertia_matrix(const Model& model, const Rule& rule, const std::string& lumping,
                   const std::vector<bool>& redistributed);

/// Solves M a = force for the accelerations of the degrees of freedom that are neither prescribed nor without mass.
/// @param a accelerations, of which those that are prescribed are right, and the massless ones are zero
/// @throws std::runtime_error if the mass matrix is singular
Vector solve_acceleration(const Csr& mass, const Vector& force, Vector a, const std::vector<bool>& unknown);
} // namespace impact_reference
