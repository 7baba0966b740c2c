// SPDX-License-Identifier: MIT
#include "GeneralContact.h"
#include "../../common/agree.h"
#include "../../common/gather.h"
#include "../../operators/RigidBodyModes.h"
#include "../../operators/nodal_sums.h"
#include "../../search/BoxTree.h"
#include "../../search/general/closest_on_loop.h"
#include "../../search/general/crossed_edges.h"
#include "../../surface/cell_heights.h"
#include "../node_to_surface/MomentCorrection.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace dolfinx_impact::enforcement
{
namespace loop = search::loop;
using search::SurfaceEdge;

namespace
{
/// Both ways of contact, nodes of one surface against facets of the other, bear half each.
constexpr double share_of_way = 0.5;
/// Stiffness of a node times dt^2 over its mass: at most, as NodePenalty, and where no nodal stiffness is known.
constexpr double most_per_step = 4.0 * 0.19 / 0.81, unknown_per_step = 0.5;
/// Depths as parts of the height of the cells: as deep as a spring may begin without having been in front before, and
/// as deep as it may begin at all. A node on the far side of a body is one cell behind the facets on the near side.
constexpr double shallow_part = 0.05, deepest_part = 0.5;
/// Cosines of angles between outward normals: of surfaces that face each other; of facets that a closed node may slide
/// to, as long as it has not been open.
constexpr double facing = -0.1, sliding = 0.6;
/// The same where lists are made, from which bodies may turn until the next ones.
constexpr double facing_of_lists = 0.5, sharp_of_lists = 0.985;
/// A facet of the same body that a node was behind at the start, by less than so many cells, is the far side of it.
constexpr double cells_behind = 3.0;
/// Edges touch between their ends: farther from them than the depth, by this factor.
constexpr double inside_factor = 2.0;
/// Facets are equally near if their distances differ by less than this part: of those with one closest point, on an
/// edge, that with the smaller id counts, whatever the rounding.
constexpr double equally_near = 1e-9;
/// Power of the mean that stands for the smallest height at a node: sums over ranks make it.
constexpr int power = 8;
/// Entries of _shared by node.
enum Shared
{
  compliance_entry,
  area_entry,
  thickness_entry,
  group_entry,
  body_entry,
  num_entries
};
/// Bits of a double's mantissa are the named surfaces that a node belongs to, two for each pair.
constexpr std::size_t most_pairs = 26;
/// Edges that a node may be the first end of and that touch others, in a checkpoint.
constexpr std::size_t edges_per_node = 6;
constexpr int numbers_per_edge = 28;

constexpr std::array<double Spring::*, 6> members{&Spring::force,   &Spring::compliance,         &Spring::gap,
                                                  &Spring::surplus, &Spring::tangential_surplus, &Spring::offset};
constexpr std::array<const char*, 6> member_names{"spring_force",   "spring_compliance",         "spring_gap",
                                                  "spring_surplus", "spring_tangential_surplus", "spring_offset"};

const surface::FunctionSpace& checked(const surface::FunctionSpace& V, const surface::Facets& facets,
                                      const GeneralContactOptions& options, std::size_t num_named)
{
  common::agree(V.mesh()->comm(),
                [&]
                {
                  if (!std::isfinite(options.friction) || !(options.friction >= 0.0))
                    throw std::invalid_argument("the friction of a contact is finite and not negative");
                  if (facets.displacement.degree != 1 || facets.geometry.degree != 1 || facets.smooth)
                    throw std::invalid_argument(
                        "general contact needs straight facets: displacements of degree 1 on a mesh of geometry degree "
                        "1; use pairs of surfaces for degree 2");
                  if (num_named > most_pairs)
                    throw std::invalid_argument("general contact beside " + std::to_string(num_named) +
                                                " pairs of surfaces: it can leave out " + std::to_string(most_pairs));
                });
  return V;
}
} // namespace

/// A facet that a node touches.
struct GeneralContact::Touch
{
  std::size_t facet = 0;
  double weights[4], normal[3];
  double gap = std::numeric_limits<double>::infinity(); ///< infinite: none [L]
};

GeneralContact::GeneralContact(const surface::FunctionSpace& V, const surface::Facets& facets,
                               const GeneralContactOptions& options, std::span<const NamedPair> named)
    : _options(options), _gdim(facets.gdim), _num_named(named.size()),
      _candidates(checked(V, facets, options, named.size()), facets, &facets, 0.0, false)
{
  const auto map = V.dofmap()->index_map;
  const std::size_t owned = map->size_local(), all = owned + map->num_ghosts();
  const double size = _candidates.size();
  const std::vector<double> heights = surface::cell_heights(V, facets);
  std::vector<double> powers(all, 0.0), groups(all, 0.0);
  const int num = facets.displacement.num_nodes();
  for (std::size_t f = 0; f < facets.size(); ++f)
    for (int k = 0; k < num; ++k)
      powers[facets.nodes_of(f)[k]] += std::pow(size / heights[f], power);
  powers = operators::sum_over_ranks(map, std::move(powers), 1);
  double bit = 1.0;
  for (const NamedPair& pair : named)
    for (const surface::Facets* side : {&pair.slave, &pair.master})
    {
      std::vector<double> at(all, 0.0);
      for (const std::int32_t node : side->nodes)
        at[node] = 1.0;
      at = operators::sum_over_ranks(map, std::move(at), 1);
      for (std::size_t node = 0; node < all; ++node)
        groups[node] += at[node] > 0.0 ? bit : 0.0;
      bit *= 2.0;
    }
  const std::vector<std::int32_t> bodies = operators::bodies(V).number;
  _thickness.resize(owned);
  for (std::size_t node = 0; node < owned; ++node)
    _thickness[node] = powers[node] > 0.0 ? size * std::pow(powers[node], -1.0 / power) : 0.0;
  _groups.assign(groups.begin(), groups.begin() + owned);
  _bodies.assign(bodies.begin(), bodies.begin() + owned);
  const std::size_t n = _candidates.nodes().size();
  _springs.resize(n);
  _last.resize(n);
  _next.assign(n, 0.0);
  _results = {std::vector<ContactStatus>(n, ContactStatus::open),
              std::vector<double>(n, std::numeric_limits<double>::infinity()), std::vector<double>(n * _gdim, 0.0)};
}

void GeneralContact::set_nodal_compliances(std::vector<double> compliances)
{
  if (compliances.size() != _candidates.num_owned())
    throw std::invalid_argument("nodal compliances: " + std::to_string(_candidates.num_owned()) +
                                " values are needed, not " + std::to_string(compliances.size()));
  for (double value : compliances)
    if (!std::isfinite(value) || value < 0.0)
      throw std::invalid_argument("a nodal compliance is " + std::to_string(value) + ", it must not be negative");
  _known = std::move(compliances);
}

// --- search

void GeneralContact::search(std::span<const double> u, std::span<const double> du)
{
  _candidates.search(u, du, _deepest);
}

std::span<const std::int32_t> GeneralContact::required_nodes(operators::Halo& all)
{
  _found = _candidates.numbered(all);
  _shared.assign(std::size_t(all.num_nodes()) * num_entries, 0.0);
  const auto areas = _candidates.master_areas();
  for (std::size_t node = 0; node < _thickness.size(); ++node)
  {
    double* entries = _shared.data() + node * num_entries;
    entries[compliance_entry] = _known.empty() ? 0.0 : _known[node];
    entries[area_entry] = areas[node];
    entries[thickness_entry] = _thickness[node];
    entries[group_entry] = _groups[node];
    entries[body_entry] = _bodies[node];
  }
  all.forward(_shared, num_entries);
  _needed.assign(_candidates.watched().begin(), _candidates.watched().end());
  _needed.insert(_needed.end(), _found.nodes.begin(), _found.nodes.end());
  std::sort(_needed.begin(), _needed.end());
  _needed.erase(std::unique(_needed.begin(), _needed.end()), _needed.end());
  return _needed;
}

void GeneralContact::assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                                    std::span<const double> mass)
{
  keep_edges();
  _halo = &halo;
  _candidates.assign_numbers(numbers);
  const std::size_t n = halo.num_nodes();
  for (std::vector<double>* values : {&_X, &_x, &_forces})
    values->assign(n * _gdim, 0.0);
  for (std::vector<double>* values : {&_area, &_height, &_surface_compliance, &_compliance})
    values->assign(n, 0.0);
  _inverse_mass.assign(n, 0.0);
  _group.assign(n, 0);
  _body.assign(n, -1);
  for (const std::int32_t node : _needed)
  {
    const double* entries = _shared.data() + std::size_t(node) * num_entries;
    const std::int32_t k = numbers[node];
    _surface_compliance[k] = entries[compliance_entry];
    _area[k] = entries[area_entry];
    _height[k] = entries[thickness_entry];
    _group[k] = std::int64_t(entries[group_entry]);
    _body[k] = std::int32_t(entries[body_entry]);
    _inverse_mass[k] = 1.0 / mass[k];
  }
  const int num = _found.displacement.num_nodes();
  std::vector<double> x(n * _gdim, 0.0);
  for (std::int32_t& node : _found.nodes)
    node = numbers[node];
  for (std::size_t f = 0; f < _found.size(); ++f)
    for (int k = 0; k < num; ++k)
    {
      const std::size_t at = std::size_t(_found.nodes_of(f)[k]) * _gdim;
      std::copy_n(_found.X_of(f) + k * _gdim, _gdim, _X.data() + at);
      std::copy_n(_found.x_of(f) + k * _gdim, _gdim, x.data() + at);
    }
  _loops = search::FacetLoops(_found, n);
  _moved = 0.0;
  std::ranges::fill(_next, 0.0);
  for (LastTouch& last : _last) // its numbers are those of before
  {
    const auto at = std::ranges::lower_bound(_found.id, last.facet);
    if (last.facet >= 0 && at != _found.id.end() && *at == last.facet)
      std::copy_n(_loops.corners(at - _found.id.begin()), _loops.num_corners(), last.corners);
    else
      last = {};
  }
  _compliance_step = 0.0;
  if (_gdim == 2)
    list_facets<2>(x);
  else
  {
    list_facets<3>(x);
    list_edges(x);
  }
}

