// SPDX-License-Identifier: MIT
#pragma once
#include "MortarIntegrals.h"
#include "Rigid.h"

namespace dolfinx_impact::gap
{
/// Areas of a slave's nodes against a rigid obstacle: integrals of the nodes' functions over the facets that face it.
class FacingShares
{
public:
  /// @param[in] slave this rank's facets, numbered as V
  /// @param[in] rule on the reference facet
  FacingShares(const std::shared_ptr<const surface::FunctionSpace>& V, const surface::Facets& slave,
               MultiplierNodes nodes, const SegmentRule& rule, Multipliers basis, bool axisymmetric);

  /// Areas by the multiplier nodes [L, L^2]. Collective.
  /// @param[in] slave as given, moved
  std::vector<double> evaluate(const surface::Facets& slave, const Rigid& obstacle);
  /// Numbers (Facets::id) of the facets that took no part in the last evaluation: they lie round a sharp edge.
  const std::vector<std::int64_t>& aside() const { return _aside; }

private:
  std::shared_ptr<const dolfinx::common::IndexMap> _map;
  MultiplierNodes _nodes;
  std::vector<double> _integrals; ///< by facet and node
  std::vector<std::int64_t> _aside;
};
} // namespace dolfinx_impact::gap
