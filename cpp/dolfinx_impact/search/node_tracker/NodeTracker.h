// SPDX-License-Identifier: MIT
#pragma once
#include "CandidateLists.h"
#include "NodeBatch.h"
#include "RelativeMotion.h"
#include "SkipSchedule.h"
#include "SlaveNormals.h"
#include "nearest_facet.h"
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// Closest points of a moving surface to slave nodes, step after step: the same as those of SurfaceSearch::project, at
/// much lower cost.
///
/// RelativeMotion bounds how far nodes and surface have moved. A node that was seen at a distance is skipped until that
/// bound has used the distance up (SkipSchedule). For a node close to the surface, the facets that can become the
/// nearest one are listed (CandidateLists); the tree of all facets is searched only when that list expires. Nodes that
/// stay over their facets are projected many at a time (NodeBatch). Which facets face a node is judged by its normal in
/// the present configuration (SlaveNormals). Nothing is allocated after `reset`, and results do not depend on when
/// `reset` is called.
///
/// The class itself owns which facet each node in contact is tracked on; that is all a checkpoint needs.
class NodeTracker
{
public:
  struct Counters
  {
    std::int64_t steps = 0, queries = 0, projections = 0, nodes = 0, refits = 0, normals = 0, renewals = 0;
  };

  NodeTracker() = default;
  /// @param[in] X reference positions of the nodes, gdim each [L]
  NodeTracker(int gdim, const std::vector<double>& X);

  /// Take other facets: everything is searched anew in the next step. Tracked nodes stay on their facets.
  /// @param[in] master candidates, sorted by id, numbered as the displacements; facets that share a node have the same
  /// position of it, to the last bit
  /// @param[in] nodes numbers of the nodes in the arrays of displacements
  /// @param[in] slave all slave facets at the nodes, numbered as the displacements; only master facets that face the
  /// nodes' normals are considered
  /// @param[in] reach search distance [L]
  void reset(surface::Facets master, std::span<const std::int32_t> nodes, surface::Facets slave, double reach);
  std::size_t size() const { return _motion.size(); }
  const surface::Facets& master() const { return _surface.facets(); }
  /// Are all facets of the master intervals, triangles or quadrilaterals of degree 1?
  bool has_linear_facets() const { return _surface.kind() != Kind::general; }
  /// The master's nodes, ascending, without repetition, and their data by their position in this list.
  std::span<const std::int32_t> master_nodes() const { return _surface.nodes(); }
  const MasterNode* masters() const { return _surface.node_data(); }
  MasterNode* masters() { return _surface.node_data(); }
  /// Displacement nodes of a facet, by their position in master_nodes.
  const std::int32_t* corners(std::int32_t facet) const { return _surface.corners(facet); }
  /// Longest distance between corners of a facet in the reference configuration [L].
  double diameter(std::int32_t facet) const { return _surface.diameter(facet); }

  /// To be called in every step, before nodes are located.
  /// @param[in] u displacements [L]
  /// @param[in] du their increments since the last step [L]
  void advance(const double* u, const double* du);
  /// Reference position of node i, and that of the last `advance` [L].
  const double* X(std::size_t i) const { return _motion.X(i); }
  const double* x(std::size_t i) const { return _motion.x(i); }
  /// Is node i skipped in this step? Then it does not come closer to the surface than half a step's motion.
  bool skipped(std::size_t i) const { return _schedule.skipped(i, _motion.path(i), _motion.step()); }
  /// Upper bound on the motion of nodes and surface against each other in the last step [L].
  double step() const { return _motion.step(); }
  /// Closest point of node i. Facets count up to the search distance, or up to twice the motion of the step of the node
  /// against the closest point, if that is more.
  void locate(std::size_t i, const double* u, const double* du, Projection& out)
  {
    ++_counters.nodes;
    if (!_batch.contains(i))
      project_batch(i, u);
    if (const NodeBatch::Result& found = _batch[i]; found.alone && found.at.facet >= 0)
      out = found.at;
    else
      locate_among(i, u, du, out);
  }
  Projection locate(std::size_t i, const double* u, const double* du)
  {
    Projection out;
    locate(i, u, du, out);
    return out;
  }
  /// Closest point in the configuration u - back*du: 1 is that of the step before, 0 the present one.
  Projection locate_before(std::size_t i, const double* u, const double* du, double back = 1.0) const;
  /// Normal of the facet of a closest point, at the same place of the facet, in the configuration u - du.
  /// @param[in] at closest point on a facet
  /// @param[out] normal 3 components
  void normal_before(const Projection& at, const double* u, const double* du, double* normal) const;
  /// Upper bound on the motion of the master's nodes since `advance` [L].
  double moved(const double* u) const { return _surface.moved(u); }
  /// Closest point after nodes have been moved so far, without any effect on later ones.
  Projection evaluate(std::size_t i, const double* u, double moved) const;

  /// The node is in contact: its next closest point is looked for from this one.
  void track(std::size_t i, const Projection& at);
  /// The node is not in contact. It is skipped as long as no negative gap can occur.
  /// @param[in] at what `locate` has found
  void release(std::size_t i, const Projection& at, const double* u);
  /// No node is skipped in this step: the gaps of all nodes are wanted.
  void activate_all() { _schedule.activate_all(); }

  /// Tracked nodes: id of the facet (-1: not tracked) and reference coordinates; for checkpoints.
  std::span<const std::int64_t> tracked() const { return _tracked_ids; }
  std::vector<double> tracked_xi() const;
  void set_tracked(std::span<const std::int64_t> ids, std::span<const double> xi);
  Counters counters() const;
  /// For tests of tests: nodes keep the normals of the first step after `reset`.
  void keep_normals(bool keep) { _normals.keep(keep); }

private:
  using Kind = TrackedSurface::Kind;
  /// Where a node is in contact.
  struct Tracked
  {
    double xi[2] = {0.0, 0.0};
    std::int32_t facet = -1; ///< -1: nowhere
  };

  SearchRange range(std::size_t i, const double* du) const;
  NodeQuery query(std::size_t i, Configuration configuration, const double* slave_normal, const double* du,
                  double slack, const double* shift) const;
  void project_batch(std::size_t first, const double* u);
  void locate_among(std::size_t i, const double* u, const double* du, Projection& out);
  template <surface::FacetShape S>
  void project_batch(const double* u, std::size_t first);
  template <Kind kind>
  bool locate_listed(std::size_t i, const double* u, const double* du, Projection& out);
  Projection locate_anew(std::size_t i, const double* u, const double* du);
  void find_tracked();
  void renew(const double* u);
  void fit_tree(const double* u);
  /// Facets beyond this distance never count [L].
  double widest() const { return std::max(_reach, 2 * _motion.step()); }

  int _gdim = 3;
  double _reach = 0.0;
  TrackedSurface _surface;
  RelativeMotion _motion;
  SlaveNormals _normals;
  SkipSchedule _schedule;
  CandidateLists _lists;
  NodeBatch _batch;
  std::vector<Tracked> _tracked;
  std::vector<std::int64_t> _tracked_ids;
  Counters _counters; ///< those that are counted here
};
} // namespace dolfinx_impact::search