/// Positions of the corners of a facet, less some increments.
template <int D>
void GeneralContact::corners_at(std::size_t f, const double* x, const double* minus, double (&out)[4][D]) const
{
  for (int k = 0; k < _loops.num_corners(); ++k)
    for (int c = 0; c < D; ++c)
    {
      const std::size_t at = std::size_t(_loops.corners(f)[k]) * D + c;
      out[k][c] = x[at] - (minus ? minus[at] : 0.0);
    }
}

/// Is this node with this facet among the surfaces of a pair that others push apart?
bool GeneralContact::named(std::int32_t node, std::size_t facet) const
{
  if (_num_named == 0)
    return false;
  std::int64_t all = ~std::int64_t(0);
  for (int k = 0; k < _loops.num_corners(); ++k)
    all &= _group[_loops.corners(facet)[k]];
  for (std::size_t pair = 0; pair < _num_named; ++pair)
  {
    const std::int64_t slave = std::int64_t(1) << (2 * pair), master = slave << 1;
    if (((_group[node] & slave) && (all & master)) || ((_group[node] & master) && (all & slave)))
      return true;
  }
  return false;
}

template <int D>
void GeneralContact::list_facets(const std::vector<double>& x)
{
  const int num = _loops.num_corners();
  std::vector<double> boxes(_loops.size() * 2 * D);
  std::vector<double> normals(_loops.size() * num * D);
  double corners[4][D];
  for (std::size_t f = 0; f < _loops.size(); ++f)
  {
    corners_at<D>(f, x.data(), nullptr, corners);
    for (int c = 0; c < D; ++c)
    {
      double low = corners[0][c], high = low;
      for (int k = 1; k < num; ++k)
      {
        low = std::min(low, corners[k][c]);
        high = std::max(high, corners[k][c]);
      }
      boxes[2 * D * f + c] = low;
      boxes[2 * D * f + D + c] = high;
    }
    for (int k = 0; k < num; ++k)
      loop::side_normal(corners, num, k, normals.data() + (f * num + k) * D);
  }
  const search::BoxTree tree(D, boxes);
  const double reach = 1.05 * _candidates.room() + _deepest;
  std::vector<std::int32_t> found;
  _starts.assign(1, 0);
  _list.clear();
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    const std::int32_t node = _candidates.numbers()[i];
    double box[2 * D];
    for (int c = 0; c < D; ++c)
    {
      box[c] = x[std::size_t(node) * D + c] - reach;
      box[D + c] = x[std::size_t(node) * D + c] + reach;
    }
    tree.overlapping(box, found);
    for (const std::int32_t f : found)
    {
      if (_loops.corner_of(f, node) >= 0 || named(node, f))
        continue;
      bool can_face = false;
      for (const std::int32_t own : _loops.at_node(node))
        for (int k = 0; k < num && !can_face; ++k)
          for (int j = 0; j < num && !can_face; ++j)
            can_face = loop::dot<D>(normals.data() + (own * num + k) * D, normals.data() + (f * num + j) * D) <
                       facing_of_lists;
      if (!can_face)
        continue;
      if (_body[node] == _body[_loops.corners(f)[0]])
      {
        corners_at<D>(f, _X.data(), nullptr, corners);
        const auto at = loop::closest(corners, num, _X.data() + std::size_t(node) * D);
        const double height = _height[_loops.corners(f)[0]], behind = -loop::dot<D>(at.away, at.normal);
        if (behind > 1e-6 * height && at.squared < cells_behind * cells_behind * height * height)
          continue;
      }
      _list.push_back(f);
    }
    _starts.push_back(std::int32_t(_list.size()));
  }
}

