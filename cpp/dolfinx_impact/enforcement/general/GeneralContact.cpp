// SPDX-License-Identifier: MIT
#include "GeneralContact.h"
#include "../../common/agree.h"
#include "../../common/gather.h"
#include "../../search/BoxTree.h"
#include "../../search/general/closest_on_loop.h"
#include "../../search/general/crossed_edges.h"
#include "edge_at.h"
#include "limits.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace dolfinx_impact::enforcement
{
namespace loop = search::loop;
using namespace general;
using search::SurfaceEdge;

namespace
{
/// Entries of _shared by node.
enum Shared
{
  compliance_entry,
  area_entry,
  height_entry,
  group_entry,
  body_entry,
  num_entries
};
/// Edges that a node may be the first end of and that touch others, in a checkpoint.
constexpr std::size_t edges_per_node = 6;
constexpr int numbers_per_edge = 28;

constexpr std::array<double Spring::*, 6> members{&Spring::force,   &Spring::compliance,         &Spring::gap,
                                                  &Spring::surplus, &Spring::tangential_surplus, &Spring::offset};
constexpr std::array<const char*, 6> member_names{"spring_force",   "spring_compliance",         "spring_gap",
                                                  "spring_surplus", "spring_tangential_surplus", "spring_offset"};

const surface::FunctionSpace& checked(const surface::FunctionSpace& V, const surface::Facets& facets,
                                      const GeneralContactOptions& options)
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
                });
  return V;
}
} // namespace

GeneralContact::GeneralContact(const surface::FunctionSpace& V, const surface::Facets& facets,
                               const GeneralContactOptions& options, std::span<const NamedPair> named)
    : _options(options), _gdim(facets.gdim), _surface(checked(V, facets, options), facets, named),
      _candidates(V, facets, &facets, 0.0, options.axisymmetric)
{
  const std::size_t n = _candidates.nodes().size();
  _springs.resize(n * springs_per_node);
  _num_closed.assign(n, 0);
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
  for (std::size_t node = 0; node < _surface.height.size(); ++node)
  {
    double* entries = _shared.data() + node * num_entries;
    entries[compliance_entry] = _known.empty() ? 0.0 : _known[node];
    entries[area_entry] = areas[node];
    entries[height_entry] = _surface.height[node];
    entries[group_entry] = double(_surface.groups[node]);
    entries[body_entry] = _surface.body[node];
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
    _height[k] = entries[height_entry];
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
  _largest_height = 0.0;
  for (const double height : _height)
    _largest_height = std::max(_largest_height, height);
  for (NodeSpring& spring : _springs) // its numbers are those of before
  {
    LastTouch& last = spring.last;
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
  forget_distances();
}

/// Is this node with this facet among the surfaces of a pair that others push apart?
bool GeneralContact::named(std::int32_t node, std::size_t facet) const
{
  if (_surface.num_named == 0)
    return false;
  std::int64_t all = ~std::int64_t(0);
  for (int k = 0; k < _loops.num_corners(); ++k)
    all &= _group[_loops.corners(facet)[k]];
  return _surface.left_out(_group[node], all);
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
  _has_corners.assign(num_nodes(), 0);
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
      const double* first = normals.data() + std::size_t(_list[_starts.back()]) * num * D;
      for (int k = 0; k < num && !_has_corners[i]; ++k)
        _has_corners[i] = loop::dot<D>(normals.data() + (std::size_t(f) * num + k) * D, first) < parallel_of_lists;
    }
    _starts.push_back(std::int32_t(_list.size()));
  }
}

void GeneralContact::keep_edges()
{
  for (const EdgePair& pair : _edge_pairs)
    if (pair.spring.closed)
      _kept_edges[{_loops.edges()[pair.first].id, _loops.edges()[pair.second].id}] = pair;
  _edge_pairs.clear();
}

