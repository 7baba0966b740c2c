// SPDX-License-Identifier: MIT
#pragma once
#include "../closest_point/PairSearch.h"
#include "SurfaceNodes.h"
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// A point of a surface that may touch any other part of it.
struct SearchingPoint
{
  std::int32_t facet;   ///< that it lies on, of the slave of the PairSearch
  const double* xi;     ///< reference coordinates there
  const double* x;      ///< position [L]
  const double* normal; ///< outward
  double depth;         ///< penetration in the last converged state, zero if it was open [L]
};

/// Closest points of a surface for points of itself: which facet a point has come through, or may come through.
///
/// Facets count that face the point's own one, share no node with it, and are not the far side of a body: a point is
/// behind a facet only if it was in front of it when the increment began, or behind by no more than the penetration
/// that it had and a twentieth of the cell's height. What a point is behind counts before what it is in front of, then
/// the nearest. A point over an edge or corner is behind it if it is behind all facets that meet there; and it is over
/// it only if it is closer to none of them.
class GeneralSearch
{
public:
  /// Part of the height of a cell by which a point may be behind its facet without having penetrated it.
  static constexpr double shallow_part = 0.05;

  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] facets this rank's facets of the surface (make_surface)
  /// @param[in] named pairs of surfaces whose facets do not meet here
  /// @throws std::invalid_argument on all ranks for too many pairs
  GeneralSearch(std::shared_ptr<const surface::FunctionSpace> V, const surface::Facets& facets,
                std::span<const NamedPair> named);

  /// To be called after `update` of the pair whose slave and master both are the surface. Collective.
  /// @param[in] start displacements when the increment began, owned and ghosts [L]
  void update(PairSearch& pair, std::span<const double> start);

  /// @param[in] reach search distance [L]
  /// @param[in] previous, margin see SurfaceSearch::project
  Projection project(const SearchingPoint& point, double reach, std::int32_t previous, double margin) const;

  /// How deep a point is inside of another body, whatever way its surfaces face; zero outside of all others, and where
  /// their surfaces are farther than the reach [L].
  double overlap(const SearchingPoint& point, double reach) const;
  /// Do two facets of the master belong to a pair of surfaces that is left to others?
  bool leaves_out(std::int32_t first, std::int32_t second) const;
  /// Number of bodies of the mesh.
  int num_bodies() const { return _surface.num_bodies; }
  /// Bodies of this rank's facets, and of the facets that they may meet after `update`.
  std::span<const std::int32_t> slave_bodies() const { return _slave.body; }
  std::span<const std::int32_t> master_bodies() const { return _master.body; }
  /// Height of the cell behind a facet of the master, after `update` [L].
  double height(std::int32_t facet) const { return _master.height[facet]; }
  /// The same behind this rank's facets [L].
  double own_height(std::int32_t facet) const { return _slave.height[facet]; }

private:
  /// By facet: what the nodes of all ranks tell.
  struct FacetValues
  {
    std::vector<std::int32_t> body;
    std::vector<double> height;
    std::vector<std::int64_t> group; ///< bits of the named surfaces that all nodes belong to
    std::vector<double> normal;      ///< at the centre, [f*gdim + c]; of the master alone
    /// Cosine between that normal and one of a point up to which no part of the facet faces the point; of the master.
    std::vector<double> facing;
    /// Of flat facets of the master: the centre, and the vectors whose products with the way from there are the change
    /// of the reference coordinates, [(f*3 + k)*gdim + c]; zero of others.
    std::vector<double> plane;
  };
  FacetValues values_of(const surface::Facets& facets, std::span<const double> at_nodes) const;
  bool far_beside(std::int32_t facet, const double* x) const;
  bool may_meet(std::int32_t own, std::int32_t other, const double* normal) const;
  bool came_through(const SearchingPoint& point, std::int32_t facet) const;
  bool set_side(const SearchingPoint& point, const FacetProjection& at, const surface::FacetPoint& p,
                Projection& out) const;

  std::shared_ptr<const surface::FunctionSpace> _space;
  SurfaceNodes _surface;
  int _gdim;
  std::vector<double> _owned; ///< body, height and groups of owned nodes, [node*3 + k]
  std::shared_ptr<const Exchange> _exchange;
  const SurfaceSearch* _now = nullptr;
  const surface::Facets* _own = nullptr;
  surface::Facets _slave_start, _master_start; ///< where the increment began
  FacetValues _slave, _master;
  double _motion = 0.0, _highest = 0.0; ///< see PairSearch::motion; largest height of a cell [L]
};
} // namespace dolfinx_impact::search