namespace
{
loop::EdgeAtPresent edge_at(const SurfaceEdge& edge, const search::FacetLoops& loops, const double* x,
                            const double* minus)
{
  loop::EdgeAtPresent out;
  const auto position = [&](std::int32_t node, double* to)
  {
    for (int c = 0; c < 3; ++c)
      to[c] = x[std::size_t(node) * 3 + c] - (minus ? minus[std::size_t(node) * 3 + c] : 0.0);
  };
  for (int k = 0; k < 2; ++k)
  {
    position(edge.nodes[k], out.ends[k]);
    double corners[4][3];
    for (int j = 0; j < loops.num_corners(); ++j)
      position(loops.corners(edge.facets[k])[j], corners[j]);
    loop::side_normal(corners, loops.num_corners(), edge.sides[k], out.normals[k]);
  }
  return out;
}
} // namespace

void GeneralContact::keep_edges()
{
  for (const EdgePair& pair : _edge_pairs)
    if (pair.spring.closed)
      _kept_edges[{_loops.edges()[pair.first].id, _loops.edges()[pair.second].id}] = pair;
  _edge_pairs.clear();
}

void GeneralContact::list_edges(const std::vector<double>& x)
{
  const double reach = 1.05 * _candidates.room() + _deepest;
  std::vector<std::int32_t> sharp, found;
  std::vector<double> boxes;
  for (std::size_t e = 0; e < _loops.edges().size(); ++e)
  {
    const loop::EdgeAtPresent at = edge_at(_loops.edges()[e], _loops, x.data(), nullptr);
    if (!(loop::dot<3>(at.normals[0], at.normals[1]) < sharp_of_lists))
      continue;
    sharp.push_back(std::int32_t(e));
    for (const bool high : {false, true})
      for (int c = 0; c < 3; ++c)
        boxes.push_back(high ? std::max(at.ends[0][c], at.ends[1][c]) : std::min(at.ends[0][c], at.ends[1][c]));
  }
  const search::BoxTree tree(3, boxes);
  for (std::size_t k = 0; k < sharp.size(); ++k)
  {
    const SurfaceEdge& first = _loops.edges()[sharp[k]];
    if (first.nodes[0] >= _halo->num_owned())
      continue; // the owner of this node has the pairs of the edge
    double box[6];
    for (int c = 0; c < 3; ++c)
    {
      box[c] = boxes[6 * k + c] - reach;
      box[3 + c] = boxes[6 * k + 3 + c] + reach;
    }
    tree.overlapping(box, found);
    for (const std::int32_t other : found)
    {
      const SurfaceEdge& second = _loops.edges()[sharp[other]];
      if (!(first.id < second.id) || first.nodes[0] == second.nodes[0] || first.nodes[0] == second.nodes[1] ||
          first.nodes[1] == second.nodes[0] || first.nodes[1] == second.nodes[1])
        continue;
      bool left_out = false;
      for (const std::int32_t f : second.facets)
        left_out |= named(first.nodes[0], f) && named(first.nodes[1], f);
      if (left_out)
        continue;
      if (_body[first.nodes[0]] == _body[second.nodes[0]])
      {
        const loop::Crossing at =
            loop::cross_edges(edge_at(first, _loops, _X.data(), nullptr), edge_at(second, _loops, _X.data(), nullptr));
        if (at.valid && at.gap < 0.0)
          continue;
      }
      EdgePair pair;
      pair.first = sharp[k];
      pair.second = sharp[other];
      if (const auto kept = _kept_edges.find({first.id, second.id}); kept != _kept_edges.end())
      {
        static_cast<EdgeSpring&>(pair) = kept->second;
        _kept_edges.erase(kept);
      }
      _edge_pairs.push_back(pair);
    }
  }
  for (auto& [key, kept] : _kept_edges)
    kept.spring.drop<3>(nullptr, 0.0, _energy);
  _kept_edges.clear();
  _kept_owners.clear();
}

