// SPDX-License-Identifier: MIT
#include "../../search/general/beyond_end.h"
#include "../../search/general/closest_on_loop.h"
#include "../../search/general/crossed_edges.h"
#include "../node_to_surface/MomentCorrection.h"
#include "GeneralContact.h"
#include "edge_at.h"
#include "limits.h"
#include <algorithm>
#include <cmath>
#include <limits>

namespace dolfinx_impact::enforcement
{
namespace loop = search::loop;
using namespace general;
using search::SurfaceEdge;

void GeneralContact::update_compliances(double dt)
{
  for (std::size_t k = 0; k < _compliance.size(); ++k)
  {
    const double known = _surface_compliance[k], per_step = dt * dt * _inverse_mass[k];
    _compliance[k] = known > 0.0 ? std::max(known, per_step / most_per_step) : per_step / unknown_per_step;
  }
  _compliance_step = dt;
}

void GeneralContact::update_positions(const NodalState& state)
{
  const std::size_t n = _x.size() / _gdim;
  double mean[3] = {}, largest = 0.0;
  for (std::size_t k = 0; k < n; ++k)
    for (int c = 0; c < _gdim; ++c)
    {
      _x[k * _gdim + c] = _X[k * _gdim + c] + state.u[k * _gdim + c];
      mean[c] += state.du[k * _gdim + c];
    }
  for (double& value : mean)
    value /= std::max(double(n), 1.0);
  for (std::size_t k = 0; k < n; ++k)
  {
    double squared = 0.0;
    for (int c = 0; c < _gdim; ++c)
      squared += (state.du[k * _gdim + c] - mean[c]) * (state.du[k * _gdim + c] - mean[c]);
    largest = std::max(largest, squared);
  }
  _largest_step = std::sqrt(largest);
  _moved += _largest_step;
}

/// Does a facet with this normal face one of the facets at a node?
template <int D>
bool GeneralContact::faces(std::int32_t node, const double* normal) const
{
  double corners[4][D], own[D];
  for (const std::int32_t f : _loops.at_node(node))
  {
    corners_at<D>(f, _x.data(), nullptr, corners);
    loop::side_normal(corners, _loops.num_corners(), _loops.corner_of(f, node), own);
    if (loop::dot<D>(own, normal) < facing)
      return true;
  }
  return false;
}

/// The point of a facet that is closest to another one. A facet that ends on the axis of a body of revolution goes on
/// beyond it: there is no end.
template <int D>
loop::Closest<D> GeneralContact::closest(std::size_t f, const double (&corners)[4][D], const double* x) const
{
  constexpr double on_axis = 1e-8; // of the facets' size, for round-off of coordinates
  loop::Closest<D> out = loop::closest(corners, _loops.num_corners(), x);
  if (_options.axisymmetric && out.corner >= 0 &&
      std::abs(_X[std::size_t(_loops.corners(f)[out.corner]) * D]) <= on_axis * _candidates.size())
    out.corner = -1;
  return out;
}

/// Is a point whose closest point lies on the boundary of a facet behind the facets beyond, too, and no closer to them?
/// Only then is it inside of the body. Beyond the rim of a surface it is not.
template <int D>
bool GeneralContact::behind_neighbours(std::size_t f, const double* x, const search::loop::Closest<D>& at) const
{
  const int num = _loops.num_corners();
  double corners[4][D], normal[D];
  const auto behind = [&](std::int32_t other, int k)
  {
    corners_at<D>(other, _x.data(), nullptr, corners);
    loop::side_normal(corners, num, k, normal);
    return loop::dot<D>(at.away, normal) < 0.0 &&
           !(loop::closest(corners, num, x).squared < (1.0 - equally_near) * at.squared);
  };
  if (at.side >= 0)
  {
    const std::int32_t other = _loops.neighbour(f, at.side);
    if (other < 0)
      return false;
    int k = 0;
    while (k < num - 1 && _loops.neighbour(other, k) != std::int32_t(f))
      ++k;
    return behind(other, k);
  }
  for (const std::int32_t other : _loops.at_node(_loops.corners(f)[at.corner]))
  {
    const int k = _loops.corner_of(other, _loops.corners(f)[at.corner]);
    const bool rim = _loops.neighbour(other, k) < 0 || (D == 3 && _loops.neighbour(other, (k + num - 1) % num) < 0);
    if (rim || (other != std::int32_t(f) && !behind(other, k)))
      return false;
  }
  return true;
}

/// Facets that a node touches, no more than one for each of its springs.
struct GeneralContact::Touches
{
  Touch all[springs_per_node];
  int size = 0;
  double nearest = std::numeric_limits<double>::infinity(); ///< squared distance of all facets near the node [L^2]
  int others = 0; ///< facets so near that they could hold the node beside the one that does

