// SPDX-License-Identifier: MIT
#include "../common/vectors.h"
#include "NodeTracking.h"
#include "linear_facet.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::search
{
namespace
{
using surface::FacetElement;
using surface::FacetShape;
constexpr double list_budget = 0.5; ///< of the nearest facet's diameter: travel for which a list is good
constexpr double renewal = 0.8;     ///< of normals: uncertain by more, they are all evaluated anew
constexpr int max_values = 3 * FacetElement::max_nodes;

/// A number no greater than x.
float below(double x)
{
  const float near = float(x);
  return near > x ? std::nextafter(near, -std::numeric_limits<float>::infinity()) : near;
}
} // namespace

/// The least sum of travel and distance at which another facet can be the nearest, those that are not listed included.
double NodeTracking::least_other(std::size_t i, std::int32_t winner) const
{
  double least = _node[i].complete;
  for (const Entry& entry : std::span(_lists[i].entries, _node[i].count))
    if (entry.facet != winner)
      least = std::min(least, double(entry.bound));
  return least;
}

/// Does a facet count at this distance?
/// @param[in] motion increments of displacements in the step, or null: none
bool NodeTracking::within(std::size_t i, std::int32_t f, const FacetProjection& at, const double* motion) const
{
  if (at.distance <= _reach || _node[i].held >= 0)
    return true;
  if (!motion || !(at.distance <= radius()))
    return false;
  double phi[FacetElement::max_nodes], squared = 0.0;
  _master.displacement.values(at.xi, phi);
  for (int c = 0; c < _gdim; ++c)
  {
    double d = motion[std::size_t(_node[i].number) * _gdim + c];
    for (int j = 0; j < _master.displacement.num_nodes(); ++j)
      d -= phi[j] * motion[std::size_t(_master.nodes_of(f)[j]) * _gdim + c];
    squared += d * d;
  }
  return at.distance * at.distance <= 4 * squared;
}

/// A node's normal in the present configuration. It is kept if that is nearer to where the motions count from: then it
/// is good for longer.
const double* NodeTracking::present_normal(std::size_t i, const double* u, double* space)
{
  Node& node = _node[i];
  if (_keep_normals && std::isfinite(node.bent))
    return node.normal;
  ++_counters.normals;
  if (_bent < node.bent)
  {
    const double rate = _normals.evaluate(i, u, nullptr, node.normal);
    node.rate = _keep_normals ? 0.0 : rate;
    node.bent = _bent;
    return node.normal;
  }
  if (turned(i) > renewal)
    ask_renewal();
  _normals.evaluate(i, u, nullptr, space);
  return space;
}

/// Does a facet with this normal face node i in the present configuration?
bool NodeTracking::faces(std::size_t i, const double* normal, const double* u)
{
  const double along = dot(normal, _node[i].normal, _gdim), change = turned(i);
  if (change <= Turning::most && std::abs(along + right_angle) > change)
    return along < -right_angle;
  double space[3];
  return dot(normal, present_normal(i, u, space), _gdim) < -right_angle;
}

Projection NodeTracking::query(std::size_t i, Configuration at, const double* slave_normal, const double* motion,
                               double slack, const double* shift, Near& near) const
{
  double x[3], there[3], facet[max_values], normal[3], best_normal[3];
  position(i, at, x);
  for (int c = 0; c < _gdim; ++c)
    there[c] = x[c] - shift[c];
  Projection out;
  FacetProjection best;
  double dropped = std::numeric_limits<double>::infinity();
  // So far the list has to be complete.
  const auto farthest = [&]
  {
    return out.facet < 0 ? radius(i) + 2 * list_budget * _largest : best.distance + 2 * list_budget * _size[out.facet];
  };
  near.num = 0;
  const auto visit = [&](std::int32_t f)
  {
    // Its box tells of most facets that they are no nearer; the list takes that distance, too.
    double distance = out.facet >= 0 && at.stored ? box_distance(f, x) : 0.0;
    if (out.facet < 0 || distance <= best.distance + 1e-9 * _largest)
    {
      positions(f, at, facet);
      const FacetProjection p = project(f, facet, x, f == _node[i].held ? _node[i].xi : nullptr);
      distance = p.distance;
      if (within(i, f, p, motion) &&
          (out.facet < 0 || closer(p, _master.id[f], best, _master.id[out.facet], _size[out.facet])))
      {
        facet_normal(f, facet, p.xi, normal);
        if (dot(normal, slave_normal, _gdim) < -right_angle)
        {
          best = p;
          out.facet = f;
          std::copy_n(normal, 3, best_normal);
        }
      }
    }
    if (near.num < int(near.facets.size()))
      near.facets[near.num++] = {f, distance};
    else
    {
      // Full: the farthest makes room.
      auto far = std::max_element(near.facets.begin(), near.facets.end(),
                                  [](const Found& a, const Found& b) { return a.distance < b.distance; });
      dropped = std::min(dropped, std::max(far->distance, distance));
      if (distance < far->distance)
        *far = {f, distance};
    }
    const double limit = farthest();
    return (limit + slack) * (limit + slack);
  };
  const double first = farthest() + slack;
  _tree.nearest(there, first * first, visit);
  near.complete = farthest();
  keep_nearest(near, out, best.distance, dropped);
  if (out.facet < 0 && _node[i].held >= 0)
    near.budget = 0.0; // it will not be held any more
  if (out.facet < 0)
    return out;
  std::array<std::int32_t, 4 * most> facets;
  std::transform(near.facets.begin(), near.facets.begin() + near.num, facets.begin(),
                 [](const Found& f) { return f.facet; });
  finish(x, best_normal, best, at, {facets.data(), std::size_t(near.num)}, out);
  return out;
}

/// What is not kept cannot become the nearest while slave and master travel `budget`.
/// @param[in] nearest, distance the nearest facet, if there is one
/// @param[in] dropped no facet that is not in `near` is nearer, or `complete`
void NodeTracking::keep_nearest(Near& near, const Projection& nearest, double distance, double dropped) const
{
  const auto nearer = [](const Found& a, const Found& b) { return a.distance < b.distance; };
  const auto begin = near.facets.begin();
  near.complete = std::min(near.complete, dropped);
  const double room = 1e-9 * _largest;
  near.num =
      int(std::remove_if(begin, begin + near.num, [&](const Found& f) { return f.distance > near.complete + room; }) -
          begin);
  if (near.num > most)
  {
    std::nth_element(begin, begin + most, begin + near.num, nearer);
    near.complete = std::min(near.complete, near.facets[most].distance);
  }
  near.budget = nearest.facet < 0 ? near.complete - radius() : 0.5 * (near.complete - distance);
}

Projection NodeTracking::locate(std::size_t i, const double* u, const double* du)
{
  ++_counters.nodes;
  if (i < _ahead || i >= _ahead_end)
    look_ahead(i, u);
  if (warm(i).alone && warm(i).at.facet >= 0)
    return warm(i).at;
  Node& node = _node[i];
  const double travel = _travelled[i].now;
  Projection out;
  const auto listed = [&]
  {
    switch (_kind)
    {
    case Kind::interval:
      return from_list<Kind::interval>(i, u, du, out);
    case Kind::triangle:
      return from_list<Kind::triangle>(i, u, du, out);
    case Kind::quadrilateral:
      return from_list<Kind::quadrilateral>(i, u, du, out);
    case Kind::general:
      break;
    }
    return from_list<Kind::general>(i, u, du, out);
  };
  if (travel < node.expire && listed())
    return out;
  ++_counters.queries;
  Near near;
  double space[3];
  out = query(i, {u, nullptr, true}, present_normal(i, u, space), du, _travel - _fitted, _shift, near);
  // The list: the nearest `most`, in the order of the facets.
  node.count = std::min(near.num, int(most));
  std::sort(near.facets.begin(), near.facets.begin() + node.count,
            [](const Found& a, const Found& b) { return a.facet < b.facet; });
  for (int k = 0; k < node.count; ++k)
    _lists[i].entries[k] = {near.facets[k].facet, below(near.facets[k].distance + travel)};
  node.complete = near.complete + travel;
  node.winner = out.facet;
  node.others = least_other(i, out.facet);
  node.expire = travel + near.budget;
  return out;
}

Projection NodeTracking::locate_before(std::size_t i, const double* u, const double* du, double back) const
{
  Near near;
  double shift[3], normal[3];
  for (int c = 0; c < 3; ++c)
    shift[c] = _shift[c] - back * _step_shift[c];
  _normals.evaluate(i, u, du, normal, back);
  return query(i, {u, du, false, back}, normal, du, std::abs(_travel - _fitted) + _step, shift, near);
}

void NodeTracking::normal_before(const Projection& at, const double* u, const double* du, double* normal) const
{
  double facet[max_values];
  positions(at.facet, {u, du}, facet);
  facet_normal(at.facet, facet, at.xi, normal);
}

double NodeTracking::moved(const double* u) const
{
  double largest = 0.0;
  for (std::size_t k = 0; k < _master_nodes.size(); ++k)
    for (int c = 0; c < _gdim; ++c)
    {
      const double x = _master_X[k * _gdim + c] + u[std::size_t(_master_nodes[k]) * _gdim + c];
      largest = std::max(largest, std::abs(x - _masters[k].x[c]));
    }
  return std::sqrt(double(_gdim)) * largest;
}

Projection NodeTracking::look(std::size_t i, const double* u, double moved) const
{
  Near near;
  double normal[3];
  _normals.evaluate(i, u, nullptr, normal);
  return query(i, {u, nullptr}, normal, nullptr, _travel - _fitted + moved, _shift, near);
}

/// The nearest of the node's list. Distances of its facets when they were last looked at tell which need it again.
/// @returns false if facets that are not listed could be the nearest
template <NodeTracking::Kind kind>
bool NodeTracking::from_list(std::size_t i, const double* u, const double* du, Projection& out)
{
  Node& node = _node[i];
  constexpr bool general = kind == Kind::general;
  constexpr FacetShape S = general ? FacetShape::quadrilateral : FacetShape(int(kind));
  const Configuration at{u, nullptr};
  double facet[max_values], normal[3], best_normal[3];
  const double *x = node.x, *X[4];
  const auto corners_of = [&](std::int32_t f)
  {
    constexpr int N = linear::num_nodes<S>;
    const std::int32_t* nodes = _corners.data() + std::size_t(f) * N;
    for (int j = 0; j < N; ++j)
      X[j] = _masters[nodes[j]].x;
  };
  const auto look = [&](std::int32_t f, const double* start, FacetProjection& p)
  {
    if constexpr (!general)
    {
      corners_of(f);
      if (linear::project<S>(X, x, start, p))
      {
        ++_counters.projections;
        return;
      }
    }
    positions(f, at, facet);
    p = project(f, facet, x, start);
  };
  const auto faces = [&](std::int32_t f, const double* xi, double* n)
  {
    if constexpr (general)
      facet_normal(f, facet, xi, n);
    else
      linear::normal<S>(X, xi, _master.orientation[f], n);
    return this->faces(i, n, u);
  };
  const double travel = _travelled[i].now, moved = travel + 1e-9 * _largest, complete = node.complete - moved;
  Entry* list = _lists[i].entries;
  FacetProjection best, p;
  out = {};
  // Most likely the nearest: saves looking at the others.
  const std::int32_t first = node.held >= 0 ? node.held : node.winner;
  const Warm& ahead = warm(i);
  const bool warm = ahead.at.facet >= 0;
  if (warm)
  {
    best.status = ProjectionStatus::converged;
    best.distance = ahead.distance;
    std::copy_n(ahead.at.xi, 2, best.xi);
    if (within(i, first, best, du))
      out.facet = first;
  }
  else if (first >= 0)
  {
    look(first, node.held >= 0 ? node.xi : nullptr, best);
    if (within(i, first, best, du) && faces(first, best.xi, best_normal))
      out.facet = first;
  }
  // None of the others can be nearer yet?
  const bool alone = out.facet >= 0 && node.winner == first && node.others - moved > best.distance;
  for (int k = 0; k < node.count && !alone; ++k)
  {
    const std::int32_t f = list[k].facet;
    if (f == first || list[k].bound - moved > (out.facet >= 0 ? best.distance : radius(i)))
      continue;
    if constexpr (!general)
      if (out.facet >= 0)
      {
        // Its box tells of most that they are no nearer.
        corners_of(f);
        const double squared = linear::box_distance<S>(X, x), room = best.distance + 1e-9 * _largest;
        if (squared > room * room)
        {
          list[k].bound = below(std::sqrt(squared) + travel);
          continue;
        }
      }
    look(f, nullptr, p);
    list[k].bound = below(p.distance + travel);
    if (within(i, f, p, du) &&
        (out.facet < 0 || closer(p, _master.id[f], best, _master.id[out.facet], _size[out.facet])) &&
        faces(f, p.xi, normal))
    {
      best = p;
      out.facet = f;
      std::copy_n(normal, 3, best_normal);
    }
  }
  if (!alone)
  {
    if (!((out.facet < 0 ? radius(i) : best.distance) <= complete))
      return false;
    node.winner = out.facet;
    node.others = least_other(i, out.facet);
  }
  if (out.facet < 0)
    return true;
  if (warm && out.facet == first)
  {
    out = ahead.at;
    return true;
  }
  std::int32_t facets[most];
  std::transform(list, list + node.count, facets, [](const Entry& e) { return e.facet; });
  finish(x, best_normal, best, at, {facets, std::size_t(node.count)}, out);
  return true;
}
} // namespace dolfinx_impact::search