// --- forces

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

/// Find the facet that node i has come through, or is about to.
template <int D>
bool GeneralContact::find(std::size_t i, const NodalState& state, Touch& touch)
{
  const int num = _loops.num_corners();
  const std::size_t node = _candidates.numbers()[i];
  const double* x = _x.data() + node * D;
  const PairSpring& spring = _springs[i];
  double nearest = std::numeric_limits<double>::infinity(), size = 0.0, lost = 0.0;
  for (int c = 0; c < D; ++c)
    size += std::abs(_X[node * D + c]) + std::abs(state.u[node * D + c]);
  const double last_gap = spring.spring.gap - spring.spring.offset;
  // Rounding of positions makes gaps of both signs of surfaces that touch.
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * size;
  for (std::int32_t k = _starts[i]; k < _starts[i + 1]; ++k)
  {
    const std::size_t f = _list[k];
    double corners[4][D];
    corners_at<D>(f, _x.data(), nullptr, corners);
    const loop::Closest<D> at = loop::closest(corners, num, x);
    nearest = std::min(nearest, at.squared);
    const double along = loop::dot<D>(at.away, at.normal), distance = std::sqrt(at.squared);
    const bool front = !(along < 0.0);
    if (front ? !at.inside() || !(spring.closed || along < _largest_step) : false)
      continue;
    // Of an open node what is found behind counts before what is in front, of both the nearest. The side of a closed
    // one is known: the nearest counts.
    const double nearer = (1.0 - equally_near) * std::abs(touch.gap);
    if (spring.closed ? distance >= nearer
        : front       ? touch.gap < 0.0 || distance >= nearer
                      : touch.gap < 0.0 && distance >= nearer)
      continue;
    if (spring.closed ? loop::dot<D>(at.normal, spring.normal) < sliding : !faces<D>(node, at.normal))
      continue;
    if (!front && !at.inside() && !behind_neighbours<D>(f, x, at))
      continue;
    const bool touches = distance <= rounding;
    const double gap = front && at.flat ? along : touches ? 0.0 : front ? distance : -distance;
    double height = _height[_loops.corners(f)[0]];
    for (int j = 1; j < num; ++j)
      height = std::min(height, _height[_loops.corners(f)[j]]);
    if (spring.closed)
    {
      // A gap that the motion of the step does not explain is that of another layer.
      if (!(std::abs(gap - last_gap) <= 2.1 * _largest_step + rounding))
        continue;
      if (-gap > height)
      {
        lost = std::max(lost, -gap / height);
        continue;
      }
    }
    if (gap < 0.0 && !spring.closed)
    {
      if (-gap > shallow_part * height)
      {
        double before[D];
        for (int c = 0; c < D; ++c)
          before[c] = x[c] - state.du[node * D + c];
        corners_at<D>(f, _x.data(), state.du.data(), corners);
        const loop::Closest<D> last = loop::closest(corners, num, before);
        const double gap_before = loop::dot<D>(last.away, last.normal);
        const bool passed = gap_before > -shallow_part * height && (last.inside() || gap_before > 0.0);
        const bool deep = -gap > deepest_part * height;
        if (passed && deep && at.inside())
          if (const double facets = -gap / (deepest_part * height); facets > _passage.facets)
            _passage = {_candidates.nodes()[i], facets};
        if (_first && !deep && at.inside())
          ++_num_implausible;
        if (!passed || deep)
          continue;
      }
    }
    touch.facet = f;
    touch.gap = gap;
    std::copy_n(at.weights, 4, touch.weights);
    for (int c = 0; c < D; ++c)
      touch.normal[c] = at.flat || touches ? at.normal[c] : at.away[c] / (front ? distance : -distance);
  }
  if (!std::isfinite(touch.gap) && lost > _passage.facets)
    _passage = {_candidates.nodes()[i], lost, true};
  _next[i] = _moved + 0.5 * std::sqrt(nearest);
  return std::isfinite(touch.gap);
}

