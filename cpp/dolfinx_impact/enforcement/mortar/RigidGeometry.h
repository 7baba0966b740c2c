// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/FacingShares.h"
#include "MortarGeometry.h"

namespace dolfinx_impact::enforcement
{
/// The slave's nodes against an obstacle whose distance is known in closed form; multipliers are nodal.
class RigidGeometry : public MortarGeometry
{
public:
  /// Collective.
  /// @param[in] obstacle at rest; pairs with the same object have the same master
  /// @throws std::invalid_argument for another basis than the dual one, or an obstacle of another dimension
  RigidGeometry(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave,
                std::shared_ptr<const gap::Rigid> obstacle, const MortarOptions& options,
                std::vector<std::int8_t> fixed);

  const gap::Rigid* obstacle() const override { return _given.get(); }
  void update_cover(std::span<const double> u) override;
  std::vector<std::int8_t> covered() const override { return std::vector<std::int8_t>(num_nodes(), 1); }
  std::vector<double> normal_sums() const override { return now().normal; }
  void integrate(std::span<const std::int8_t> carriers) override;
  void update_own_gap(std::span<const std::int8_t> locked, const std::vector<double>* sums) override;
  std::vector<double> weighted_jump(std::span<const double> moved) const override;
  gap::MasterRows weighted_rows(std::span<const std::int32_t> rows, std::span<const double> weights) const override;
  std::vector<double> over_master(std::span<const double>) const override;
  Mat tangent(std::span<const double> multiplier, std::span<const double> traction,
              std::span<const std::int8_t> active) override;
  std::vector<double> forces(std::span<const double> traction) const override;

private:
  std::shared_ptr<const gap::Rigid> _given;
  gap::Rigid _obstacle; ///< at its present place
  gap::FacingShares _shares;
  operators::CooMatrix _turning;
};
} // namespace dolfinx_impact::enforcement
