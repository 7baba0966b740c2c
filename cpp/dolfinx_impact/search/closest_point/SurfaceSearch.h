// SPDX-License-Identifier: MIT
#pragma once
#include "../../surface/normals.h"
#include "../BoxTree.h"
#include "Projection.h"
#include "facet_projection.h"
#include <vector>

namespace dolfinx_impact::search
{
/// How far beside its facet a point may be and keep it, in reference coordinates. Where a penetrating point changes
/// facets at a kink, its coordinate jumps by penetration times angle over length: a Newton iteration that sees the jump
/// every time does not converge.
inline constexpr double keep_margin = 1e-2;

/// Closest points of a surface. Among facets at one distance (to 1e-12 of it and of their size) those on which the
/// point lies inside come first, then the lowest id. A point beside the surface, beyond an edge or vertex at which it
/// ends, is outside of the master: its gap is positive.
class SurfaceSearch
{
public:
  /// @param[in] master facets, kept by reference: they must outlive this
  explicit SurfaceSearch(const surface::Facets& master);
  /// To be called when the facets have moved.
  void update();
  const surface::Facets& master() const { return *_master; }
  /// Boxes of the facets.
  const BoxTree& tree() const { return _tree; }
  /// Diagonal of the box of a facet [L].
  double size(std::int32_t f) const { return _size[f]; }
  /// From where on a facet the projection of a point has to start.
  Starts starts(std::int32_t f, const double* x) const;

  /// @param[in] x point, gdim coordinates [L]
  /// @param[in] slave_normal normal at x, out of the slave; only facets that face it are considered
  /// @param[in] reach search distance [L]
  /// @param[in] previous facet of the last projection, or -1: kept as long as the point lies over it or beside it by no
  /// more than the margin, if no other facet is clearly nearer; so points over a common edge do not
  /// jump to and fro
  /// @param[in] margin in reference coordinates
  Projection project(const double* x, const double* slave_normal, double reach, std::int32_t previous = -1,
                     double margin = keep_margin) const;

private:
  void finish(const double* x, const FacetProjection& at, Projection& out) const;
  bool mean_normal(const FacetProjection& at, std::int32_t facet, double* normal) const;

  const surface::Facets* _master;
  BoxTree _tree;
  std::vector<double> _boxes;
  std::vector<Bend> _bend;
  std::vector<double> _size; ///< diagonals of their boxes [L]
};
} // namespace dolfinx_impact::search