/// Find the edges as which sharp edges go on beyond their ends. The undeformed body decides, on all ranks alike.
void GeneralContact::continue_edges()
{
  const auto& edges = _loops.edges();
  _continuations.assign(edges.size(), {-1, -1});
  std::vector<std::vector<std::pair<std::int32_t, int>>> at_node(_halo->num_nodes()); // edge and end
  const auto outward = [&](std::int32_t e, int end)
  {
    std::array<double, 3> out;
    double squared = 0.0;
    for (int c = 0; c < 3; ++c)
    {
      out[c] = _X[std::size_t(edges[e].nodes[end]) * 3 + c] - _X[std::size_t(edges[e].nodes[1 - end]) * 3 + c];
      squared += out[c] * out[c];
    }
    for (double& value : out)
      value /= std::sqrt(squared);
    return out;
  };
  for (std::size_t e = 0; e < edges.size(); ++e)
    if (const loop::EdgeAtPresent at = edge_at(edges[e], _loops, _X.data(), nullptr);
        loop::dot<3>(at.normals[0], at.normals[1]) < loop::sharp)
      for (int end = 0; end < 2; ++end)
        at_node[edges[e].nodes[end]].push_back({std::int32_t(e), end});
  for (const auto& all : at_node)
    for (const auto& [e, end] : all)
    {
      double most = going_on;
      for (const auto& [other, other_end] : all)
        if (const double along = -loop::dot<3>(outward(e, end).data(), outward(other, other_end).data());
            other != e && along > most)
        {
          most = along;
          _continuations[e][end] = other;
        }
    }
}

void GeneralContact::list_edges(const std::vector<double>& x)
{
  continue_edges();
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

// --- results

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
  return {std::ranges::count_if(_springs, [](const NodeSpring& s) { return s.spring.closed; }),
          std::ranges::count_if(_edge_pairs, [](const EdgePair& p) { return p.spring.closed; })};
}

// --- state

state::State GeneralContact::saved_state() const
{
  using state::Place;
  const std::size_t n = num_nodes();
  state::State out("direction");
  out.at(Place::node, {_candidates.nodes().begin(), _candidates.nodes().end()});
  add_springs(out, 0);
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
  for (int slot = 1; slot < springs_per_node; ++slot)
  {
    // Files of versions in which a node had one spring lack these parts (files::ReadOptions::later).
    state::State more("other_spring" + std::to_string(slot));
    more.at(Place::node, {_candidates.nodes().begin(), _candidates.nodes().end()});
    add_springs(more, slot);
    out.add(std::move(more));
  }
  return out;
}

/// Histories of the nodes' springs in a slot.
void GeneralContact::add_springs(state::State& out, int slot) const
{
  using state::Place;
  const std::size_t n = num_nodes();
  const int num = facets().displacement.num_corners();
  std::vector<double> tangential, slips, normals, weights, turns;
  std::vector<std::array<double, members.size()>> values(n);
  std::vector<std::int64_t> touched;
  std::vector<std::int8_t> closed;
  for (std::size_t i = 0; i < n; ++i)
  {
    const auto& [spring, last, slip, status] = springs_of(i)[slot];
    tangential.insert(tangential.end(), spring.tangential, spring.tangential + _gdim);
    normals.insert(normals.end(), spring.normal, spring.normal + _gdim);
    slips.insert(slips.end(), slip, slip + _gdim);
    closed.push_back(spring.closed);
    for (std::size_t m = 0; m < members.size(); ++m)
      values[i][m] = spring.spring.*members[m];
    touched.push_back(last.facet);
    weights.insert(weights.end(), last.weights, last.weights + num);
    turns.insert(turns.end(), last.turn, last.turn + num * _gdim);
  }
  out.add_own("tangential", Place::node, std::move(tangential), _gdim);
  out.add_own("slip", Place::node, std::move(slips), _gdim);
  out.add_own("spring_normal", Place::node, std::move(normals), _gdim);
  for (std::size_t m = 0; m < members.size(); ++m)
  {
    std::vector<double> column(n);
    std::ranges::transform(values, column.begin(), [m](const auto& row) { return row[m]; });
    out.add_own(member_names[m], Place::node, std::move(column));
  }
  out.add_own("last_facet", Place::node, std::move(touched));
  out.add_own("last_weights", Place::node, std::move(weights), num);
  out.add_own("last_correction", Place::node, std::move(turns), num * _gdim);
  out.add_own("closed", Place::node, std::move(closed));
}

