// SPDX-License-Identifier: MIT
#pragma once
#include "NodeNormals.h"
#include "project.h"
#include "warm.h"
#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// A node of the master: what is done with it step by step finds all of it in one line of the cache.
struct alignas(64) MasterNode
{
  double x[4] = {};  ///< position [L]; x[3] is its user's
  double du[4] = {}; ///< increment of the last step [L]; du[3] is its user's
};
/// How many numbers of a MasterNode's vectors, or those like them, to reckon with: whole registers.
template <int D>
constexpr int padded = D == 2 ? 2 : 4;

/// Closest points of a surface to nodes, step after step: the same as those of SurfaceSearch::project, for much less.
///
/// `travel` of a node adds up, step by step, how far it has moved and the farthest that any facet has, common
/// translation left out: no distance between the node and the surface changes faster. So a node that was seen at a
/// distance sleeps until travel has used it up. For a node close to the surface, the facets are listed that can become
/// the nearest one within a budget of travel: far from edges this is one. Nothing is allocated after `reset`.
///
/// Which facets face a node is judged by the node's normal in the present configuration. That normal is kept as it was
/// when it was last evaluated, with a bound of how far it can have turned since; it is evaluated again only where the
/// answer could be another one. Results do not depend on when `reset` is called.
class NodeTracking
{
public:
  struct Counters
  {
    std::int64_t steps = 0, queries = 0, projections = 0, nodes = 0, refits = 0, normals = 0, renewals = 0;
  };

  NodeTracking() = default;
  /// @param[in] X reference positions of the nodes, gdim each [L]
  NodeTracking(int gdim, const std::vector<double>& X);

  /// Other facets to look at: everything is searched anew in the next step. Nodes that are held stay on their facets.
  /// @param[in] master candidates, sorted by id, numbered as the displacements; facets that share a node have the same
  /// position of it, to the last bit
  /// @param[in] nodes numbers of the nodes in the arrays of displacements
  /// @param[in] slave all slave facets at the nodes, numbered as the displacements; only master facets that face the
  /// nodes' normals are considered
  /// @param[in] reach search distance [L]
  void reset(surface::Facets master, std::span<const std::int32_t> nodes, surface::Facets slave, double reach);
  std::size_t size() const { return _node.size(); }
  const surface::Facets& master() const { return _master; }
  /// The master's nodes, ascending, without repetition: what is stored for them by their position in this list stays in
  /// the cache while nodes are looked at. Filled by `advance`: their positions and increments.
  std::span<const std::int32_t> master_nodes() const { return _master_nodes; }
  const MasterNode* masters() const { return _masters.data(); }
  MasterNode* masters() { return _masters.data(); }
  /// Displacement nodes of a facet, by their position in master_nodes.
  const std::int32_t* corners(std::int32_t facet) const
  {
    return _corners.data() + std::size_t(facet) * _master.displacement.num_nodes();
  }
  /// Longest distance between corners of a facet, at rest [L].
  double diameter(std::int32_t facet) const { return _size[facet]; }

  /// To be called in every step, before the nodes are looked at.
  /// @param[in] u displacements [L]
  /// @param[in] du their increments since the last step [L]
  void advance(const double* u, const double* du);
  /// No closer to the surface than half a step's motion.
  bool asleep(std::size_t i) const { return _travelled[i].now + 0.5 * _step < _travelled[i].wake; }
  /// Bounds the motion of nodes and surface against each other in the last step [L].
  double step() const { return _step; }
  /// Closest point of node i. Facets count up to the search distance, or up to twice the motion of the step of the node
  /// against the closest point, if that is more.
  Projection locate(std::size_t i, const double* u, const double* du);
  /// Closest point in the configuration u - back*du: 1 is that of the step before, 0 the present one.
  Projection locate_before(std::size_t i, const double* u, const double* du, double back = 1.0) const;
  /// Normal of the facet of a closest point, at the same place of the facet, in the configuration u - du.
  /// @param[in] at closest point on a facet
  /// @param[out] normal 3 components
  void normal_before(const Projection& at, const double* u, const double* du, double* normal) const;
  /// How far nodes have been moved since `advance`, at most [L].
  double moved(const double* u) const;
  /// Closest point after they have been moved so far, without any effect on later ones.
  Projection look(std::size_t i, const double* u, double moved) const;
  /// The node is in contact: its next closest point is looked for from this one.
  void hold(std::size_t i, const Projection& at);
  /// The node is not in contact. It sleeps as long as no negative gap can come.
  /// @param[in] at what `locate` has found
  void release(std::size_t i, const Projection& at, const double* u);
  /// Nobody sleeps in this step: gaps of all nodes are wanted.
  void wake_all();

