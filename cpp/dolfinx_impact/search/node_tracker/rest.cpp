// SPDX-License-Identifier: MIT
#include "../../common/vectors.h"
#include "NodeTracking.h"
#include <algorithm>
#include <cmath>

// Nodes that sleep: how long no negative gap can come.
namespace dolfinx_impact::search
{
namespace
{
using surface::FacetElement;
constexpr double never = std::numeric_limits<double>::infinity();
constexpr double least_margin = 0.1; ///< |nu_i . nu_m| below this: facing may change soon
constexpr double doubtful = 0.8;     ///< a normal that can have turned by more tells too little
constexpr double few_steps = 4.0;    ///< less is not worth looking how long a node may sleep
constexpr double list_room = 0.25;   ///< of the largest facet: a list that is good for less is not worth it
} // namespace

/// What a node is allowed.
struct NodeTracking::Rest
{
  bool meets;                      ///< a facet
  double distance;                 ///< of that facet; of those that do not count any more [L]
  double travel;                   ///< that it may sleep for [L]
  double margin = 1.0, rate = 0.0; ///< least |nu_i . nu_m| that must not change its sign; fastest turning of nu_m [1/L]
  bool turns = false;              ///< does facing matter?

  void must_not_turn(double least, double fastest)
  {
    turns = true;
    margin = std::min(margin, least);
    rate = std::max(rate, fastest);
  }
};

/// Takes a facet into account, other than the one that the node meets.
///
/// In front of facets gaps are positive, whichever of them face the node, until one of them is reached. Of those behind
/// which the node is, the ones that face it must not become the nearest; the others must not turn to it.
void NodeTracking::consider(std::size_t i, std::int32_t f, const double* u, Rest& rest) const
{
  double facet[3 * FacetElement::max_nodes], normal[3] = {}, along = 0.0;
  const double* x = _node[i].x;
  positions(f, {u, nullptr}, facet);
  const FacetProjection at = project(f, facet, x, nullptr);
  facet_normal(f, facet, at.xi, normal);
  for (int c = 0; c < _gdim; ++c)
    along += (x[c] - at.x[c]) * normal[c];
  const double nearer = at.distance - rest.distance, free = std::max(0.0, rest.meets ? 0.5 * nearer : nearer);
  if (along > 0.0)
    rest.travel = std::min(rest.travel, at.status == ProjectionStatus::converged ? at.distance : std::max(along, free));
  else if (const double margin = dot(normal, _node[i].normal, _gdim) - turned(i); margin > least_margin)
    rest.must_not_turn(margin, turning_rate(f, facet, at.xi));
  else
    rest.travel = std::min(rest.travel, free);
}

double NodeTracking::turning_rate(std::int32_t f, const double* facet, const double* xi) const
{
  return Turning::factor * Turning::rate(_gdim - 1, surface::evaluate(_master, f, facet, xi).tangents, _slope);
}

void NodeTracking::release(std::size_t i, const Projection& at, const double* u)
{
  Node& node = _node[i];
  node.held = -1;
  _held[i] = -1;
  const double now = _travelled[i].now;
  _travelled[i].wake = -never;
  _turn_wake[i] = never;
  if (!(at.clearance > few_steps * _step)) // not for a few steps
    return;
  double space[3];
  if (!std::isfinite(node.bent)) // evaluated and kept
    present_normal(i, u, space);
  if (!(turned(i) <= doubtful))
    return ask_renewal();
  Rest rest{at.facet >= 0, radius(), std::min(at.clearance, _reach)};
  const double complete = node.complete - now;
  const auto listed = [&](double limit)
  {
    for (const Entry& entry : std::span(_lists[i].entries, node.count))
      if (entry.facet != at.facet && entry.bound - now < limit)
        consider(i, entry.facet, u, rest);
  };
  if (rest.meets)
  {
    double facet[3 * FacetElement::max_nodes], normal[3] = {};
    positions(at.facet, {u, nullptr}, facet);
    facet_normal(at.facet, facet, at.xi, normal);
    const double margin = -dot(normal, node.normal, _gdim) - turned(i);
    if (!(margin > least_margin))
      return;
    rest.must_not_turn(margin, turning_rate(at.facet, facet, at.xi));
    // Just beside the rim the gap is less than the distance, by no more than the twentieth of the facet.
    rest.distance = at.gap + (at.rim == Projection::Rim::near ? 0.05 * _size[at.facet] : 0.0);
    rest.travel = std::min(rest.travel, 0.5 * (complete - rest.distance));
    listed(rest.distance + 2 * rest.travel);
  }
  else if (complete >= radius() + list_room * _largest)
  {
    rest.travel = std::min(rest.travel, complete - radius());
    listed(radius() + rest.travel);
  }
  else
  {
    rest.travel = std::min(rest.travel, _largest);
    const double limit = radius() + rest.travel + _travel - _fitted;
    double there[3];
    for (int c = 0; c < _gdim; ++c)
      there[c] = node.x[c] - _shift[c];
    _tree.nearest(there, limit * limit,
                  [&](std::int32_t f)
                  {
                    consider(i, f, u, rest);
                    return limit * limit;
                  });
  }
  if (!(rest.travel > _step))
    return;
  _travelled[i].wake = now + rest.travel;
  if (rest.turns)
  {
    // Half of the margin is for normals that differ from place to place on a facet. Motion between two times is no more
    // than the sum of the motions up to these times.
    const double allowed = std::min(0.5 * rest.margin, Turning::most) / std::max(rest.rate, node.rate);
    _turn_wake[i] = allowed - _bent - _master_bent;
    _least_wake = std::min(_least_wake, _turn_wake[i]);
  }
}

/// Wakes nodes for which normals can have turned too far. Before `renew`: what the others may turn counts from there.
void NodeTracking::wake_turned()
{
  _least_wake = never;
  const double bent = _bent + _master_bent;
  for (std::size_t i = 0; i < _turn_wake.size(); ++i)
    if (_turn_wake[i] <= bent + (_renew ? _step : 0.0))
    {
      _turn_wake[i] = never;
      _travelled[i].wake = -never;
    }
    else
    {
      _turn_wake[i] -= _renew ? bent : 0.0;
      _least_wake = std::min(_least_wake, _turn_wake[i]);
    }
}

void NodeTracking::wake_all()
{
  for (Travel& travel : _travelled)
    travel.wake = -never;
  std::fill(_turn_wake.begin(), _turn_wake.end(), never);
  _least_wake = never;
}
} // namespace dolfinx_impact::search