template <int D>
void GeneralContact::add_node(std::size_t i, const NodalState& state)
{
  PairSpring& spring = _springs[i];
  Touch touch;
  const bool found = find<D>(i, state, touch);
  const int num = _loops.num_corners();
  const std::size_t node = _candidates.numbers()[i];
  LastTouch& last = _last[i];
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
  if (found)
  {
    const std::int32_t* corners = _loops.corners(touch.facet);
    double motion[D], others = 0.0;
    for (int c = 0; c < D; ++c)
      motion[c] = state.du[node * D + c];
    for (int k = 0; k < num; ++k)
    {
      others += touch.weights[k] * _compliance[corners[k]] * std::max(_area[node], _area[corners[k]]);
      for (int c = 0; c < D; ++c)
        motion[c] -= touch.weights[k] * state.du[std::size_t(corners[k]) * D + c];
    }
    double r[4 * D];
    MomentCorrection correction;
    if (_options.friction > 0.0)
    {
      correction.set<D>(
          num, [&](int k, int c) { return _x[std::size_t(corners[k]) * D + c]; }, touch.weights, _x.data() + node * D,
          r);
      correction.add_rotation<D>(
          num, r, [&](int k, int c) { return state.du[std::size_t(corners[k]) * D + c]; }, motion);
    }
    const double closing = loop::dot<D>(touch.normal, motion);
    const double stiffness = share_of_way / (_compliance[node] + others / _area[node]);
    spring.begin_at_rest(touch.gap, closing, _first);
    const double* const last_motion = last.corners[0] >= 0 ? before : motion;
    out = spring.advance<D>({touch.normal, touch.gap + spring.spring.offset, closing, motion, last_motion, turn_work},
                            stiffness, _options.friction, _energy);
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
      if (out.tangential_squared > 0.0) // normal forces are along the line of both points
        correction.forces<D>(num, r, out.force,
                             [&](int k, int c, double value)
                             {
                               last.turn[k * D + c] = value;
                               _forces[std::size_t(corners[k]) * D + c] += value;
                             });
    }
  }
  else if (spring.closed)
  {
    spring.drop<D>(last.corners[0] >= 0 ? before : nullptr, turn_work, _energy);
    last = {};
  }
  if (!spring.closed && _results.status[i] == ContactStatus::open)
    return;
  _results.status[i] = spring.closed ? out.status : ContactStatus::open;
  _results.gap[i] = spring.closed ? touch.gap : std::numeric_limits<double>::infinity();
  for (int c = 0; c < D; ++c)
    _results.slip[i * D + c] = spring.closed ? _results.slip[i * D + c] + out.slip[c] : 0.0;
}