  /// Held nodes: id of the facet (-1: not held) and reference coordinates; for checkpoints.
  std::span<const std::int64_t> held() const { return _held; }
  std::vector<double> held_xi() const;
  void set_held(std::span<const std::int64_t> ids, std::span<const double> xi);
  const Counters& counters() const { return _counters; }
  /// For tests of tests: nodes keep the normals of the first step after `reset`.
  void keep_normals(bool keep) { _keep_normals = keep; }

private:
  static constexpr int most = 24;            ///< facets per list
  static constexpr double least_bent = 0.01; ///< of the largest facet
  struct Configuration
  {
    const double* u;
    const double* du;    ///< null: the present one; else u - back*du is meant
    bool stored = false; ///< that of `advance`: positions are at hand
    double back = 1.0;
    double at(std::size_t k) const { return u[k] - (du ? back * du[k] : 0.0); }
  };
  struct Found
  {
    std::int32_t facet;
    double distance; ///< no more than that of the facet
  };
  /// What look_ahead found for a node.
  struct Warm
  {
    Projection at;         ///< of its last facet, inside; without facet: nothing
    double distance = 0.0; ///< [L]
    bool alone = false;    ///< no other facet can be nearer yet
  };
  enum class Kind : int
  {
    interval,
    triangle,
    quadrilateral,
    general
  };

  void position(std::size_t i, Configuration at, double* x) const;
  void positions(std::int32_t f, Configuration at, double* x) const;
  FacetProjection project(std::int32_t f, const double* facet, const double* x, const double* start) const;
  void facet_normal(std::int32_t f, const double* facet, const double* xi, double* normal) const;
  void finish(const double* x, const double* normal, const FacetProjection& at, Configuration config,
              std::span<const std::int32_t> near, Projection& out) const;
  bool mean_normal(const FacetProjection& at, std::int32_t facet, Configuration config,
                   std::span<const std::int32_t> near, double* normal) const;
  /// What a query has found: facets near a node, as many as there is room for.
  struct Near
  {
    std::array<Found, 4 * most> facets;
    int num = 0;
    double complete = 0.0; ///< all facets up to this distance are among them [L]
    double budget = 0.0;   ///< travel until when this is enough to know the nearest one
  };
  Projection query(std::size_t i, Configuration at, const double* slave_normal, const double* motion, double slack,
                   const double* shift, Near& near) const;
  void keep_nearest(Near& near, const Projection& nearest, double distance, double dropped) const;
  template <Kind kind>
  bool from_list(std::size_t i, const double* u, const double* du, Projection& out);
  /// Facets count up to this distance at least, and none beyond.
  double radius() const { return std::max(_reach, 2 * _step); }
  /// The same for node i: nodes in contact keep their facets however deep they are pushed.
  double radius(std::size_t i) const { return _node[i].held >= 0 ? std::numeric_limits<double>::infinity() : radius(); }
  bool within(std::size_t i, std::int32_t f, const FacetProjection& at, const double* motion) const;
  // Normals of the slave.
  /// By how much a node's normal can have changed since it was evaluated; more than Turning::most is not known.
  double turned(std::size_t i) const { return _node[i].rate * (_bent + _node[i].bent); }
  const double* present_normal(std::size_t i, const double* u, double* space);
  bool faces(std::size_t i, const double* normal, const double* u);
  // Nodes that sleep.
  struct Rest;
  void consider(std::size_t i, std::int32_t f, const double* u, Rest& rest) const;
  double turning_rate(std::int32_t f, const double* facet, const double* xi) const;
  void wake_turned();
  void renew(const double* u);
  /// Not for ever smaller motions: there may be facets that turn at the least motion.
  void ask_renewal() { _renew = _renew || _bent + _master_bent > least_bent * _largest; }
  template <int D>
  void move(const double* u, const double* du);
  /// Closest points on the facets where some nodes were in the last step, many at a time, for node i and the next ones.
  void look_ahead(std::size_t i, const double* u);
  template <surface::FacetShape S>
  void project_ahead(const double* u);
  void take_block(const std::int32_t* nodes);
  Warm& warm(std::size_t i) { return _warm[i - _ahead]; }
  void fetch(std::size_t i) const;
  double least_other(std::size_t i, std::int32_t winner) const;
  double box_distance(std::int32_t f, const double* x) const;
  void find_held();
  void refit(const double* u);

