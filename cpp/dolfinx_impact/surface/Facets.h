// SPDX-License-Identifier: MIT
#pragma once
#include "FacetElement.h"
#include <cstdint>
#include <vector>

namespace dolfinx_impact::surface
{
/// Facets of a surface in flat arrays, with what contact needs of them. The same struct holds a rank's own facets and
/// candidates received from other ranks.
/// Two elements: displacements live on `displacement`, positions on `geometry`, whose degree is the larger of the
/// displacement's and the mesh's.
struct Facets
{
  int gdim = 3;
  FacetElement displacement;
  FacetElement geometry;
  /// Does the geometry of degree 2 belong to a smooth surface through the corners of facets of degree 1 (smooth.h)?
  bool smooth = false;
  /// Displacement nodes: nodes[facet*displacement.num_nodes() + i]. What they number is told by whoever made the
  /// struct: blocks of the space's dofmap (Surface), or entries of the pair's nodal map (search::Exchange).
  std::vector<std::int32_t> nodes;
  /// Reference and current positions of geometry nodes: X[(facet*geometry.num_nodes() + i)*gdim + c] [L].
  std::vector<double> X, x;
  /// +1 if the facet's own normal (tangent turned clockwise in the plane, a_1 x a_2 in space) points out of the body,
  /// else -1.
  std::vector<std::int8_t> orientation;
  /// One number per facet: 8 * number of the cell in the mesh's input + local facet. It depends neither on the ranks
  /// nor on their number, so ties that it decides do not either.
  std::vector<std::int64_t> id;

  std::size_t size() const { return orientation.size(); }
  const std::int32_t* nodes_of(std::size_t f) const { return nodes.data() + f * displacement.num_nodes(); }
  const double* X_of(std::size_t f) const { return X.data() + f * geometry.num_nodes() * gdim; }
  const double* x_of(std::size_t f) const { return x.data() + f * geometry.num_nodes() * gdim; }
};

/// Longest distance between corners of a facet in the reference configuration [L].
double diameter(const Facets& facets, std::size_t f);

/// Current positions from displacements: x = X + u.
/// @param[in,out] facets
/// @param[in] u nodal displacements, u[node*gdim + c], numbered as facets.nodes [L]
void move(Facets& facets, const double* u);
} // namespace dolfinx_impact::surface
