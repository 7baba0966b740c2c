#include "../common/vectors.h"
#include "NodeTracking.h"
#include "linear_facet.h"
#include <algorithm>
#include <cmath>

namespace impact::search
{
namespace
{
using surface::FacetElement;
using surface::FacetShape;
constexpr double list_budget = 0.5; ///< of the nearest facet's diameter: travel for which a list is good
constexpr int max_values = 3 * FacetElement::max_nodes;

/// A number no greater than x.
float below(double x)
{
  const float near = float(x);
  return near > x ? std::nextafter(near, -std::numeric_limits<float>::infinity()) : near;
}
} // namespace

double NodeTracking::least_other(std::size_t i, std::int32_t winner) const
{
  double least = std::numeric_limits<double>::infinity();
  for (const Entry& entry : std::span(_lists[i].entries, _node[i].count))
    if (entry.facet != winner)
      least = std::min(least, double(entry.bound));
  return least;
}

Projection NodeTracking::query(std::size_t i, Configuration at, double slack, const double* shift,
                               std::span<Found> near, int& num, double& budget) const
{
  double x[3], there[3], facet[max_values], normal[3], best_normal[3];
  position(i, at, x);
  for (int c = 0; c < _gdim; ++c)
    there[c] = x[c] - shift[c];
  const double* slave_normal = _node[i].normal;
  const double radius = std::max(_reach, 2 * _step);
  Projection out;
  FacetProjection best;
  double dropped = std::numeric_limits<double>::infinity();
  const auto visit = [&](std::int32_t f)
  {
    // Its box tells of most facets that they are no nearer; the list takes that distance, too.
    double distance = out.facet >= 0 && at.stored ? box_distance(f, x) : 0.0;
    if (out.facet < 0 || distance <= best.distance + 1e-9 * _largest)
    {
      positions(f, at, facet);
      const FacetProjection p = project(f, facet, x, f == _node[i].held ? _node[i].xi : nullptr);
      distance = p.distance;
      if (p.distance <= radius &&
          (out.facet < 0 || closer(p, _master.id[f], best, _master.id[out.facet], _size[out.facet])))
      {
        facet_normal(f, facet, p.xi, normal);
        if (dot(normal, slave_normal, _gdim) < 0.0)
        {
          best = p;
          out.facet = f;
          std::copy_n(normal, 3, best_normal);
        }
      }
    }
    if (num < int(near.size()))
      near[num++] = {f, distance};
    else
    {
      // Full: the farthest makes room.
      auto far = std::max_element(near.begin(), near.end(),
                                  [](const Found& a, const Found& b) { return a.distance < b.distance; });
      dropped = std::min(dropped, std::max(far->distance, distance));
      if (distance < far->distance)
        *far = {f, distance};
    }
    const double limit = out.facet < 0 ? radius : best.distance + 2 * list_budget * _size[out.facet];
    return (limit + slack) * (limit + slack);
  };
  _tree.nearest(there, (radius + slack) * (radius + slack), visit);
  if (out.facet < 0)
  {
    num = 0;
    budget = 0.0;
    return out;
  }
  // What is not in the list cannot become the nearest while slave and master travel `budget`.
  budget = std::min(list_budget * _size[out.facet], 0.5 * (dropped - best.distance));
  const double farthest = best.distance + 2 * budget + 1e-9 * _size[out.facet];
  const auto beyond = [&](const Found& f) { return f.distance > farthest; };
  num = int(std::remove_if(near.begin(), near.begin() + num, beyond) - near.begin());
  if (num > most)
  {
    std::nth_element(near.begin(), near.begin() + most, near.begin() + num,
                     [](const Found& a, const Found& b) { return a.distance < b.distance; });
    budget = std::min(budget, 0.5 * (near[most].distance - best.distance));
  }
  std::int32_t facets[4 * most];
  std::transform(near.begin(), near.begin() + num, facets, [](const Found& f) { return f.facet; });
  finish(x, best_normal, best, at, {facets, std::size_t(num)}, out);
  return out;
}

Projection NodeTracking::locate(std::size_t i, const double* u)
{
  ++_counters.nodes;
  if (i < _ahead || i >= _ahead_end)
    look_ahead(i);
  if (warm(i).alone && warm(i).at.facet >= 0)
    return warm(i).at;
  Node& node = _node[i];
  const double travel = _travelled[i].now;
  if (travel < node.expire)
    switch (_kind)
    {
    case Kind::interval:
      return from_list<Kind::interval>(i, u);
    case Kind::triangle:
      return from_list<Kind::triangle>(i, u);
    case Kind::quadrilateral:
      return from_list<Kind::quadrilateral>(i, u);
    case Kind::general:
      return from_list<Kind::general>(i, u);
    }
  ++_counters.queries;
  Found near[4 * most];
  int num = 0;
  double budget = 0.0;
  const Projection out = query(i, {u, nullptr, true}, _travel - _fitted, _shift, near, num, budget);
  // The list: the nearest `most`, in the order of the facets.
  if (num > most)
  {
    std::nth_element(near, near + most, near + num,
                     [](const Found& a, const Found& b) { return a.distance < b.distance; });
    num = most;
  }
  std::sort(near, near + num, [](const Found& a, const Found& b) { return a.facet < b.facet; });
  for (int k = 0; k < num; ++k)
    _lists[i].entries[k] = {near[k].facet, below(near[k].distance + travel)};
  node.count = num;
  node.winner = out.facet;
  node.others = least_other(i, out.facet);
  node.expire = travel + budget;
  return out;
}

Projection NodeTracking::locate_before(std::size_t i, const double* u, const double* du) const
{
  Found near[4 * most];
  int num = 0;
  double budget = 0.0, shift[3];
  for (int c = 0; c < 3; ++c)
    shift[c] = _shift[c] - _step_shift[c];
  return query(i, {u, du}, std::abs(_travel - _fitted) + _step, shift, near, num, budget);
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
  Found near[4 * most];
  int num = 0;
  double budget = 0.0;
  return query(i, {u, nullptr}, _travel - _fitted + moved, _shift, near, num, budget);
}

/// The nearest of the node's list. Distances of its facets when they were last looked at tell which need it again.
template <NodeTracking::Kind kind>
Projection NodeTracking::from_list(std::size_t i, const double* u)
{
  Node& node = _node[i];
  constexpr bool general = kind == Kind::general;
  constexpr FacetShape S = general ? FacetShape::quadrilateral : FacetShape(int(kind));
  const int D = general ? _gdim : linear::dimension<S>;
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
    return dot(n, node.normal, D) < 0.0;
  };
  const double travel = _travelled[i].now, moved = travel + 1e-9 * _largest;
  Entry* list = _lists[i].entries;
  Projection out;
  FacetProjection best, p;
  // Most likely the nearest: saves looking at the others.
  const std::int32_t first = node.held >= 0 ? node.held : node.winner;
  const Warm& ahead = warm(i);
  const bool warm = ahead.at.facet >= 0;
  if (warm)
  {
    best.status = ProjectionStatus::converged;
    best.distance = ahead.distance;
    out.facet = first;
  }
  else if (first >= 0)
  {
    look(first, node.held >= 0 ? node.xi : nullptr, best);
    if (faces(first, best.xi, best_normal))
      out.facet = first;
  }
  // None of the others can be nearer yet?
  const bool alone = out.facet >= 0 && node.winner == first && node.others - moved > best.distance;
  for (int k = 0; k < node.count && !alone; ++k)
  {
    const std::int32_t f = list[k].facet;
    if (f == first || (out.facet >= 0 && list[k].bound - moved > best.distance))
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
    if ((out.facet < 0 || closer(p, _master.id[f], best, _master.id[out.facet], _size[out.facet])) &&
        faces(f, p.xi, normal))
    {
      best = p;
      out.facet = f;
      std::copy_n(normal, 3, best_normal);
    }
  }
  if (!alone)
  {
    node.winner = out.facet;
    node.others = least_other(i, out.facet);
  }
  if (out.facet < 0 || best.distance > std::max(_reach, 2 * _step))
    return {};
  if (warm && out.facet == first)
    return ahead.at;
  std::int32_t facets[most];
  std::transform(list, list + node.count, facets, [](const Entry& e) { return e.facet; });
  finish(x, best_normal, best, at, {facets, std::size_t(node.count)}, out);
  return out;
}
} // namespace impact::search
