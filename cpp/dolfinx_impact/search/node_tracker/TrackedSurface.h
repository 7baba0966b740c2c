// SPDX-License-Identifier: MIT
#pragma once
#include "../../surface/Facets.h"
#include "../BoxTree.h"
#include "../closest_point/Projection.h"
#include "Configuration.h"
#include "MasterNode.h"
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// The master surface of a NodeTracker. It owns the facets, the positions of their nodes at the last step, the facets'
/// diameters and the tree of their boxes. It answers what concerns a single facet: positions of its nodes in a
/// configuration, closest point, normal, box. Facets of degree 1 take inlined functions (linear_facet.h).
class TrackedSurface
{
public:
  /// Shapes of degree 1 have the values of surface::FacetShape; general: any other facet.
  enum class Kind : int
  {
    interval,
    triangle,
    quadrilateral,
    general
  };

  /// Take other facets. Their nodes' positions are zero until the next RelativeMotion::advance.
  /// @param[in] facets sorted by id; facets that share a node have the same position of it, to the last bit
  void reset(surface::Facets facets);

  const surface::Facets& facets() const { return _facets; }
  Kind kind() const { return _kind; }
  /// Longest distance between corners of a facet in the reference configuration [L].
  double diameter(std::int32_t facet) const { return _diameters[facet]; }
  double largest_diameter() const { return _largest; }

  /// Displacement nodes, ascending, without repetition.
  std::span<const std::int32_t> nodes() const { return _nodes; }
  /// Data of these nodes, by their position in `nodes`.
  const MasterNode* node_data() const { return _node_data.data(); }
  MasterNode* node_data() { return _node_data.data(); }
  /// Reference position of node k of `nodes` [L].
  const double* X(std::size_t k) const { return _undeformed.data() + k * _facets.gdim; }
  /// Displacement nodes of a facet, by their position in `nodes`.
  const std::int32_t* corners(std::int32_t facet) const
  {
    return _corners.data() + std::size_t(facet) * _nodes_per_facet;
  }
  /// A place of the surface moves by no more than this times the largest motion of a node: 1, and more where smooth
  /// facets turn [1].
  double stretch() const { return _stretch; }
  /// Upper bound on the distance of the surface in the configuration X + u from the stored one [L].
  double moved(const double* u) const;

  /// Positions of a facet's geometry nodes, x[i*gdim + c] [L].
  void positions(std::int32_t facet, Configuration configuration, double* x) const;
  /// Closest point of a facet.
  /// @param[in] nodes positions of its geometry nodes [L]
  /// @param[in] x point [L]
  /// @param[in] start reference coordinates near it, or null
  FacetProjection project(std::int32_t facet, const double* nodes, const double* x, const double* start) const;
  /// Unit normal of a facet, out of the master, at reference coordinates xi.
  void normal(std::int32_t facet, const double* nodes, const double* xi, double* normal) const;
  /// The same in the configuration u - du, at less cost for facets of degree 1.
  /// @param[in] u, du as at the last `advance` [L]
  void normal_before(std::int32_t facet, const double* xi, const double* u, const double* du, double* normal) const;
  /// Upper bound on the rotation rate of that normal (NormalRotation) [1/L].
  double rotation_rate(std::int32_t facet, const double* nodes, const double* xi) const;
  /// Distance of a point from the box around a facet's stored positions: a lower bound on the facet's distance. Zero
  /// for facets of degree 2 that are not smooth ones [L].
  double box_distance(std::int32_t facet, const double* x) const;
  /// Closest point of the surface from that of its nearest facet: signs the gap, and treats edges, vertices and the
  /// rim.
  /// @param[in] x point [L]
  /// @param[in] facet the nearest one
  /// @param[in] normal the facet's normal at the closest point
  /// @param[in] at closest point of the facet
  /// @param[in] near facets among which are all that meet at the closest point
  Projection closest_point(const double* x, std::int32_t facet, const double* normal, const FacetProjection& at,
                           Configuration configuration, std::span<const std::int32_t> near) const;

  /// Fit the tree to the facets in the configuration u.
  void fit_tree(const double* u);
  /// BoxTree::nearest in the configuration of the last `fit_tree`.
  template <typename Visitor>
  void nearest(const double* x, double squared_limit, Visitor visit) const
  {
    _tree.nearest(x, squared_limit, visit);
  }

  /// Number of projections on one facet so far.
  std::int64_t projections() const { return _projections; }
  /// Count projections that were made elsewhere.
  void count_projections(std::int64_t num) { _projections += num; }

private:
  template <surface::FacetShape S>
  void flat_normal_before(std::int32_t facet, const double* xi, double* normal) const;
  template <int gdim>
  void smooth_positions(std::int32_t facet, Configuration configuration, double* x) const;
  bool mean_normal(const FacetProjection& at, std::int32_t facet, Configuration configuration,
                   std::span<const std::int32_t> near, double* normal) const;

  surface::Facets _facets;
  Kind _kind = Kind::general;
  std::vector<double> _diameters, _phi; ///< _phi: shape functions of displacements at geometry nodes
  double _largest = 0.0, _slope = 2.0;  ///< _slope: NormalRotation
  std::vector<double> _offsets;         ///< of smooth facets: surface::offset_components
  double _stretch = 1.0;
  std::vector<double> _centre; ///< derivatives of the shape functions of displacements at the centre
  std::vector<double> _height; ///< of smooth facets: how far they leave the flat facet between their corners [L]
  std::vector<Starts> _starts; ///< of smooth facets
  BoxTree _tree;
  std::vector<double> _boxes;
  std::vector<std::int32_t> _nodes, _corners;
  int _nodes_per_facet = 0;
  std::vector<double> _undeformed;
  std::vector<MasterNode> _node_data;
  mutable std::int64_t _projections = 0;
};
} // namespace dolfinx_impact::search