void GeneralContact::resume_springs(const state::State& saved, int slot)
{
  const int num = facets().displacement.num_corners();
  const auto tangential = saved.values<double>("tangential"), normals = saved.values<double>("spring_normal");
  const auto slips = saved.values<double>("slip"), weights = saved.values<double>("last_weights");
  const auto turns = saved.values<double>("last_correction");
  const auto closed = saved.values<std::int8_t>("closed");
  const auto touched = saved.values<std::int64_t>("last_facet");
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    NodeSpring& own = springs_of(i)[slot] = {};
    auto& [spring, last, slip, status] = own;
    std::copy_n(tangential.begin() + i * _gdim, _gdim, spring.tangential);
    std::copy_n(normals.begin() + i * _gdim, _gdim, spring.normal);
    std::copy_n(slips.begin() + i * _gdim, _gdim, slip);
    for (std::size_t m = 0; m < members.size(); ++m)
      spring.spring.*members[m] = saved.values<double>(member_names[m])[i];
    spring.closed = closed[i] != 0;
    status = spring.closed ? ContactStatus::slip : ContactStatus::open;
    if (!spring.closed)
      continue;
    last.facet = touched[i];
    std::copy_n(weights.begin() + i * num, num, last.weights);
    std::copy_n(turns.begin() + i * num * _gdim, num * _gdim, last.turn);
  }
}

void GeneralContact::count_closed(std::size_t i)
{
  _num_closed[i] = 0;
  for (int slot = 0; slot < springs_per_node; ++slot)
    _num_closed[i] += springs_of(i)[slot].spring.closed;
}

void GeneralContact::resume(const state::State& saved)
{
  const state::State mine = saved_state();
  if (const std::string found = mine.difference_of_structure(saved); !found.empty())
    throw std::invalid_argument("the state belongs to other nodes: " + found);
  resume_springs(saved, 0);
  for (int slot = 1; slot < springs_per_node; ++slot)
    resume_springs(saved.part("other_spring" + std::to_string(slot)), slot);
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    count_closed(i);
    const NodeSpring* const own = springs_of(i);
    const NodeSpring* const strongest = std::max_element(own, own + springs_per_node, is_weaker);
    const bool closed = strongest->spring.closed;
    _results.status[i] = strongest->status;
    _results.gap[i] = closed ? strongest->spring.spring.gap : std::numeric_limits<double>::infinity();
    std::copy_n(strongest->slip, _gdim, _results.slip.begin() + i * _gdim);
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
  forget_distances();
  std::ranges::fill(_forces, 0.0);
}

/// The nodes are elsewhere than at the last step.
void GeneralContact::forget_distances()
{
  std::ranges::fill(_next, 0.0);
  _distances.assign(_list.size(), -std::numeric_limits<double>::infinity());
}

void GeneralContact::reset()
{
  std::ranges::fill(_springs, NodeSpring{});
  std::ranges::fill(_num_closed, 0);
  for (EdgePair& pair : _edge_pairs)
    static_cast<EdgeSpring&>(pair) = {};
  _kept_edges.clear();
  _kept_owners.clear();
  std::ranges::fill(_results.status, ContactStatus::open);
  std::ranges::fill(_results.gap, std::numeric_limits<double>::infinity());
  std::ranges::fill(_results.slip, 0.0);
  forget_distances();
  std::ranges::fill(_forces, 0.0);
  _energy = {};
  _passage = {};
  _deepest = 0.0;
  _num_implausible = 0;
  _first = true;
}
} // namespace dolfinx_impact::enforcement
