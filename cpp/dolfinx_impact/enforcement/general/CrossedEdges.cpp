// SPDX-License-Identifier: MIT
#include "CrossedEdges.h"
#include "../../common/agree.h"
#include "../../common/gather.h"
#include "../../search/BoxTree.h"
#include "../../search/general/crossed_edges.h"
#include "../friction.h"
#include "edge_at.h"
#include "limits.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <unordered_map>

namespace dolfinx_impact::enforcement
{
using general::edge_at;
using general::inside_factor;
using general::sharp_of_lists;

namespace
{
namespace crossing = search::loop;

/// Pairs of edges in contact that a facet can own in a state, and the numbers of each.
constexpr int pairs_per_facet = 6, values_per_pair = 7;
/// Where one edge goes on from another, both bear a part within this part of them from their common end, so that forces
/// vary smoothly when the place goes from one to the other; a bent line has no hole there.
constexpr double common_part = 0.1;
/// Cosine of the angle between two edges of which one goes on where the other ends.
constexpr double straight_on = 0.8;
/// A pair has one spring, where points of both sides have half of the penalty each.
constexpr double sides = 2.0;

double distance(const double* a, const double* b)
{
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Area of the surface for one spring at an edge: that of a node there [L^2].
double area_at(const search::SurfaceEdge& edge, const search::FacetLoops& loops, std::span<const double> x)
{
  double sum = 0.0;
  const int num = loops.num_corners();
  for (const std::int32_t f : edge.facets)
    for (int k = 1; k + 1 < num; ++k)
    {
      double a[3], b[3], n[3];
      for (int c = 0; c < 3; ++c)
      {
        const auto at = [&](int j) { return x[std::size_t(loops.corners(f)[j]) * 3 + c]; };
        a[c] = at(k) - at(0);
        b[c] = at(k + 1) - at(0);
      }
      crossing::cross(a, b, n);
      sum += 0.5 * std::sqrt(crossing::dot<3>(n, n));
    }
  return num == 4 ? 0.5 * sum : sum; // two triangles are one quadrilateral
}

/// Edges that are longer at both ends by a part of them, so that points at the ends lie inside.
crossing::EdgeAtPresent longer(crossing::EdgeAtPresent edge, double part)
{
  for (int c = 0; c < 3; ++c)
  {
    const double more = part * (edge.ends[1][c] - edge.ends[0][c]);
    edge.ends[0][c] -= more;
    edge.ends[1][c] += more;
  }
  return edge;
}

/// Crossing of two edges that bear forces beyond their ends.
crossing::Crossing cross_with_ends(const crossing::EdgeAtPresent& a, const crossing::EdgeAtPresent& b)
{
  crossing::Crossing out = crossing::cross_edges(longer(a, common_part), longer(b, common_part));
  for (double& at : out.at)
    at = at * (1.0 + 2.0 * common_part) - common_part;
  return out;
}

/// Part of the force that an edge bears at a place, with its derivative: those of two edges with a common end add up to
/// one around it.
std::pair<double, double> borne(double at, const bool* goes_on)
{
  double value = 1.0, derivative = 0.0;
  for (int end = 0; end < 2; ++end)
  {
    const double from = end == 0 ? at : 1.0 - at;
    if (!goes_on[end] || !(from < common_part))
      continue;
    const double s = std::max(0.0, (from + common_part) / (2.0 * common_part));
    value = s * s * (3.0 - 2.0 * s);
    derivative = (end == 0 ? 1.0 : -1.0) * 6.0 * s * (1.0 - s) / (2.0 * common_part);
  }
  return {value, derivative};
}
} // namespace

CrossedEdges::CrossedEdges(const surface::Facets& facets)
    : _facets(facets), _keys(facets.size() * pairs_per_facet * 2, -1),
      _values(facets.size() * pairs_per_facet * values_per_pair, 0.0)
{
}

/// Find the ends of edges from which another sharp edge goes on.
void CrossedEdges::find_ends(std::span<const std::int32_t> sharp)
{
  const auto& edges = _loops.edges();
  _goes_on.assign(edges.size(), {false, false});
  std::unordered_map<std::int32_t, std::vector<std::pair<std::int32_t, int>>> at_node;
  for (const std::int32_t e : sharp)
    for (int k = 0; k < 2; ++k)
      at_node[edges[e].nodes[k]].emplace_back(e, k);
  const auto direction = [&](std::int32_t e, int from, double* out)
  {
    const double *a = _X.data() + std::size_t(edges[e].nodes[from]) * 3,
                 *b = _X.data() + std::size_t(edges[e].nodes[1 - from]) * 3;
    const double length = distance(a, b);
    for (int c = 0; c < 3; ++c)
      out[c] = (b[c] - a[c]) / length;
  };
  for (const auto& [node, meeting] : at_node)
    for (const auto& [e, k] : meeting)
    {
      double own[3], next[3];
      direction(e, k, own);
      for (const auto& [other, end] : meeting)
      {
        direction(other, end, next);
        _goes_on[e][k] |= other != e && crossing::dot<3>(own, next) < -straight_on;
      }
    }
}

void CrossedEdges::list(const search::PairSearch& pair, const search::GeneralSearch& general)
{
  const surface::Facets& all = pair.master();
  const auto map = _exchange->map();
  const std::size_t num_nodes = map->size_local() + map->num_ghosts();
  _loops = search::FacetLoops(all, num_nodes);
  _X.assign(num_nodes * 3, 0.0);
  for (std::size_t f = 0; f < all.size(); ++f)
    for (int k = 0; k < all.displacement.num_nodes(); ++k)
      std::copy_n(all.X_of(f) + 3 * k, 3, _X.data() + std::size_t(all.nodes_of(f)[k]) * 3);
  std::vector<double> x = _X;
  for (std::size_t f = 0; f < all.size(); ++f)
    for (int k = 0; k < all.displacement.num_nodes(); ++k)
      std::copy_n(all.x_of(f) + 3 * k, 3, x.data() + std::size_t(all.nodes_of(f)[k]) * 3);
  std::unordered_map<std::int64_t, std::int32_t> own;
  for (std::size_t f = 0; f < _facets.size(); ++f)
    own[_facets.id[f]] = std::int32_t(f);
  std::vector<std::int32_t> sharp, found;
  std::vector<double> boxes;
  for (std::size_t e = 0; e < _loops.edges().size(); ++e)
  {
    const crossing::EdgeAtPresent at = edge_at(_loops.edges()[e], _loops, x.data(), nullptr);
    if (!(crossing::dot<3>(at.normals[0], at.normals[1]) < sharp_of_lists))
      continue;
    sharp.push_back(std::int32_t(e));
    for (const bool high : {false, true})
      for (int c = 0; c < 3; ++c)
        boxes.push_back(high ? std::max(at.ends[0][c], at.ends[1][c]) : std::min(at.ends[0][c], at.ends[1][c]));
  }
  find_ends(sharp);
  _candidates.clear();
  const search::BoxTree tree(3, boxes);
  for (std::size_t k = 0; k < sharp.size(); ++k)
  {
    const search::SurfaceEdge& first = _loops.edges()[sharp[k]];
    const auto owner = own.find(all.id[first.facets[0]]);
    if (owner == own.end())
      continue; // the rank of this facet has the pairs of the edge
    double box[6];
    for (int c = 0; c < 3; ++c)
    {
      box[c] = boxes[6 * k + c] - pair.reach();
      box[3 + c] = boxes[6 * k + 3 + c] + pair.reach();
    }
    tree.overlapping(box, found);
    for (const std::int32_t other : found)
    {
      const search::SurfaceEdge& second = _loops.edges()[sharp[other]];
      if (!(first.id < second.id) || first.nodes[0] == second.nodes[0] || first.nodes[0] == second.nodes[1] ||
          first.nodes[1] == second.nodes[0] || first.nodes[1] == second.nodes[1])
        continue;
      bool left_out = false;
      for (const std::int32_t a : first.facets)
        for (const std::int32_t b : second.facets)
          left_out |= general.leaves_out(a, b);
      if (left_out)
        continue;
      CrossedPair out{};
      out.bodies[0] = general.master_bodies()[first.facets[0]];
      out.bodies[1] = general.master_bodies()[second.facets[0]];
      if (out.bodies[0] == out.bodies[1])
      {
        // Two edges of one body that are across it from the beginning.
        const crossing::Crossing at = crossing::cross_edges(edge_at(first, _loops, _X.data(), nullptr),
                                                            edge_at(second, _loops, _X.data(), nullptr));
        if (at.valid && at.gap < 0.0)
          continue;
      }
      out.first = sharp[k];
      out.second = sharp[other];
      out.owner = owner->second;
      for (int k = 0; k < 2; ++k)
      {
        out.goes_on[0][k] = _goes_on[out.first][k];
        out.goes_on[1][k] = _goes_on[out.second][k];
      }
      out.area = std::min(area_at(first, _loops, _X), area_at(second, _loops, _X));
      out.height = std::numeric_limits<double>::infinity();
      for (const search::SurfaceEdge* edge : {&first, &second})
        for (const std::int32_t f : edge->facets)
          out.height = std::min(out.height, general.height(f));
      for (int i = 0; i < 2; ++i)
      {
        out.nodes[i] = first.nodes[i];
        out.nodes[2 + i] = second.nodes[i];
      }
      _candidates.push_back(out);
    }
  }
}

void CrossedEdges::read_history(CrossedPair& pair) const
{
  pair.depth = 0.0;
  std::fill_n(pair.last, 3, 0.0);
  std::fill_n(pair.last_slip, 3, 0.0);
  const std::int64_t ids[2] = {_loops.edges()[pair.first].id, _loops.edges()[pair.second].id};
  for (int k = 0; k < pairs_per_facet; ++k)
  {
    const std::size_t at = std::size_t(pair.owner) * pairs_per_facet + k;
    if (_keys[2 * at] != ids[0] || _keys[2 * at + 1] != ids[1])
      continue;
    const double* values = _values.data() + at * values_per_pair;
    pair.depth = values[0];
    std::copy_n(values + 1, 3, pair.last);
    std::copy_n(values + 4, 3, pair.last_slip);
    return;
  }
}

/// Where two edges cross now; whether they may have a spring.
bool CrossedEdges::cross(CrossedPair& pair, std::span<const double> moved) const
{
  const search::SurfaceEdge &first = _loops.edges()[pair.first], &second = _loops.edges()[pair.second];
  const crossing::EdgeAtPresent a = edge_at(first, _loops, _x.data(), nullptr),
                                b = edge_at(second, _loops, _x.data(), nullptr);
  const crossing::Crossing at = cross_with_ends(a, b);
  if (!at.valid)
    return false;
  const double lengths[2] = {distance(a.ends[0], a.ends[1]), distance(b.ends[0], b.ends[1])};
  double parts[2], slopes[2];
  for (int k = 0; k < 2; ++k)
  {
    for (int end = 0; end < 2; ++end)
    {
      const double from = end == 0 ? at.at[k] : 1.0 - at.at[k];
      if (!pair.goes_on[k][end] && !(from * lengths[k] > -inside_factor * at.gap))
        return false;
    }
    std::tie(parts[k], slopes[k]) = borne(at.at[k], pair.goes_on[k]);
  }
  pair.bears = parts[0] * parts[1];
  pair.d_bears[0] = slopes[0] * parts[1];
  pair.d_bears[1] = parts[0] * slopes[1];
  if (!(pair.bears > 0.0))
    return false;
  read_history(pair);
  double before = -pair.depth;
  if (!(pair.depth > 0.0))
  {
    const crossing::Crossing then = cross_with_ends(edge_at(first, _loops, _start.data(), nullptr),
                                                    edge_at(second, _loops, _start.data(), nullptr));
    before = then.valid ? then.gap : 0.0;
    if (-at.gap > search::GeneralSearch::shallow_part * pair.height &&
        !(then.valid && then.gap > -search::GeneralSearch::shallow_part * pair.height))
      return false;
  }
  pair.gap = at.gap;
  std::copy_n(at.normal, 3, pair.normal);
  const double weights[4] = {1.0 - at.at[0], at.at[0], at.at[1] - 1.0, -at.at[1]};
  std::copy_n(weights, 4, pair.weights);
  for (int i = 0; i < 4; ++i)
  {
    std::copy_n(i < 2 ? a.ends[i] : b.ends[i - 2], 3, pair.ends[i]);
    std::copy_n(moved.data() + std::size_t(pair.nodes[i]) * 3, 3, pair.moved[i]);
  }
  std::fill_n(pair.increment, 3, 0.0);
  for (int i = 0; i < 4; ++i)
    for (int c = 0; c < 3; ++c)
      pair.increment[c] += weights[i] * pair.moved[i][c];
  pair.gap_before = before;
  return true;
}

void CrossedEdges::update(const search::PairSearch& pair, const search::GeneralSearch& general,
                          std::span<const double> u, std::span<const double> start)
{
  if (_exchange != pair.exchange())
  {
    _exchange = pair.exchange();
    list(pair, general);
  }
  std::vector<double> now(_exchange->size()), then(_exchange->size());
  _exchange->forward(u, now);
  _exchange->forward(start, then);
  _x.resize(_X.size());
  _start.resize(_X.size());
  for (std::size_t i = 0; i < _X.size(); ++i)
  {
    _x[i] = _X[i] + now[i];
    _start[i] = _X[i] + then[i];
    now[i] -= then[i];
  }
  _crossed.clear();
  for (CrossedPair& candidate : _candidates)
    if (cross(candidate, now))
      _crossed.push_back(candidate);
}

void CrossedEdges::evaluate(const PenaltyParameters& parameters, std::span<const double> share_of_body)
{
  _friction = parameters.friction;
  const auto open = [&](CrossedPair& pair)
  {
    const double share =
        share_of_body.empty() ? 1.0 : std::min(share_of_body[pair.bodies[0]], share_of_body[pair.bodies[1]]);
    pair.stiffness = parameters.normal * sides * share * pair.area * pair.bears;
    pair.tangential_stiffness = parameters.tangential * sides * share * pair.area;
    const double trial = -pair.stiffness * pair.gap;
    if (!(trial > -parameters.touch * sides * share * pair.area * pair.bears))
      return true;
    pair.force = std::max(trial, 0.0);
    pair.status = ContactStatus::slip;
    std::fill_n(pair.tangential, 3, 0.0);
    std::fill_n(pair.slip, 3, 0.0);
    pair.part = 1.0;
    pair.slope = 0.0;
    if (!(parameters.friction > 0.0))
      return false;
    // What comes after closing counts, if force and gap go straight from the beginning of the increment to its end.
    if (const double before = -pair.stiffness * pair.gap_before; before < 0.0)
    {
      const double whole = pair.force - before;
      pair.part = pair.force / whole;
      pair.slope = -before / (whole * whole);
    }
    double increment[3];
    for (int c = 0; c < 3; ++c)
      increment[c] = pair.part * pair.increment[c];
    const FrictionResult result = enforcement::evaluate(
        Friction{3, pair.force, parameters.friction, pair.tangential_stiffness, pair.normal, pair.last, increment});
    pair.status = result.slips ? ContactStatus::slip : ContactStatus::stick;
    std::copy_n(result.traction, 3, pair.tangential);
    for (int c = 0; c < 3; ++c)
      pair.slip[c] = pair.last_slip[c] + result.slip[c];
    return false;
  };
  _closed = _crossed;
  std::erase_if(_closed, open);
}

int CrossedEdges::num_changed()
{
  std::vector<std::pair<std::array<std::int64_t, 2>, ContactStatus>> now;
  for (const CrossedPair& pair : _closed)
    now.push_back({{_loops.edges()[pair.first].id, _loops.edges()[pair.second].id}, pair.status});
  std::ranges::sort(now);
  std::vector<std::pair<std::array<std::int64_t, 2>, ContactStatus>> differ;
  std::ranges::set_symmetric_difference(now, _seen, std::back_inserter(differ));
  _seen = std::move(now);
  return int(differ.size());
}

void CrossedEdges::add_force(std::span<double> force) const
{
  for (const CrossedPair& pair : _closed)
    for (int i = 0; i < 4; ++i)
      for (int c = 0; c < 3; ++c)
        force[std::size_t(pair.nodes[i]) * 3 + c] +=
            pair.weights[i] * (pair.force * pair.normal[c] + pair.tangential[c]);
}

void CrossedEdges::add_closing_force(std::span<double> force) const
{
  for (const CrossedPair& pair : _closed)
    for (int i = 0; i < 4; ++i)
      for (int c = 0; c < 3; ++c)
        force[std::size_t(pair.nodes[i]) * 3 + c] +=
            pair.weights[i] * std::min(-pair.stiffness * pair.gap, 0.0) * pair.normal[c];
}

void CrossedEdges::add_couplings(std::int64_t offset, operators::NodalMatrix::Couplings& couplings) const
{
  const std::int64_t num = std::int64_t(_loops.edges().size());
  for (const CrossedPair& pair : _closed)
    couplings.add(offset + pair.first * num + pair.second, {pair.nodes, 4}, {pair.nodes, 4});
}

void CrossedEdges::add_tangent(bool convex, operators::NodalMatrix& matrix) const
{
  for (const CrossedPair& pair : _closed)
  {
    const double *n = pair.normal, *w = pair.weights;
    double z[3], d_force[12], d_normal[36] = {}, d_z[36] = {}, d_at[2][12] = {}, block[144] = {};
    for (int c = 0; c < 3; ++c)
      z[c] = pair.force * n[c] + pair.tangential[c];
    for (int i = 0; i < 4; ++i)
      for (int c = 0; c < 3; ++c)
        d_force[3 * i + c] = -pair.stiffness * n[c] * w[i];
    if (convex)
    {
      for (int a = 0; a < 12; ++a)
        for (int b = 0; b < 12; ++b)
          block[a * 12 + b] = -w[a / 3] * n[a % 3] * d_force[b];
      matrix.add({pair.nodes, 4}, {pair.nodes, 4}, {block, 144});
      continue;
    }
    // Edges e_k = x_1 - x_0 and y_1 - y_0 and D = gap n between the points at s and t: D . e_k = 0, and n is along
    // e_1 x e_2. Both are differentiated.
    double e[2][3], D[3], m[3];
    for (int c = 0; c < 3; ++c)
    {
      e[0][c] = pair.ends[1][c] - pair.ends[0][c];
      e[1][c] = pair.ends[3][c] - pair.ends[2][c];
      D[c] = pair.gap * n[c];
    }
    crossing::cross(e[0], e[1], m);
    const double size = std::sqrt(crossing::dot<3>(m, m)), sign = crossing::dot<3>(m, n) < 0.0 ? -1.0 : 1.0;
    const double aa = crossing::dot<3>(e[0], e[0]), bb = crossing::dot<3>(e[1], e[1]),
                 ab = crossing::dot<3>(e[0], e[1]);
    const double det = ab * ab - aa * bb; // of (aa, -ab; ab, -bb)
    for (int i = 0; i < 4; ++i)
      for (int c = 0; c < 3; ++c)
      {
        const int j = 3 * i + c;
        double r[2], d_e[3] = {};
        const double turn = i % 2 == 0 ? -1.0 : 1.0; // of the edge that the node is an end of
        for (int k = 0; k < 2; ++k)
          r[k] = -w[i] * e[k][c] - (i / 2 == k ? turn * D[c] : 0.0);
        d_at[0][j] = (-bb * r[0] + ab * r[1]) / det;
        d_at[1][j] = (aa * r[1] - ab * r[0]) / det;
        d_e[c] = turn;
        double d_m[3];
        i < 2 ? crossing::cross(d_e, e[1], d_m) : crossing::cross(e[0], d_e, d_m);
        const double along = crossing::dot<3>(n, d_m);
        for (int a = 0; a < 3; ++a)
          d_normal[a * 12 + j] = sign * (d_m[a] - along * n[a]) / size;
      }
    for (int j = 0; j < 12; ++j)
    {
      d_force[j] += pair.force / pair.bears * (pair.d_bears[0] * d_at[0][j] + pair.d_bears[1] * d_at[1][j]);
      for (int a = 0; a < 3; ++a)
        d_z[a * 12 + j] = d_force[j] * n[a] + pair.force * d_normal[a * 12 + j];
    }
    // The weights are (1 - s, s, t - 1, -t).
    const auto d_weight = [&](int i, int j)
    {
      return i == 0 ? -d_at[0][j] : i == 1 ? d_at[0][j] : i == 2 ? d_at[1][j] : -d_at[1][j];
    };
    if (_friction > 0.0)
    {
      double increment[3], d_increment[36], d_t[36];
      for (int c = 0; c < 3; ++c)
        increment[c] = pair.part * pair.increment[c];
      for (int j = 0; j < 12; ++j)
        for (int c = 0; c < 3; ++c)
        {
          double change = j % 3 == c ? w[j / 3] : 0.0;
          for (int i = 0; i < 4; ++i)
            change += d_weight(i, j) * pair.moved[i][c];
          d_increment[c * 12 + j] = pair.part * change + pair.slope * d_force[j] * pair.increment[c];
        }
      const Friction point{3, pair.force, _friction, pair.tangential_stiffness, n, pair.last, increment};
      linearise(point, enforcement::evaluate(point), 12, d_force, d_normal, d_increment, d_t);
      for (int i = 0; i < 36; ++i)
        d_z[i] += d_t[i];
    }
    for (int i = 0; i < 4; ++i)
      for (int c = 0; c < 3; ++c)
        for (int j = 0; j < 12; ++j)
          block[(3 * i + c) * 12 + j] = -d_weight(i, j) * z[c] - w[i] * d_z[c * 12 + j];
    matrix.add({pair.nodes, 4}, {pair.nodes, 4}, {block, 144});
  }
}

double CrossedEdges::energy() const
{
  double sum = 0.0;
  for (const CrossedPair& pair : _closed)
  {
    sum += 0.5 * pair.force * pair.force / pair.stiffness;
    if (_friction > 0.0)
      sum += 0.5 * crossing::dot<3>(pair.tangential, pair.tangential) / pair.tangential_stiffness;
  }
  return sum;
}

double CrossedEdges::deepest() const
{
  double out = 0.0;
  for (const CrossedPair& pair : _closed)
    out = std::max(out, -pair.gap);
  return out;
}

double CrossedEdges::deepest_part() const
{
  double out = 0.0;
  for (const CrossedPair& pair : _closed)
    out = std::max(out, -pair.gap / pair.height);
  return out;
}

double CrossedEdges::accept()
{
  std::ranges::fill(_keys, -1);
  std::ranges::fill(_values, 0.0);
  std::vector<int> count(_facets.size(), 0);
  double work = 0.0;
  int most = 0;
  for (const CrossedPair& pair : _closed)
  {
    for (int c = 0; c < 3; ++c)
      work -= pair.tangential[c] * (pair.slip[c] - pair.last_slip[c]);
    const int k = count[pair.owner]++;
    most = std::max(most, k + 1);
    if (k >= pairs_per_facet)
      continue;
    const std::size_t at = std::size_t(pair.owner) * pairs_per_facet + k;
    _keys[2 * at] = _loops.edges()[pair.first].id;
    _keys[2 * at + 1] = _loops.edges()[pair.second].id;
    double* values = _values.data() + at * values_per_pair;
    values[0] = std::max(-pair.gap, std::numeric_limits<double>::min());
    std::copy_n(pair.tangential, 3, values + 1);
    std::copy_n(pair.slip, 3, values + 4);
  }
  if (_exchange && common::largest(_exchange->map()->comm(), double(most)) > pairs_per_facet)
    throw std::runtime_error("the edges of a facet have crossed more than " + std::to_string(pairs_per_facet) +
                             " others, which a state cannot hold");
  return work;
}

void CrossedEdges::add_to(state::State& state)
{
  state.add("crossed_edges", state::Place::facet, _keys, 2 * pairs_per_facet);
  state.add("crossed_springs", state::Place::facet, _values, values_per_pair * pairs_per_facet);
}

std::span<const std::string> CrossedEdges::state_names()
{
  static const std::string names[] = {"crossed_edges", "crossed_springs"};
  return names;
}
} // namespace dolfinx_impact::enforcement
