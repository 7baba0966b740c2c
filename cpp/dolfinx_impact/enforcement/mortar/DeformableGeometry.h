// SPDX-License-Identifier: MIT
#pragma once
#include "MortarGeometry.h"

namespace dolfinx_impact::enforcement
{
/// Between two deformable surfaces: weighted gaps, and the matrices D and M of docs/contact.md, by mortar integrals.
class DeformableGeometry : public MortarGeometry
{
public:
  /// Collective.
  DeformableGeometry(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave, surface::Facets master,
                     const MortarOptions& options, std::vector<std::int8_t> fixed);

  const surface::Facets* master() const override { return &_master; }
  void update_cover(std::span<const double> u) override;
  std::vector<std::int8_t> covered() const override { return integrals().covered(); }
  std::vector<double> normal_sums() const override { return integrals().sums_at_nodes(); }
  void integrate(std::span<const std::int8_t> carriers) override;
  void update_own_gap(std::span<const std::int8_t> locked, const std::vector<double>* sums) override;
  std::vector<double> weighted_jump(std::span<const double> moved) const override;
  gap::MasterRows weighted_rows(std::span<const std::int32_t> rows, std::span<const double> weights) const override;
  std::vector<double> over_master(std::span<const double> values) const override;
  Mat tangent(std::span<const double> multiplier, std::span<const double> traction,
              std::span<const std::int8_t> active) override;
  std::vector<double> forces(std::span<const double> traction) const override;
  std::vector<double> edge_angles() const override;
  void set_least_cover(double part) override;
  void forget() override;

  /// Of the present state, or of the one that is evaluated.
  const gap::MortarIntegrals& integrals() const { return *_integrals[at()]; }
  gap::MortarIntegrals& integrals() { return *_integrals[at()]; }
  const search::PairSearch& search() const { return *_search; }
  /// Largest part of a unit normal that facets may tilt it by at a plane of symmetry: the sine of 5 degrees,
  /// docs/contact.md.
  double symmetry = 0.08715574274765817;

private:
  surface::Facets _master;
  bool _any_fixed; ///< on any rank
  std::shared_ptr<search::PairSearch> _search;
  std::array<std::unique_ptr<gap::MortarIntegrals>, 2> _integrals; ///< of both states
};
} // namespace dolfinx_impact::enforcement