void GeneralContact::add_edges(EdgePair& pair, const NodalState& state)
{
  const SurfaceEdge &first = _loops.edges()[pair.first], &second = _loops.edges()[pair.second];
  const loop::EdgeAtPresent a = edge_at(first, _loops, _x.data(), nullptr);
  const loop::EdgeAtPresent b = edge_at(second, _loops, _x.data(), nullptr);
  PairSpring& spring = pair.spring;
  loop::Crossing at = loop::cross_edges(a, b);
  const std::int32_t nodes[4] = {first.nodes[0], first.nodes[1], second.nodes[0], second.nodes[1]};
  if (at.valid && at.gap < 0.0)
  {
    const auto length = [](const loop::EdgeAtPresent& edge)
    {
      return std::hypot(edge.ends[1][0] - edge.ends[0][0], edge.ends[1][1] - edge.ends[0][1],
                        edge.ends[1][2] - edge.ends[0][2]);
    };
    const double lengths[2] = {length(a), length(b)};
    for (int k = 0; k < 2; ++k)
      at.valid &= std::min(at.at[k], 1.0 - at.at[k]) * lengths[k] > -inside_factor * at.gap;
    double height = _height[nodes[0]], size = 0.0;
    for (const std::int32_t node : nodes)
      height = std::min(height, _height[node]);
    for (int c = 0; c < 3; ++c)
      size += std::abs(a.ends[0][c]) + std::abs(a.ends[1][c]);
    if (at.gap > -4.0 * std::numeric_limits<double>::epsilon() * size)
      at.gap = 0.0;
    if (!spring.closed && at.valid && -at.gap > shallow_part * height)
    {
      const loop::Crossing before = loop::cross_edges(edge_at(first, _loops, _x.data(), state.du.data()),
                                                      edge_at(second, _loops, _x.data(), state.du.data()));
      at.valid = -at.gap < deepest_part * height && before.valid && before.gap > -shallow_part * height;
    }
  }
  if (!spring.closed)
    pair.next = _moved + 0.5 * std::sqrt(loop::squared_distance(a, b));
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
    compliance += weights[k] * _compliance[nodes[k]];
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
  spring.begin_at_rest(at.gap, closing, _first);
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
    if (_springs[i].closed || !(_next[i] - _moved > near))
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

std::vector<double> GeneralContact::nodal_forces() const
{
  std::vector<double> out(num_nodes() * _gdim, 0.0);
  if (!_halo)
    return out;
  std::vector<double> sums = _forces;
  _halo->reverse(sums, _gdim);
  for (std::size_t i = 0; i < num_nodes(); ++i)
    std::copy_n(sums.data() + std::size_t(_candidates.numbers()[i]) * _gdim, _gdim, out.data() + i * _gdim);
  return out;
}

template <int D>
void GeneralContact::add_normals(std::vector<double>& out) const
{
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    const std::int32_t node = _candidates.numbers()[i];
    double sum[D] = {}, corners[4][D], normal[D];
    for (const std::int32_t f : _loops.at_node(node))
    {
      corners_at<D>(f, _x.data(), nullptr, corners);
      loop::side_normal(corners, _loops.num_corners(), _loops.corner_of(f, node), normal);
      for (int c = 0; c < D; ++c)
        sum[c] += normal[c];
    }
    const double size = std::sqrt(loop::dot<D>(sum, sum));
    for (int c = 0; c < D; ++c)
      out[i * D + c] = size > 0.0 ? sum[c] / size : 0.0;
  }
}