  int _gdim = 3;
  Kind _kind = Kind::general;
  std::vector<std::int32_t> _nodes;
  surface::Facets _master;
  std::vector<double> _size, _phi; ///< shape functions of displacements at geometry nodes
  double _reach = 0.0, _largest = 0.0;
  BoxTree _tree;
  std::vector<double> _boxes;
  // Travel.
  bool _fresh = true;
  double _travel = 0.0, _fitted = 0.0, _step = 0.0; ///< of the surface, now and when the tree was fitted; bound of both
  double _shift[3] = {}, _step_shift[3] = {};       ///< translation left out, since the tree was fitted; of the step
  double _mean[3] = {};                             ///< mean motion of the last step
  // Turning of normals.
  NodeNormals _normals;
  bool _keep_normals = false;
  double _slope = 2.0; ///< of the master's facets: Turning
  /// The farthest that nodes of the slave facets, and of the master, have moved since the positions in `_slave_from`
  /// and so on; the shifts, common translations, are left out.
  double _bent = 0.0, _master_bent = 0.0;
  double _slave_shift[3] = {}, _master_shift[3] = {}, _slave_mean[3] = {}, _master_mean[3] = {}; ///< now, in a step
  std::vector<double> _slave_from, _master_from, _others_from;
  bool _renew = false;            ///< these positions are too old
  std::vector<double> _turn_wake; ///< sum of both motions at which a node wakes
  double _least_wake = 0.0;       ///< of these
  std::vector<std::int32_t> _master_nodes, _corners;
  std::vector<double> _master_X;
  std::vector<MasterNode> _masters;
  struct Travel
  {
    double now;  ///< a node's own and the surface's since `reset`
    double wake; ///< at which it wakes
  };
  std::vector<Travel> _travelled;
  struct Node
  {
    double expire; ///< travel at which its list ends
    double others; ///< the least sum of travel and distance at which another than `winner` was seen, or could be
    std::int32_t number, count, held, winner;
    double xi[2];      ///< where it is held
    double X[3], x[3]; ///< reference and present position
    double normal[3];  ///< out of the slave, when it was evaluated
    double bent, rate; ///< `_bent` then; how fast it changes at most with the motion since
    double complete;   ///< travel and distance up to which all facets are in its list
  };
  std::vector<Node> _node;
  /// Of a node's list: a facet, its distance when it was last looked at plus travel then, or a little less. No distance
  /// is less than that less travel now.
  struct Entry
  {
    std::int32_t facet = -1;
    float bound = 0.0;
  };
  struct alignas(64) List
  {
    Entry entries[most]; ///< facets, ascending
  };
  std::vector<List> _lists;
  WarmBlock _block;
  std::array<Warm, WarmBlock::size> _warm; ///< of nodes from `_ahead` on, up to `_ahead_end`
  std::size_t _ahead = 0, _ahead_end = 0;
  std::vector<std::int64_t> _held;
  mutable Counters _counters;
};
} // namespace dolfinx_impact::search
