// SPDX-License-Identifier: MIT
#pragma once
#include "../search/BoxTree.h"
#include "Shape.h"
#include <cstdint>
#include <span>
#include <vector>

namespace dolfinx_impact::gap
{
/// Surface of straight facets: segments in the plane, triangles in space. Inside and outside are told by the normals of
/// facets, edges and vertices (at vertices weighted by the facets' angles: Baerentzen and Aanaes 2005). A point beside
/// the rim of an open surface is outside; within a twentieth of the facet it counts as over it, as on deformable
/// masters.
class FacetShape : public Shape
{
public:
  /// @param[in] gdim 2 or 3
  /// @param[in] points points[gdim*i + c] [L]
  /// @param[in] facets gdim points each. Segments have the obstacle on their left, triangles run counter-clockwise
  ///   seen from outside
  /// @throws std::invalid_argument for numbers out of range, facets without size, neighbours that are oriented
  ///   differently, more than two facets at an edge (in the plane: at a point)
  FacetShape(int gdim, std::span<const double> points, std::span<const std::int32_t> facets);

  int gdim() const override { return _gdim; }
  double largest_coordinate() const override;
  RigidPoint closest(std::span<const double> x) const override;

private:
  struct Vector
  {
    double v[3];
  };
  /// A facet with what belongs to its parts: itself, its edges (opposite to its points), its vertices.
  struct Facet
  {
    double x[3][3];
    Vector normal, edges[3], vertices[3];
    bool rim_edges[3], rim_vertices[3];
    double longest; ///< side [L]
  };
  struct Foot
  {
    const Facet* facet;
    int edge, vertex; ///< -1: not there
    double x[3], squared;
  };
  Foot foot(const Facet& facet, const double* x) const;

  int _gdim;
  std::vector<Facet> _facets;
  search::BoxTree _tree;
};
} // namespace dolfinx_impact::gap