std::vector<double> GeneralContact::normals() const
{
  std::vector<double> out(num_nodes() * _gdim, 0.0);
  if (_halo)
    _gdim == 2 ? add_normals<2>(out) : add_normals<3>(out);
  return out;
}

std::pair<std::int64_t, std::int64_t> GeneralContact::num_springs() const
{
  return {std::ranges::count_if(_springs, [](const PairSpring& s) { return s.closed; }),
          std::ranges::count_if(_edge_pairs, [](const EdgePair& p) { return p.spring.closed; })};
}

// --- state

state::State GeneralContact::saved_state() const
{
  using state::Place;
  const std::size_t n = num_nodes();
  state::State out("direction");
  out.at(Place::node, {_candidates.nodes().begin(), _candidates.nodes().end()});
  std::vector<double> tangential, normals;
  std::vector<std::int8_t> closed;
  for (const PairSpring& spring : _springs)
  {
    tangential.insert(tangential.end(), spring.tangential, spring.tangential + _gdim);
    normals.insert(normals.end(), spring.normal, spring.normal + _gdim);
    closed.push_back(spring.closed);
  }
  out.add_own("tangential", Place::node, tangential, _gdim).add_own("slip", Place::node, _results.slip, _gdim);
  out.add_own("spring_normal", Place::node, normals, _gdim);
  for (std::size_t m = 0; m < members.size(); ++m)
  {
    std::vector<double> column(n);
    std::ranges::transform(_springs, column.begin(), [&](const PairSpring& s) { return s.spring.*members[m]; });
    out.add_own(member_names[m], Place::node, std::move(column));
  }
  const int num = facets().displacement.num_corners();
  std::vector<std::int64_t> touched;
  std::vector<double> weights, turns;
  for (const LastTouch& last : _last)
  {
    touched.push_back(last.facet);
    weights.insert(weights.end(), last.weights, last.weights + num);
    turns.insert(turns.end(), last.turn, last.turn + num * _gdim);
  }
  out.add_own("last_facet", Place::node, std::move(touched));
  out.add_own("last_weights", Place::node, std::move(weights), num);
  out.add_own("last_correction", Place::node, std::move(turns), num * _gdim);
  out.add_own("closed", Place::node, closed);
  if (_gdim == 3)
  {
    // By the node that owns the pair, the first end of its first edge.
    std::vector<std::int64_t> keys(n * 2 * edges_per_node, -1);
    std::vector<double> values(n * numbers_per_edge * edges_per_node, 0.0);
    std::vector<std::size_t> count(n, 0);
    std::map<EdgeKey, std::pair<std::int32_t, EdgeSpring>> all;
    for (const auto& [key, kept] : _kept_edges)
      all[key] = {_kept_owners.at(key), kept};
    for (const EdgePair& pair : _edge_pairs)
      if (pair.spring.closed)
      {
        const SurfaceEdge& first = _loops.edges()[pair.first];
        const auto at = std::ranges::find(_candidates.numbers(), first.nodes[0]) - _candidates.numbers().begin();
        all[{first.id, _loops.edges()[pair.second].id}] = {std::int32_t(at), pair};
      }
    std::size_t most = 0;
    for (const auto& [key, entry] : all)
    {
      const auto& [i, edge] = entry;
      const PairSpring& spring = edge.spring;
      most = std::max(most, ++count[i]);
      if (count[i] > edges_per_node)
        continue;
      const std::size_t place = std::size_t(i) * edges_per_node + count[i] - 1;
      keys[2 * place] = key.first;
      keys[2 * place + 1] = key.second;
      double* to = values.data() + place * numbers_per_edge;
      for (std::size_t m = 0; m < members.size(); ++m)
        to[m] = spring.spring.*members[m];
      std::copy_n(spring.tangential, 3, to + 6);
      std::copy_n(spring.normal, 3, to + 9);
      std::copy_n(edge.weights, 4, to + 12);
      std::copy_n(edge.turn, 12, to + 16);
    }
    if (common::largest(_candidates.comm(), double(most)) > double(edges_per_node))
      throw std::runtime_error("a node has more than " + std::to_string(edges_per_node) +
                               " crossed edges in contact, which a state cannot hold");
    out.add_own("crossed_edges", Place::node, std::move(keys), 2 * edges_per_node);
    out.add_own("crossed_springs", Place::node, std::move(values), numbers_per_edge * edges_per_node);
  }
  out.add_own("energies", Place::rank,
              std::vector<double>{_energy.stored, _energy.friction, _energy.normal, _energy.later_friction,
                                  _energy.later_normal, _energy.recoverable});
  out.add_own("force", Place::rank, std::vector<double>(_gdim, 0.0));
  return out;
}

