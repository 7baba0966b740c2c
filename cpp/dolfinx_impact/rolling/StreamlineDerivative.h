// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/owned.h"
#include "../surface/Surface.h"
#include <memory>
#include <span>
#include <vector>

namespace dolfinx_impact::rolling
{
/// Sparse matrix over the owned nodes of a space from entries at global numbers, which add up. Collective.
operators::OwnedMatrix nodal_matrix(const surface::FunctionSpace& V, std::span<const std::int64_t> rows,
                                    std::span<const std::int64_t> columns, std::vector<double> values);

/// The map u -> (Grad u) w at the nodes of surfaces, a matrix over the nodes of a space.
///
/// The derivative at a node is taken from where the material comes (upwind), so that what a node feels depends on what
/// lies upstream only, and sticking, a first-order equation along the streamline, has one solution. It is of second
/// order: on cells of degree 2 that of the facet upstream; on cells of degree 1 that of the parabola through three
/// points of the streamline, which for edges along the flow is the three-point backward difference. Where the material
/// enters the surface it is the slope of the first facet.
class StreamlineDerivative
{
public:
  /// @param[in] V displacement space
  /// @param[in] surfaces facets on this rank, which must live as long as this
  StreamlineDerivative(std::shared_ptr<const surface::FunctionSpace> V, std::vector<const surface::Facets*> surfaces);

  /// Matrix of the derivative along a flow [1/T]; rows of nodes off the surfaces, or without flow, are zero.
  /// Collective.
  /// @param[in] w velocity of the undeformed material at the nodes, owned and ghosts, [node*gdim + c] [L/T]
  operators::OwnedMatrix matrix(std::span<const double> w) const;

private:
  std::shared_ptr<const surface::FunctionSpace> _V;
  std::vector<const surface::Facets*> _surfaces;
};
} // namespace dolfinx_impact::rolling
