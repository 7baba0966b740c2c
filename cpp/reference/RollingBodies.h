// SPDX-License-Identifier: MIT
#pragma once
#include "BodyForces.h"

namespace impact_reference
{
/// How the material flows through a body that stands: w = spin x (X - centre), or a constant.
struct BodyFlow
{
  Vector spin;     ///< angular velocity, one number in the plane, three in space; empty for a translation [1/T]
  Vector centre;   ///< on the axis (gdim) [L]
  Vector velocity; ///< of a translation (gdim) [L/T]
};

/// Matrices of bodies whose material flows, seed (3.54)-(3.57).
struct FlowMatrices
{
  Csr gyroscopic; ///< G [M/T]
  Csr inertia;    ///< W [M/T^2]
  Vector load;    ///< of spinning bodies [F]
};

/// @param body number of the body of every cell
/// @param flows one per body
/// @throws std::invalid_argument for a wrong number of cells, or a body without flow
FlowMatrices flow_matrices(const Model& model, const Rule& rule, const std::vector<std::int64_t>& body,
                           const std::vector<BodyFlow>& flows);

/// Elastic bodies in the ALE frame, without the constant load: f(u) - W u.
class RollingBodies : public BodyForces
{
public:
  /// @param model must outlive this object
  RollingBodies(const Model& model, Rule rule, Csr inertia);

  Vector force(const Vector& u) const override;
  Csr tangent(const Vector& u) const override;
  double size(const Vector& u, const Vector& force) const override;
  double unit_size() const override { return internal_.unit_size(); }

private:
  ElasticForces internal_;
  Csr inertia_;
};
} // namespace impact_reference