  bool has(int slot) const
  {
    return std::any_of(all, all + size, [slot](const Touch& touch) { return touch.slot == slot; });
  }
  bool has_facet(std::size_t f) const
  {
    return std::any_of(all, all + size, [f](const Touch& touch) { return touch.facet == f; });
  }
};

double GeneralContact::height_of(std::size_t f) const
{
  double height = _height[_loops.corners(f)[0]];
  for (int j = 1; j < _loops.num_corners(); ++j)
    height = std::min(height, _height[_loops.corners(f)[j]]);
  return height;
}

/// Is a facet with this normal one that the spring in a slot may act on, or, without a slot, a new spring?
bool GeneralContact::belongs(std::size_t i, int slot, const double* normal, const Touches& touches) const
{
  const NodeSpring* const own = springs_of(i);
  const auto dot = [this](const double* a, const double* b)
  { return _gdim == 2 ? loop::dot<2>(a, b) : loop::dot<3>(a, b); };
  if (slot < 0)
  {
    for (int s = 0; s < springs_per_node; ++s)
      if (own[s].spring.closed && dot(normal, own[s].spring.normal) >= sliding)
        return false;
    for (int k = 0; k < touches.size; ++k)
      if (dot(normal, touches.all[k].normal) >= sliding)
        return false;
    return true;
  }
  const double mine = dot(normal, own[slot].spring.normal);
  if (mine < sliding)
    return false;
  // Of several springs that whose last normal is nearest.
  for (int s = 0; _num_closed[i] > 1 && s < springs_per_node; ++s)
    if (s != slot && own[s].spring.closed)
      if (const double other = dot(normal, own[s].spring.normal); other > mine || (other == mine && s < slot))
        return false;
  return true;
}

/// Do two facets that a node is behind make a corner that is open to it? At an edge that stands out, of one body or of
/// two that lie flush, one spring holds it.
template <int D>
bool GeneralContact::in_corner(const double* x, const Touch& first, const Touch& second) const
{
  const auto reaches_over = [&](const Touch& a, const Touch& b)
  {
    double corners[4][D], most = 0.0;
    corners_at<D>(a.facet, _x.data(), nullptr, corners);
    for (int k = 0; k < _loops.num_corners(); ++k)
    {
      double along = b.gap; // of the corner before the plane through the foot on b
      for (int c = 0; c < D; ++c)
        along += (corners[k][c] - x[c]) * b.normal[c];
      most = std::max(most, along);
    }
    return most > shallow_part * height_of(a.facet);
  };
  return reaches_over(first, second) && reaches_over(second, first);
}

/// May a spring begin at a node behind a facet? Only if it has come through, or is not deep.
template <int D>
bool GeneralContact::may_begin(std::size_t i, std::size_t f, double gap, const NodalState& state, bool inside)
{
  const double height = height_of(f);
  if (!(-gap > shallow_part * height))
    return true;
  const std::size_t node = _candidates.numbers()[i];
  double before[D], corners[4][D];
  for (int c = 0; c < D; ++c)
    before[c] = _x[node * D + c] - state.du[node * D + c];
  corners_at<D>(f, _x.data(), state.du.data(), corners);
  const loop::Closest<D> last = closest<D>(f, corners, before);
  const double gap_before = loop::dot<D>(last.away, last.normal);
  const bool passed = gap_before > -shallow_part * height && (last.inside() || gap_before > 0.0);
  const bool deep = -gap > deepest_part * height;
  if (passed && deep && inside)
    if (const double facets = -gap / (deepest_part * height); facets > _passage.facets)
      _passage = {_candidates.nodes()[i], facets};
  if (_first && !deep && inside)
    ++_num_implausible;
  return passed && !deep;
}

/// Find the facet that the spring of node i in a slot acts on; without a slot one that the node has come through, or is
/// about to.
template <int D>
bool GeneralContact::look(std::size_t i, int slot, const NodalState& state, Touches& touches)
{
  const std::size_t node = _candidates.numbers()[i];
  const double* x = _x.data() + node * D;
  const bool closed = slot >= 0;
  const PairSpring& spring = springs_of(i)[std::max(slot, 0)].spring;
  Touch touch;
  double size = 0.0, lost = 0.0;
  for (int c = 0; c < D; ++c)
    size += std::abs(_X[node * D + c]) + std::abs(state.u[node * D + c]);
  const double last_gap = spring.spring.gap - spring.spring.offset;
  // Rounding of positions makes gaps of both signs of surfaces that touch.
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * size;
  const double beyond = 2.0 * _largest_step + (closed ? std::max(0.0, -4.0 * last_gap) : 0.0);
  // Facets farther than this neither hold the node nor count as others: what a spring begins at is not deeper, and what
  // a closed one goes on at is as deep as it was, but for the motion of a step.
  const double far = std::max(beyond + (deepest_part + shallow_part) * _largest_height,
                              closed ? std::abs(last_gap) + 2.1 * _largest_step + rounding : 0.0);
  touches.others = 0;
  for (std::int32_t k = _starts[i]; k < _starts[i + 1]; ++k)
  {
    if (const double least = _distances[k] - 2.0 * _moved; least > far)
    {
      touches.nearest = std::min(touches.nearest, least * least);
      continue;
    }
    const std::size_t f = _list[k];
    double corners[4][D];
    corners_at<D>(f, _x.data(), nullptr, corners);
    const loop::Closest<D> at = closest<D>(f, corners, x);
    touches.nearest = std::min(touches.nearest, at.squared);
    const double along = loop::dot<D>(at.away, at.normal), distance = std::sqrt(at.squared);
    _distances[k] = distance + 2.0 * _moved;
    const double reach = beyond + (deepest_part + shallow_part) * _height[_loops.corners(f)[0]];
    if (distance < reach && (!closed || loop::dot<D>(at.normal, spring.normal) < sliding))
      ++touches.others;
    const bool front = !(along < 0.0);
    if (front && (!at.inside() || !(closed || along < _largest_step)))
      continue;
    // Of an open node what is found behind counts before what is in front, of both the nearest. The side of a closed
    // one is known: the nearest counts.
    const double nearer = (1.0 - equally_near) * std::abs(touch.gap);
    if (closed  ? distance >= nearer
        : front ? touch.gap < 0.0 || distance >= nearer
                : touch.gap < 0.0 && distance >= nearer)
      continue;
    if (!belongs(i, slot, at.normal, touches) || (!closed && !faces<D>(node, at.normal)) || touches.has_facet(f))
      continue;
    if (!front && !at.inside() && !behind_neighbours<D>(f, x, at))
      continue;
    const bool touching = distance <= rounding;
    const double gap = front && at.flat ? along : touching ? 0.0 : front ? distance : -distance;
    if (closed)
    {
      // A gap that the motion of the step does not explain is that of another layer.
      if (!(std::abs(gap - last_gap) <= 2.1 * _largest_step + rounding))
        continue;
      if (const double height = height_of(f); -gap > height)
      {
        lost = std::max(lost, -gap / height);
        continue;
      }
    }
    Touch found;
    found.facet = f;
    found.gap = gap;
    found.slot = slot;
    std::copy_n(at.weights, 4, found.weights);
    for (int c = 0; c < D; ++c)
      found.normal[c] = at.flat || touching ? at.normal[c] : at.away[c] / (front ? distance : -distance);
    if (!closed)
    {
      bool corner = true;
      for (int j = 0; j < touches.size && corner; ++j)
        corner = in_corner<D>(x, found, touches.all[j]);
      if (!corner || (gap < 0.0 && !may_begin<D>(i, f, gap, state, at.inside())))
        continue;
    }
    touch = found;
  }
  if (!std::isfinite(touch.gap))
  {
    if (lost > _passage.facets)
      _passage = {_candidates.nodes()[i], lost, true};
    return false;
  }
  touches.all[touches.size++] = touch;
  return true;
}

/// As `look`, of facets that end beside the node, as it is behind another one: in a corner between bodies a node that
/// is pressed into one of them has left the end of the other.
template <int D>
bool GeneralContact::look_beyond(std::size_t i, int slot, const NodalState& state, Touches& touches)
{
  const int num = _loops.num_corners();
  const std::size_t node = _candidates.numbers()[i];
  const double* x = _x.data() + node * D;
  const bool closed = slot >= 0;
  const NodeSpring* const own = springs_of(i);
  auto& ends = std::get<std::vector<FacetEnd<D>>>(_ends);
  ends.clear();
  // Planes of the other springs: for those that are closed those of the last step, whatever their order.
  loop::FootPlane planes[2 * springs_per_node];
  int num_planes = 0;
  for (int s = 0; closed && s < springs_per_node; ++s)
    if (s != slot && own[s].spring.closed)
      planes[num_planes++] = {own[s].spring.normal, own[s].spring.spring.gap - own[s].spring.spring.offset};
  for (int j = 0; j < touches.size; ++j)
    if (!closed || !own[touches.all[j].slot].spring.closed)
      planes[num_planes++] = {touches.all[j].normal, touches.all[j].gap};
  for (std::int32_t k = _starts[i]; k < _starts[i + 1]; ++k)
  {
    const std::size_t f = _list[k];
    double corners[4][D];
    corners_at<D>(f, _x.data(), nullptr, corners);
    const loop::Closest<D> at = closest<D>(f, corners, x);
    if (at.inside() || touches.has_facet(f) || !belongs(i, slot, at.normal, touches))
      continue;
    if (loop::dot<D>(at.away, at.normal) < 0.0 && behind_neighbours<D>(f, x, at))
      continue;
    FacetEnd<D> end;
    end.at = loop::beyond_end<D>(corners, num, x, at);
    const double gap = end.at.gap, height = height_of(f);
    end.slack = shallow_part * height;
    if (-gap > (closed ? 1.0 : deepest_part) * height)
      continue;
    if (closed)
    {
      const PairSpring& spring = own[slot].spring;
      if (!(std::abs(gap - spring.spring.gap + spring.spring.offset) <= 2.1 * _largest_step))
        continue;
    }
    else if (!(gap < _largest_step) || !faces<D>(node, at.normal) ||
             (gap < 0.0 && !may_begin<D>(i, f, gap, state, false)))
      continue;
    end.touch.facet = f;
    end.touch.gap = gap;
    end.touch.slot = slot;
    std::copy_n(end.at.weights, 4, end.touch.weights);
    std::copy_n(end.at.normal, D, end.touch.normal);
    ends.push_back(end);
  }
  const auto ends_at = [](const FacetEnd<D>& end, const loop::FootPlane& plane)
  { return loop::ends_at<D>(end.at, plane, end.slack, sliding); };
  const Touch* best = nullptr;
  for (std::size_t a = 0; a < ends.size(); ++a)
  {
    bool ends_there = false, corner = true;
    for (int j = 0; j < num_planes && !ends_there; ++j)
      ends_there = ends_at(ends[a], planes[j]);
    for (int j = 0; j < touches.size && !closed && corner; ++j)
      corner = in_corner<D>(x, ends[a].touch, touches.all[j]);
    if (!corner)
      continue;
    // Two facets that both end where the node is, where nothing holds it yet.
    for (std::size_t b = 0; b < ends.size() && !closed && touches.size == 0 && !ends_there; ++b)
    {
      const FacetEnd<D>& other = ends[b];
      ends_there = b != a && ends_at(ends[a], {other.touch.normal, other.touch.gap}) &&
                   ends_at(other, {ends[a].touch.normal, ends[a].touch.gap}) &&
                   in_corner<D>(x, ends[a].touch, other.touch);
    }
    if (!ends_there)
      continue;
    const Touch& found = ends[a].touch;
    const bool nearer = !best || std::abs(found.gap) < (1.0 - equally_near) * std::abs(best->gap);
    if (!best || closed || (found.gap < 0.0) == (best->gap < 0.0) ? nearer : found.gap < 0.0)
      best = &found;
  }
  if (best)
    touches.all[touches.size++] = *best;
  return best != nullptr;
}

/// Find the facets that node i has come through, or is about to.
template <int D>
void GeneralContact::find(std::size_t i, const NodalState& state, Touches& touches)
{
  const NodeSpring* const own = springs_of(i);
  const int num_closed = _num_closed[i];
  int fresh = 0, lost = 0, others = 0;
  const auto found = [&](bool any)
  {
    // The first slot whose spring was open before this step.
    for (int s = 0; any && s < springs_per_node; ++s)
      if (!own[s].spring.closed && !touches.has(s))
      {
        touches.all[touches.size - 1].slot = s;
        ++fresh;
        return true;
      }
    return false;
  };
  const auto is_free = [&] { return num_closed + fresh < springs_per_node; };
  if (num_closed == 0)
  {
    found(look<D>(i, -1, state, touches));
    others = _has_corners[i] ? touches.others - 1 : 0; // one facet is no corner
  }
  for (int s = 0; num_closed > 0 && s < springs_per_node; ++s)
    if (own[s].spring.closed)
    {
      lost += !look<D>(i, s, state, touches);
      others = std::max(others, touches.others);
    }
  _next[i] = _moved + 0.5 * std::sqrt(touches.nearest);
  if (others < 1 && num_closed < 2)
    return;
  while (touches.size + lost > 0 && is_free() && found(look<D>(i, -1, state, touches)))
    continue;
  for (int s = 0; lost > 0 && s < springs_per_node; ++s)
    if (own[s].spring.closed && !touches.has(s))
      look_beyond<D>(i, s, state, touches);
  while (is_free() && found(look_beyond<D>(i, -1, state, touches)))
    continue;
}

/// Results of a node are those of its spring with the largest force.
template <int D>
void GeneralContact::update_results(std::size_t i, const Touches& touches)
{
  const NodeSpring* const own = springs_of(i);
  const NodeSpring* const strongest = std::max_element(own, own + springs_per_node, is_weaker);
  _results.status[i] = strongest->status;
  _results.gap[i] = std::numeric_limits<double>::infinity();
  for (int k = 0; k < touches.size && strongest->spring.closed; ++k)
    if (touches.all[k].slot == strongest - own)
      _results.gap[i] = touches.all[k].gap;
  std::copy_n(strongest->slip, D, _results.slip.begin() + i * D);
}

template <int D>
void GeneralContact::add_node(std::size_t i, const NodalState& state)
{
  struct Place
  {
    MomentCorrection correction;
    double r[4 * D], motion[D];
    double closing, stiffness;
    bool presses;
  };
  Touches touches;
  find<D>(i, state, touches);
  const bool was_open = _num_closed[i] == 0;
  if (was_open && touches.size == 0)
    return;
  const int num = _loops.num_corners();
  const std::size_t node = _candidates.numbers()[i];
  Place places[springs_per_node];
  for (int t = 0; t < touches.size; ++t)
  {
    const Touch& touch = touches.all[t];
    Place& at = places[t];
    const std::int32_t* corners = _loops.corners(touch.facet);
    double others = 0.0;
    for (int c = 0; c < D; ++c)
      at.motion[c] = state.du[node * D + c];
    for (int k = 0; k < num; ++k)
    {
      others += std::abs(touch.weights[k]) * _compliance[corners[k]] * std::max(_area[node], _area[corners[k]]);
      for (int c = 0; c < D; ++c)
        at.motion[c] -= touch.weights[k] * state.du[std::size_t(corners[k]) * D + c];
    }
    if (corrects_moments())
    {
      at.correction.template set<D>(
          num, [&](int k, int c) { return _x[std::size_t(corners[k]) * D + c]; }, touch.weights, _x.data() + node * D,
          at.r);
      at.correction.template add_rotation<D>(
          num, at.r, [&](int k, int c) { return state.du[std::size_t(corners[k]) * D + c]; }, at.motion);
    }
    at.closing = loop::dot<D>(touch.normal, at.motion);
    at.stiffness = share_of_way / (_compliance[node] + others / _area[node]);
    PairSpring& spring = springs_of(i)[touch.slot].spring;
    spring.begin_at_rest(touch.gap, at.closing, _first);
    at.presses = mean_overlap(touch.gap + spring.spring.offset, at.closing) > 0.0;
  }
  _num_closed[i] = 0;
  for (int slot = 0; slot < springs_per_node; ++slot)
  {
    NodeSpring& own = springs_of(i)[slot];
    auto& [spring, last, slip, status] = own;
    int t = 0;
    while (t < touches.size && touches.all[t].slot != slot)
      ++t;
    if (t == touches.size && !spring.closed)
      continue;
    double before[D], turn_work = 0.0;
    for (int c = 0; c < D; ++c)
    {
      before[c] = state.du[node * D + c];
      for (int k = 0; k < num && last.corners[0] >= 0; ++k)
      {
        before[c] -= last.weights[k] * state.du[std::size_t(last.corners[k]) * D + c];
        turn_work += last.turn[k * D + c] * state.du[std::size_t(last.corners[k]) * D + c];
      }
    }
    PairForce out;
    if (t == touches.size)
    {
      spring.drop<D>(last.corners[0] >= 0 ? before : nullptr, turn_work, _energy);
      last = {};
    }
    else
    {
      const Touch& touch = touches.all[t];
      const Place& at = places[t];
      const std::int32_t* corners = _loops.corners(touch.facet);
      // Springs whose directions are not perpendicular are no stiffer together than one.
      double along = 1.0;
      for (int j = 0; j < touches.size && at.presses; ++j)
        if (j != t && places[j].presses)
          along += std::abs(loop::dot<D>(touch.normal, touches.all[j].normal));
      const double* const last_motion = last.corners[0] >= 0 ? before : at.motion;
      out = spring.advance<D>(
          {touch.normal, touch.gap + spring.spring.offset, at.closing, at.motion, last_motion, turn_work},
          at.stiffness / along, _options.friction, _energy);
      last = {};
      if (spring.closed)
      {
        last.facet = _loops.id(touch.facet);
        std::copy_n(corners, num, last.corners);
        std::copy_n(touch.weights, num, last.weights);
        _deepest = std::max(_deepest, -touch.gap);
        for (int c = 0; c < D; ++c)
        {
          _forces[node * D + c] += out.force[c];
          for (int k = 0; k < num; ++k)
            _forces[std::size_t(corners[k]) * D + c] -= touch.weights[k] * out.force[c];
        }
        if (out.tangential_squared > 0.0 && corrects_moments()) // normal forces are along the line of both points
          at.correction.template forces<D>(num, at.r, out.force,
                                           [&](int k, int c, double value)
                                           {
                                             last.turn[k * D + c] = value;
                                             _forces[std::size_t(corners[k]) * D + c] += value;
                                           });
      }
    }
    status = spring.closed ? out.status : ContactStatus::open;
    for (int c = 0; c < D; ++c)
      slip[c] = spring.closed ? slip[c] + out.slip[c] : 0.0;
    _num_closed[i] += spring.closed;
  }
  if (!was_open || _num_closed[i] > 0)
    update_results<D>(i, touches);
}

namespace
{
double length_of(const loop::EdgeAtPresent& edge)
{
  return std::hypot(edge.ends[1][0] - edge.ends[0][0], edge.ends[1][1] - edge.ends[0][1],
                    edge.ends[1][2] - edge.ends[0][2]);
}
} // namespace

/// Crossing of two edges, or of what they go on as beyond their ends, no farther than they are behind each other: where
/// an edge bends, two neighbours have their common perpendiculars to another edge on both sides of the bend.
loop::Crossing GeneralContact::cross_beyond(std::int32_t first, std::int32_t second, const double* minus) const
{
  const std::int32_t edges[2] = {first, second};
  const loop::EdgeAtPresent ends[2] = {edge_at(_loops.edges()[first], _loops, _x.data(), minus),
                                       edge_at(_loops.edges()[second], _loops, _x.data(), minus)};
  loop::Crossing out = loop::cross_lines(ends[0], ends[1]);
  for (int k = 0; k < 2 && out.valid; ++k)
  {
    const int end = out.at[k] > 0.0 ? 1 : 0;
    const double beyond = (end == 1 ? out.at[k] - 1.0 : -out.at[k]) * length_of(ends[k]);
    out.valid = beyond < 0.0 || (_continuations[edges[k]][end] >= 0 && beyond <= -out.gap);
  }
  return out;
}

namespace
{
/// Each pair of edges beside two that cross, that one of them or both go on as, at the nearer ends.
template <typename Each>
bool any_beside(const std::vector<std::array<std::int32_t, 2>>& continuations, std::int32_t first, std::int32_t second,
                const loop::Crossing& now, Each&& each)
{
  const std::int32_t next[2] = {continuations[first][now.at[0] < 0.5 ? 0 : 1],
                                continuations[second][now.at[1] < 0.5 ? 0 : 1]};
  return (next[0] >= 0 && each(next[0], second)) || (next[1] >= 0 && each(first, next[1])) ||
         (next[0] >= 0 && next[1] >= 0 && each(next[0], next[1]));
}
} // namespace

/// Did another pair, as which these edges go on, bear the force in the step before? Then this pair waits as long as the
/// other one crosses, and follows it.
GeneralContact::Following GeneralContact::follows(const EdgePair& pair, const loop::Crossing& now,
                                                  const NodalState& state) const
{
  Following out = Following::no;
  any_beside(_continuations, pair.first, pair.second, now,
             [&](std::int32_t first, std::int32_t second)
             {
               const loop::Crossing last = cross_beyond(first, second, state.du.data());
               if (!last.valid || !(last.gap < 0.0) || !(std::abs(now.gap - last.gap) <= 2.1 * _largest_step) ||
                   loop::dot<3>(now.normal, last.normal) < sliding)
                 return false;
               const bool crosses = loop::cross_edges(edge_at(_loops.edges()[first], _loops, _x.data(), nullptr),
                                                      edge_at(_loops.edges()[second], _loops, _x.data(), nullptr))
                                        .valid;
               out = crosses ? Following::waits : Following::follows;
               return crosses;
             });
  return out;
}

/// Do edges cross that two closed ones go on as, whose points lie beyond their ends?
bool GeneralContact::goes_on_elsewhere(const EdgePair& pair, const loop::Crossing& now) const
{
  return any_beside(_continuations, pair.first, pair.second, now,
                    [&](std::int32_t first, std::int32_t second)
                    {
                      return loop::cross_edges(edge_at(_loops.edges()[first], _loops, _x.data(), nullptr),
                                               edge_at(_loops.edges()[second], _loops, _x.data(), nullptr))
                          .valid;
                    });
}

void GeneralContact::add_edges(EdgePair& pair, const NodalState& state)
{
  const SurfaceEdge &first = _loops.edges()[pair.first], &second = _loops.edges()[pair.second];
  const loop::EdgeAtPresent a = edge_at(first, _loops, _x.data(), nullptr);
  const loop::EdgeAtPresent b = edge_at(second, _loops, _x.data(), nullptr);
  PairSpring& spring = pair.spring;
  loop::Crossing at = spring.closed ? cross_beyond(pair.first, pair.second, nullptr) : loop::cross_edges(a, b);
  if (spring.closed && at.valid && !at.inside())
    at.valid = !goes_on_elsewhere(pair, at);
  const std::int32_t nodes[4] = {first.nodes[0], first.nodes[1], second.nodes[0], second.nodes[1]};
  bool follower = false;
  if (at.valid && at.gap < 0.0)
  {
    const double lengths[2] = {length_of(a), length_of(b)};
    // What has come through between the ends stays. What began with an offset, behind already, gives way near them.
    const bool came_through = spring.closed && !(spring.spring.offset > 0.0);
    for (int k = 0; k < 2 && !came_through; ++k)
    {
      const auto& [from, to] = _continuations[k == 0 ? pair.first : pair.second];
      at.valid &= from >= 0 || at.at[k] * lengths[k] > -inside_factor * at.gap;
      at.valid &= to >= 0 || (1.0 - at.at[k]) * lengths[k] > -inside_factor * at.gap;
    }
    double height = _height[nodes[0]], size = 0.0;
    for (const std::int32_t node : nodes)
      height = std::min(height, _height[node]);
    for (int c = 0; c < 3; ++c)
      size += std::abs(a.ends[0][c]) + std::abs(a.ends[1][c]);
    if (at.gap > -4.0 * std::numeric_limits<double>::epsilon() * size)
      at.gap = 0.0;
    // What is deeper than a cell is high is the far side of a body.
    const bool may_follow = !spring.closed && at.valid && -at.gap < height;
    const Following following = may_follow ? follows(pair, at, state) : Following::no;
    follower = following == Following::follows;
    at.valid &= following != Following::waits;
    if (!spring.closed && at.valid && !follower && -at.gap > shallow_part * height)
    {
      const loop::Crossing before = loop::cross_edges(edge_at(first, _loops, _x.data(), state.du.data()),
                                                      edge_at(second, _loops, _x.data(), state.du.data()));
      at.valid = -at.gap < deepest_part * height && before.valid && before.gap > -shallow_part * height;
    }
  }
  if (!spring.closed)
  {
    // An edge that follows another one begins as deep as that was.
    const auto goes_on = [this](std::int32_t e) { return std::max(_continuations[e][0], _continuations[e][1]) >= 0; };
    const double depth = goes_on(pair.first) || goes_on(pair.second) ? _height[nodes[0]] : 0.0;
    pair.next = _moved + 0.5 * std::max(0.0, std::sqrt(loop::squared_distance(a, b)) - depth);
  }
  if (spring.closed && at.valid && loop::dot<3>(at.normal, spring.normal) < sliding)
    at.valid = false;
  const bool known = pair.weights[0] + pair.weights[1] > 0.0;
  double last[3] = {}, turn_work = 0.0;
  for (int k = 0; k < 4 && known; ++k)
    for (int c = 0; c < 3; ++c)
    {
      last[c] += (k < 2 ? 1.0 : -1.0) * pair.weights[k] * state.du[std::size_t(nodes[k]) * 3 + c];
      turn_work += pair.turn[3 * k + c] * state.du[std::size_t(nodes[k]) * 3 + c];
    }
  std::fill_n(pair.weights, 4, 0.0);
  std::fill_n(pair.turn, 12, 0.0);
  if (!at.valid)
  {
    if (spring.closed)
      spring.drop<3>(known ? last : nullptr, turn_work, _energy);
    return;
  }
  if (!spring.closed && !(at.gap < _largest_step))
    return;
  const double weights[4] = {1.0 - at.at[0], at.at[0], 1.0 - at.at[1], at.at[1]};
  double motion[3] = {}, compliance = 0.0;
  for (int k = 0; k < 4; ++k)
  {
    compliance += std::abs(weights[k]) * _compliance[nodes[k]];
    for (int c = 0; c < 3; ++c)
      motion[c] += (k < 2 ? 1.0 : -1.0) * weights[k] * state.du[std::size_t(nodes[k]) * 3 + c];
  }
  double r[12];
  MomentCorrection correction;
  if (_options.friction > 0.0)
  {
    const double phi[4] = {0.0, 0.0, weights[2], weights[3]};
    double point[3];
    for (int c = 0; c < 3; ++c)
      point[c] = weights[0] * a.ends[0][c] + weights[1] * a.ends[1][c];
    correction.set<3>(4, [&](int k, int c) { return _x[std::size_t(nodes[k]) * 3 + c]; }, phi, point, r);
    correction.add_rotation<3>(4, r, [&](int k, int c) { return state.du[std::size_t(nodes[k]) * 3 + c]; }, motion);
  }
  const double closing = loop::dot<3>(at.normal, motion);
  spring.begin_at_rest(at.gap, closing, _first || follower);
  if (follower)
  {
    // It begins with the energy that the pair before it has given up, which counted as dissipated.
    const double before = std::max(0.0, closing - at.gap);
    _energy.normal += 0.5 * share_of_way / compliance * before * before;
  }
  const PairForce out =
      spring.advance<3>({at.normal, at.gap + spring.spring.offset, closing, motion, known ? last : motion, turn_work},
                        share_of_way / compliance, _options.friction, _energy);
  if (!spring.closed)
    return;
  std::copy_n(weights, 4, pair.weights);
  _deepest = std::max(_deepest, -at.gap);
  for (int k = 0; k < 4; ++k)
    for (int c = 0; c < 3; ++c)
      _forces[std::size_t(nodes[k]) * 3 + c] += (k < 2 ? 1.0 : -1.0) * weights[k] * out.force[c];
  if (!(out.tangential_squared > 0.0))
    return;
  correction.forces<3>(4, r, out.force,
                       [&](int k, int c, double value)
                       {
                         pair.turn[3 * k + c] = value;
                         _forces[std::size_t(nodes[k]) * 3 + c] += value;
                       });
}

template <int D>
void GeneralContact::add_all(const NodalState& state, std::span<double> f)
{
  const double near = 0.5 * _largest_step;
  for (std::size_t i = 0; i < num_nodes(); ++i)
    if (_num_closed[i] > 0 || !(_next[i] - _moved > near))
      add_node<D>(i, state);
  if constexpr (D == 3)
    for (EdgePair& pair : _edge_pairs)
      if (pair.spring.closed || !(pair.next - _moved > near))
        add_edges(pair, state);
  for (std::size_t k = 0; k < _forces.size(); ++k)
    f[k] += _forces[k];
}

void GeneralContact::add_forces(const NodalState& state, std::span<double> f)
{
  _energy.stored = 0.0;
  _deepest = 0.0;
  std::ranges::fill(_forces, 0.0);
  if (state.dt != _compliance_step)
    update_compliances(state.dt);
  _candidates.advance(state.dt);
  update_positions(state);
  _gdim == 2 ? add_all<2>(state, f) : add_all<3>(state, f);
  _first = false;
}

} // namespace dolfinx_impact::enforcement
