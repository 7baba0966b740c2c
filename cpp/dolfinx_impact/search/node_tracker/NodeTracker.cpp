// SPDX-License-Identifier: MIT
#include "NodeTracker.h"
#include "../../common/prefetch.h"
#include "../closest_point/linear_facet.h"
#include "SkipBound.h"
#include <algorithm>
#include <array>
#include <cmath>

namespace dolfinx_impact::search
{
namespace
{
using surface::FacetElement;
using surface::FacetShape;

constexpr double tree_slack = 0.25; ///< of the largest facet: motion of the surface after which the tree is fitted
constexpr double uncertain = 0.8;   ///< a normal that can have changed by more says too little
constexpr double few_steps = 4.0;   ///< nodes as near as so many steps' motion are not skipped
constexpr double list_room = 0.25;  ///< of the largest facet: a list that is good for less does not tell when to return
} // namespace

NodeTracker::NodeTracker(int gdim, const std::vector<double>& X)
    : _gdim(gdim), _motion(gdim, X), _normals(gdim, _motion.size()), _schedule(_motion.size()), _lists(_motion.size()),
      _tracked(_motion.size()), _tracked_ids(_motion.size(), -1)
{
}

void NodeTracker::reset(surface::Facets master, std::span<const std::int32_t> nodes, surface::Facets slave,
                        double reach)
{
  _reach = reach;
  _surface.reset(std::move(master));
  _normals.reset(std::move(slave), nodes);
  _motion.reset(nodes, _normals.others(), _surface);
  find_tracked();
}

void NodeTracker::advance(const double* u, const double* du)
{
  ++_counters.steps;
  _batch.clear();
  _motion.advance(u, du, _surface);
  if (_motion.restarted())
  {
    activate_all();
    _lists.clear();
    renew(u);
    return fit_tree(u);
  }
  if (_schedule.deformed(_motion.deformation()) || _motion.renewal_due())
    _schedule.activate_deformed(_motion.deformation(), _motion.renewal_due(), _motion.step());
  if (_motion.renewal_due() && !_normals.kept())
    renew(u);
  if (_motion.since_fit() > tree_slack * _surface.largest_diameter())
    fit_tree(u);
}

/// Deformations count from the present configuration on.
void NodeTracker::renew(const double* u)
{
  ++_counters.renewals;
  _motion.renew(u, _surface);
  _normals.renew();
}

void NodeTracker::fit_tree(const double* u)
{
  ++_counters.refits;
  _surface.fit_tree(u);
  _motion.fit();
}

NodeTracker::Counters NodeTracker::counters() const
{
  Counters out = _counters;
  out.projections = _surface.projections();
  out.normals = _normals.evaluations();
  return out;
}

// --- closest points
// ---------------------------------------------------------------------------------------------------

SearchRange NodeTracker::range(std::size_t i, const double* du) const
{
  return {_motion.node(i), _tracked[i].facet >= 0, _reach, widest(), du};
}

NodeQuery NodeTracker::query(std::size_t i, Configuration configuration, const double* slave_normal, const double* du,
                             double slack, const double* shift) const
{
  NodeQuery out{{}, slave_normal, configuration, range(i, du), _tracked[i].facet, _tracked[i].xi, slack, shift};
  const std::size_t k = std::size_t(_motion.node(i)) * _gdim;
  for (int c = 0; c < _gdim; ++c)
    out.x[c] = _motion.X(i)[c] + configuration.at(k + c);
  return out;
}

/// Closest point of a node of the batch that may lie over several facets.
void NodeTracker::locate_among(std::size_t i, const double* u, const double* du, Projection& out)
{
  const auto listed = [&]
  {
    switch (_surface.kind())
    {
    case Kind::interval:
      return locate_listed<Kind::interval>(i, u, du, out);
    case Kind::triangle:
      return locate_listed<Kind::triangle>(i, u, du, out);
    case Kind::quadrilateral:
      return locate_listed<Kind::quadrilateral>(i, u, du, out);
    case Kind::general:
      break;
    }
    return locate_listed<Kind::general>(i, u, du, out);
  };
  if (_lists.expired(i, _motion.path(i)) || !listed())
    out = locate_anew(i, u, du);
}

/// The nearest of all facets, and a new list of candidates.
Projection NodeTracker::locate_anew(std::size_t i, const double* u, const double* du)
{
  ++_counters.queries;
  double space[3], distance;
  const double* normal = _normals.present(i, u, _motion, space);
  NearFacets near;
  const Projection out =
      nearest_facet(_surface, query(i, {u, nullptr, 1.0, true}, normal, du, _motion.since_fit(), _motion.shift()),
                    CandidateLists::max_facets, near, distance);
  // A node that was tracked is not in contact any more: another search distance holds from now on.
  const double budget = out.facet >= 0           ? 0.5 * (near.complete() - distance)
                        : _tracked[i].facet >= 0 ? 0.0
                                                 : near.complete() - widest();
  _lists.fill(i, near, out.facet, _motion.path(i), budget);
  return out;
}

Projection NodeTracker::locate_before(std::size_t i, const double* u, const double* du, double back) const
{
  double shift[3], normal[3], distance;
  for (int c = 0; c < 3; ++c)
    shift[c] = _motion.shift()[c] - back * _motion.step_shift()[c];
  const Configuration before{u, du, back};
  _normals.evaluate(i, before, normal);
  NearFacets near;
  return nearest_facet(_surface, query(i, before, normal, du, std::abs(_motion.since_fit()) + _motion.step(), shift),
                       CandidateLists::max_facets, near, distance);
}

void NodeTracker::normal_before(const Projection& at, const double* u, const double* du, double* normal) const
{
  _surface.normal_before(at.facet, at.xi, u, du, normal);
}

Projection NodeTracker::evaluate(std::size_t i, const double* u, double moved) const
{
  double normal[3], distance;
  _normals.evaluate(i, {u}, normal);
  NearFacets near;
  return nearest_facet(_surface, query(i, {u}, normal, nullptr, _motion.since_fit() + moved, _motion.shift()),
                       CandidateLists::max_facets, near, distance);
}

/// The nearest facet of the node's list. The bounds on the distances tell which facets need a projection.
/// @returns false if facets that are not listed could be the nearest
template <NodeTracker::Kind kind>
bool NodeTracker::locate_listed(std::size_t i, const double* u, const double* du, Projection& out)
{
  constexpr bool general = kind == Kind::general;
  constexpr FacetShape S = general ? FacetShape::quadrilateral : FacetShape(int(kind));
  const Tracked& tracked = _tracked[i];
  const SearchRange range = this->range(i, du);
  const surface::Facets& facets = _surface.facets();
  const Configuration present{u};
  double nodes[3 * FacetElement::max_nodes], normal[3], best_normal[3];
  const double *x = _motion.x(i), *X[4];
  const auto corners_of = [&](std::int32_t f)
  {
    const std::int32_t* corners = _surface.corners(f);
    for (int j = 0; j < linear::num_nodes<S>; ++j)
      X[j] = _surface.node_data()[corners[j]].x;
  };
  const auto project = [&](std::int32_t f, const double* start, FacetProjection& at)
  {
    if constexpr (!general)
    {
      corners_of(f);
      if (linear::project<S>(X, x, start, at))
      {
        _surface.count_projections(1);
        return;
      }
    }
    _surface.positions(f, present, nodes);
    at = _surface.project(f, nodes, x, start);
  };
  const auto faces = [&](std::int32_t f, const double* xi, double* n)
  {
    if constexpr (general)
      _surface.normal(f, nodes, xi, n);
    else
      linear::normal<S>(X, xi, facets.orientation[f], n);
    return _normals.faces(i, n, u, _motion);
  };
  const double room = 1e-9 * _surface.largest_diameter(), path = _motion.path(i), moved = path + room;
  std::int32_t nearest = -1;
  FacetProjection best, at;
  // Most likely the nearest: then the others need no projection.
  const std::int32_t first = tracked.facet >= 0 ? tracked.facet : _lists.winner(i);
  const NodeBatch::Result& batch = _batch[i];
  const bool projected = batch.at.facet >= 0;
  if (projected)
  {
    best.status = ProjectionStatus::converged;
    best.distance = batch.distance;
    std::copy_n(batch.at.xi, 2, best.xi);
    if (range.contains(_surface, first, best))
      nearest = first;
  }
  else if (first >= 0)
  {
    project(first, tracked.facet >= 0 ? tracked.xi : nullptr, best);
    if (range.contains(_surface, first, best) && faces(first, best.xi, best_normal))
      nearest = first;
  }
  // None of the others can be nearer yet?
  const bool alone = nearest >= 0 && _lists.winner(i) == first && _lists.others(i) - moved > best.distance;
  if (!alone)
  {
    for (CandidateLists::Entry& entry : _lists.entries(i))
    {
      const std::int32_t f = entry.facet;
      if (f == first || entry.bound - moved > (nearest >= 0 ? best.distance : range.radius()))
        continue;
      // Most facets are farther than the best one even by the distance of their box.
      if constexpr (general)
      {
        const double far = nearest >= 0 ? _surface.box_distance(f, x) : 0.0;
        if (nearest >= 0 && far > best.distance + room)
        {
          CandidateLists::set_distance(entry, far, path);
          continue;
        }
      }
      else if (nearest >= 0)
      {
        corners_of(f);
        const double squared = linear::box_distance<S>(X, x), limit = best.distance + room;
        if (squared > limit * limit)
        {
          CandidateLists::set_distance(entry, std::sqrt(squared), path);
          continue;
        }
      }
      project(f, nullptr, at);
      CandidateLists::set_distance(entry, at.distance, path);
      if (range.contains(_surface, f, at) &&
          (nearest < 0 || closer(at, facets.id[f], best, facets.id[nearest], _surface.diameter(nearest))) &&
          faces(f, at.xi, normal))
      {
        best = at;
        nearest = f;
        std::copy_n(normal, 3, best_normal);
      }
    }
    if (!((nearest < 0 ? range.radius() : best.distance) <= _lists.complete(i) - moved))
      return false;
    _lists.set_winner(i, nearest);
  }
  out = {};
  if (nearest < 0)
    return true;
  if (projected && nearest == first)
  {
    out = batch.at;
    return true;
  }
  std::int32_t around[CandidateLists::max_facets];
  const std::span<const CandidateLists::Entry> entries = _lists.entries(i);
  std::transform(entries.begin(), entries.end(), around, [](const CandidateLists::Entry& e) { return e.facet; });
  out = _surface.closest_point(x, nearest, best_normal, best, present, {around, entries.size()});
  return true;
}

// --- nodes that stay over their facets
// --------------------------------------------------------------------------------

/// Project node `first` and the next ones on the facets where they were nearest in the last step.
void NodeTracker::project_batch(std::size_t first, const double* u)
{
  _batch.begin(first, std::min(first + NodeBatch::size, size()));
  switch (_surface.kind())
  {
  case Kind::interval:
    return project_batch<FacetShape::interval>(u, first);
  case Kind::triangle:
    return project_batch<FacetShape::triangle>(u, first);
  case Kind::quadrilateral:
    return project_batch<FacetShape::quadrilateral>(u, first);
  case Kind::general:
    break;
  }
}

template <FacetShape S>
void NodeTracker::project_batch(const double* u, std::size_t first)
{
  // Nodes that are not tracked start from the middle: nothing depends on what a checkpoint does not have.
  constexpr double half = S == FacetShape::triangle ? 1.0 / 3 : 0.5;
  constexpr double middle[2] = {half, S == FacetShape::interval ? 0.0 : half};
  // Their addresses are read from memory themselves: facets are asked for first, then the nodes of all of them.
  for (std::size_t i = first; _batch.contains(i); ++i)
    if (const std::int32_t winner = _lists.winner(i); winner >= 0)
      common::prefetch(_surface.corners(winner));
  for (std::size_t i = first; _batch.contains(i); ++i)
  {
    const std::int32_t winner = _lists.winner(i), tracked = _tracked[i].facet;
    if (winner < 0 || (tracked >= 0 && winner != tracked) || _lists.expired(i, _motion.path(i)) ||
        (tracked < 0 && skipped(i))) // a tracked node is active
      continue;
    _normals.require(i, u, _motion);
    const std::int32_t* corners = _surface.corners(winner);
    for (int j = 0; j < linear::num_nodes<S>; ++j)
      common::prefetch(_surface.node_data() + corners[j]);
    _batch.select<S>(i, winner, corners);
  }
  for (int l = 0; l < _batch.num(); ++l)
  {
    const std::size_t i = _batch.node(l);
    const double change = _normals.rotation(i, _motion);
    _batch.set<S>(l, _surface, _motion.x(i), _normals.stored(i),
                  change <= NormalRotation::most ? change : 2.0, // more than any scalar product
                  _tracked[i].facet >= 0 ? _tracked[i].xi : middle);
  }
  _batch.project(S, _surface);
  _surface.count_projections(_batch.num());
  const double room = 1e-9 * _surface.largest_diameter();
  for (int l = 0; l < _batch.num(); ++l)
  {
    const std::size_t i = _batch.node(l);
    if (!_batch.found(l))
    {
      _lists.prefetch(i);
      continue;
    }
    NodeBatch::Result& found = _batch.take(l);
    found.alone = _lists.others(i) - _motion.path(i) - room > found.distance && found.distance <= _reach;
    if (!found.alone) // its list will be read soon
      _lists.prefetch(i);
  }
}

// --- nodes in contact, and nodes that are skipped
// ---------------------------------------------------------------------

void NodeTracker::find_tracked()
{
  const std::vector<std::int64_t>& ids = _surface.facets().id;
  for (std::size_t i = 0; i < size(); ++i)
  {
    const auto at = std::lower_bound(ids.begin(), ids.end(), _tracked_ids[i]);
    const bool there = _tracked_ids[i] >= 0 && at != ids.end() && *at == _tracked_ids[i];
    _tracked[i].facet = there ? std::int32_t(at - ids.begin()) : -1;
  }
}

void NodeTracker::track(std::size_t i, const Projection& at)
{
  Tracked& tracked = _tracked[i];
  if (tracked.facet != at.facet)
    _tracked_ids[i] = _surface.facets().id[at.facet];
  if (tracked.facet < 0) // a tracked node is active
    _schedule.activate(i);
  tracked = {{at.xi[0], at.xi[1]}, at.facet};
}

void NodeTracker::release(std::size_t i, const Projection& at, const double* u)
{
  _tracked[i].facet = -1;
  _tracked_ids[i] = -1;
  _schedule.activate(i);
  if (!(at.clearance > few_steps * step()))
    return;
  _normals.require(i, u, _motion);
  const double change = _normals.rotation(i, _motion);
  if (!(change <= uncertain))
    return _motion.request_renewal();
  const double path = _motion.path(i), largest = _surface.largest_diameter();
  const double complete = _lists.complete(i) - path;
  SkipBound bound(_surface, u, _motion.x(i), _normals.stored(i), change, widest(), std::min(at.clearance, _reach));
  const auto add_listed = [&](double limit)
  {
    for (const CandidateLists::Entry& entry : _lists.entries(i))
      if (entry.facet != at.facet && entry.bound - path < limit)
        bound.add(entry.facet);
  };
  if (at.facet >= 0)
  {
    if (!bound.set_nearest(at))
      return;
    bound.limit(0.5 * (complete - bound.distance()));
    add_listed(bound.distance() + 2 * bound.path());
  }
  else if (complete >= widest() + list_room * largest)
  {
    bound.limit(complete - widest());
    add_listed(widest() + bound.path());
  }
  else
  {
    bound.limit(largest);
    const double limit = widest() + bound.path() + _motion.since_fit();
    double there[3];
    for (int c = 0; c < _gdim; ++c)
      there[c] = _motion.x(i)[c] - _motion.shift()[c];
    _surface.nearest(there, limit * limit,
                     [&](std::int32_t f)
                     {
                       bound.add(f);
                       return limit * limit;
                     });
  }
  if (!(bound.path() > step()))
    return;
  _schedule.skip_until(i, path + bound.path());
  // The motion between two times is no more than the sum of the deformations up to these times.
  if (bound.rotates())
    _schedule.skip_until_deformed(i, bound.deformation(_normals.rate(i)) - _motion.slave_deformation() -
                                         _motion.master_deformation());
}

std::vector<double> NodeTracker::tracked_xi() const
{
  std::vector<double> out;
  for (const Tracked& tracked : _tracked)
    out.insert(out.end(), tracked.xi, tracked.xi + 2);
  return out;
}

void NodeTracker::set_tracked(std::span<const std::int64_t> ids, std::span<const double> xi)
{
  std::copy(ids.begin(), ids.end(), _tracked_ids.begin());
  for (std::size_t i = 0; i < size(); ++i)
    std::copy_n(xi.data() + 2 * i, 2, _tracked[i].xi);
  find_tracked();
  activate_all();
}
} // namespace dolfinx_impact::search