void GeneralContact::resume(const state::State& saved)
{
  const state::State mine = saved_state();
  if (const std::string found = mine.difference_of_structure(saved); !found.empty())
    throw std::invalid_argument("the state belongs to other nodes: " + found);
  const auto tangential = saved.values<double>("tangential"), normals = saved.values<double>("spring_normal");
  const auto slip = saved.values<double>("slip");
  const auto closed = saved.values<std::int8_t>("closed");
  std::ranges::copy(slip, _results.slip.begin());
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    PairSpring& spring = _springs[i];
    std::copy_n(tangential.begin() + i * _gdim, _gdim, spring.tangential);
    std::copy_n(normals.begin() + i * _gdim, _gdim, spring.normal);
    for (std::size_t m = 0; m < members.size(); ++m)
      spring.spring.*members[m] = saved.values<double>(member_names[m])[i];
    spring.closed = closed[i] != 0;
    _results.status[i] = spring.closed ? ContactStatus::slip : ContactStatus::open;
    _results.gap[i] = spring.closed ? spring.spring.gap : std::numeric_limits<double>::infinity();
  }
  const int num = facets().displacement.num_corners();
  const auto touched = saved.values<std::int64_t>("last_facet");
  const auto weights = saved.values<double>("last_weights"), turns = saved.values<double>("last_correction");
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    _last[i] = {};
    _last[i].facet = touched[i];
    std::copy_n(weights.begin() + i * num, num, _last[i].weights);
    std::copy_n(turns.begin() + i * num * _gdim, num * _gdim, _last[i].turn);
  }
  _edge_pairs.clear();
  _kept_edges.clear();
  _kept_owners.clear();
  if (_gdim == 3)
  {
    const auto keys = saved.values<std::int64_t>("crossed_edges");
    const auto values = saved.values<double>("crossed_springs");
    for (std::size_t place = 0; place < keys.size() / 2; ++place)
      if (keys[2 * place] >= 0)
      {
        const double* from = values.data() + place * numbers_per_edge;
        EdgeSpring edge;
        PairSpring& spring = edge.spring;
        for (std::size_t m = 0; m < members.size(); ++m)
          spring.spring.*members[m] = from[m];
        std::copy_n(from + 6, 3, spring.tangential);
        std::copy_n(from + 9, 3, spring.normal);
        spring.closed = true;
        std::copy_n(from + 12, 4, edge.weights);
        std::copy_n(from + 16, 12, edge.turn);
        const EdgeKey key{keys[2 * place], keys[2 * place + 1]};
        _kept_edges[key] = edge;
        _kept_owners[key] = std::int32_t(place / edges_per_node);
      }
  }
  const auto e = saved.values<double>("energies");
  _energy = {e[0], e[1], e[2], e[3], e[4], e[5]};
  _passage = {};
  _first = false;
  std::ranges::fill(_next, 0.0);
  std::ranges::fill(_forces, 0.0);
}

void GeneralContact::reset()
{
  for (PairSpring& spring : _springs)
    spring = {};
  for (EdgePair& pair : _edge_pairs)
    static_cast<EdgeSpring&>(pair) = {};
  std::ranges::fill(_last, LastTouch{});
  _kept_edges.clear();
  _kept_owners.clear();
  std::ranges::fill(_results.status, ContactStatus::open);
  std::ranges::fill(_results.gap, std::numeric_limits<double>::infinity());
  std::ranges::fill(_results.slip, 0.0);
  std::ranges::fill(_next, 0.0);
  std::ranges::fill(_forces, 0.0);
  _energy = {};
  _passage = {};
  _deepest = 0.0;
  _num_implausible = 0;
  _first = true;
}
} // namespace dolfinx_impact::enforcement
