// SPDX-License-Identifier: MIT
#include "NodeCandidates.h"
#include "../../common/vectors.h"
#include "../../surface/nodal.h"
#include "../../surface/smooth.h"
#include "../../surface/turned.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace dolfinx_impact::enforcement
{
namespace
{
using dolfinx::MPI::check_error;

/// Smallest and largest facet diameter (distance between corners).
std::pair<double, double> diameters(const surface::Facets& facets)
{
  double smallest = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    const double diameter = surface::diameter(facets, f);
    smallest = std::min(smallest, diameter);
    largest = std::max(largest, diameter);
  }
  return {smallest, largest};
}

/// Points as facets of length zero, whose bounding boxes are the points.
surface::Facets as_facets(int gdim, const std::vector<double>& x)
{
  surface::Facets out;
  out.gdim = gdim;
  out.displacement = out.geometry = {surface::FacetShape::interval, 1};
  const std::size_t n = x.size() / gdim;
  out.orientation.assign(n, 1);
  for (std::size_t i = 0; i < n; ++i)
    for (int twice = 0; twice < 2; ++twice)
      out.x.insert(out.x.end(), x.begin() + i * gdim, x.begin() + (i + 1) * gdim);
  out.X = out.x;
  return out;
}
} // namespace

NodeCandidates::NodeCandidates(const surface::FunctionSpace& V, const surface::Facets& slave,
                               const surface::Facets* master, double distance, bool axisymmetric)
    : _rigid(master == nullptr), _comm(V.mesh()->comm()), _distance(distance), _halo(V.dofmap()->index_map),
      _slave(surface::flat(slave))
{
  const int gdim = V.mesh()->geometry().dim();
  if (slave.gdim != gdim || V.dofmap()->index_map_bs() != gdim || (master && master->gdim != gdim))
    throw std::invalid_argument("slave and master belong to meshes of another dimension than the displacement space");
  if (axisymmetric && gdim != 2)
    throw std::invalid_argument("axisymmetric surfaces are curves in the plane");
  for (const surface::Facets* side : {&slave, master})
    for (std::int32_t node : side ? std::span<const std::int32_t>(side->nodes) : std::span<const std::int32_t>())
      if (node < 0 || node >= _halo.num_nodes())
        throw std::invalid_argument("the facets were made for another displacement space");
  if (master)
  {
    _mine = search::pack(*V.dofmap()->index_map, *master);
    _offsets = surface::offset_components(_mine.facets);
  }
  const auto [smallest, largest] = diameters(_mine.facets);
  double sizes[2] = {std::max(diameters(_slave).second, largest), -smallest}, all[2];
  check_error(_comm, MPI_Allreduce(sizes, all, 2, MPI_DOUBLE, MPI_MAX, _comm));
  _size = all[0];
  _smallest = _rigid ? _size : -all[1];
  if (!(_distance > 0.0))
    _distance = _size;
  _u.resize(std::size_t(_halo.num_nodes()) * gdim);
  find_nodes(V, axisymmetric);
  if (master)
    _slave_facets = search::send_to_owners(_comm, search::pack(*V.dofmap()->index_map, _slave));
}

/// Set the owned nodes and their areas. A rank may own a node without having a facet at it.
void NodeCandidates::find_nodes(const surface::FunctionSpace& V, bool axisymmetric)
{
  const int gdim = _slave.gdim;
  std::vector<double> counts(2 * _halo.num_nodes(), 0.0), slave(_halo.num_nodes(), 0.0), master(slave);
  for (std::int32_t node : _slave.nodes)
    counts[2 * node] = 1.0;
  for (std::int32_t node : _mine.facets.nodes)
    counts[2 * node + 1] = 1.0;
  surface::add_nodal_areas(_slave, axisymmetric, slave);
  surface::add_nodal_areas(_mine.facets, axisymmetric, master);
  _halo.reverse(counts, 2);
  _halo.reverse(slave, 1);
  _halo.reverse(master, 1);
  const std::vector<double> x = V.tabulate_dof_coordinates(false);
  for (std::int32_t node = 0; node < _halo.num_owned(); ++node)
  {
    if (counts[2 * node] > 0.0)
    {
      _nodes.push_back(node);
      _areas.push_back(slave[node]);
      _undeformed.insert(_undeformed.end(), x.begin() + 3 * node, x.begin() + 3 * node + gdim);
    }
    if (counts[2 * node] + counts[2 * node + 1] > 0.0)
    {
      _watched.push_back(node);
      _watched_X.insert(_watched_X.end(), x.begin() + 3 * node, x.begin() + 3 * node + gdim);
    }
  }
  _from.assign(_watched.size() * gdim, 0.0);
  master.resize(_halo.num_owned());
  _master_areas = std::move(master);
}

void NodeCandidates::search(std::span<const double> u, std::span<const double> du, double deepest)
{
  const int gdim = _slave.gdim;
  const std::size_t owned = std::size_t(_halo.num_owned()) * gdim;
  if (u.size() < owned || (!du.empty() && du.size() < owned))
    throw std::invalid_argument("search needs the displacements of all nodes the rank owns");
  if (_rigid)
    return;
  ++_searches;
  std::copy_n(u.begin(), std::size_t(_halo.num_owned()) * gdim, _u.begin());
  _halo.forward(_u, gdim);
  surface::move_and_turn(_mine.facets, _offsets, _u.data());
  std::vector<double> points(_undeformed);
  for (std::size_t i = 0; i < _nodes.size(); ++i)
    for (int c = 0; c < gdim; ++c)
      points[i * gdim + c] += _u[std::size_t(_nodes[i]) * gdim + c];
  mean_motion(du);
  // Slave and master may each move by half of this room; fast bodies get room for several steps.
  double mine_of[2] = {_step, deepest}, all_of[2];
  check_error(_comm, MPI_Allreduce(mine_of, all_of, 2, MPI_DOUBLE, MPI_MAX, _comm));
  const double step = all_of[0];
  _room = std::max(_size, 8 * step);
  _found = search::send_to_overlapping(_comm, _mine, as_facets(gdim, points),
                                       std::max(_distance + all_of[1], 4 * step) + _room);
  // Nodes that this rank neither owns nor has as ghosts of the space.
  const auto& map = _halo.map();
  std::vector<std::int64_t> known(map.ghosts().begin(), map.ghosts().end());
  std::sort(known.begin(), known.end());
  std::vector<std::pair<std::int64_t, int>> far;
  for (const search::FacetPackets* facets : {&_found, &_slave_facets})
    for (std::size_t i = 0; i < facets->nodes.size(); ++i)
      if (const std::int64_t node = facets->nodes[i]; (node < map.local_range()[0] || node >= map.local_range()[1]) &&
                                                      !std::binary_search(known.begin(), known.end(), node))
        far.emplace_back(node, facets->owners[i]);
  std::sort(far.begin(), far.end());
  far.erase(std::unique(far.begin(), far.end()), far.end());
  _remote_nodes.clear();
  _remote_owners.clear();
  for (const auto& [node, owner] : far)
  {
    _remote_nodes.push_back(node);
    _remote_owners.push_back(owner);
  }
}

/// Store positions of the watched nodes and their mean velocity since the last search.
/// @param[in] du increments of owned nodes in a step, or empty [L]
void NodeCandidates::mean_motion(std::span<const double> du)
{
  const int gdim = _slave.gdim;
  double sums[7] = {}, all[7];
  for (std::size_t i = 0; i < _watched.size(); ++i)
    for (int c = 0; c < gdim; ++c)
    {
      _from[i * gdim + c] = _u[std::size_t(_watched[i]) * gdim + c];
      sums[c] += _from[i * gdim + c];
      sums[4 + c] += du.empty() ? 0.0 : du[std::size_t(_watched[i]) * gdim + c];
    }
  sums[3] = double(_watched.size());
  check_error(_comm, MPI_Allreduce(sums, all, 7, MPI_DOUBLE, MPI_SUM, _comm));
  _step = 0.0;
  for (std::size_t i = 0; i < _watched.size() && !du.empty(); ++i)
  {
    double squared = 0.0;
    for (int c = 0; c < gdim; ++c)
      squared += std::pow(du[std::size_t(_watched[i]) * gdim + c] - all[4 + c] / all[3], 2);
    _step = std::max(_step, std::sqrt(squared));
  }
  for (int c = 0; c < gdim; ++c)
  {
    const double mean = all[3] > 0.0 ? all[c] / all[3] : 0.0;
    _velocity[c] = _known && _time > 0.0 ? (mean - _mean[c]) / _time : 0.0;
    _mean[c] = mean;
  }
  _time = 0.0;
  _motion_bound = std::numeric_limits<double>::infinity(); // the next look is at the nodes
  _fresh = _known = true;
}

void NodeCandidates::forget()
{
  _known = false;
}

namespace
{
/// Facets with the numbers that a Halo has for their nodes.
surface::Facets number_facets(const search::FacetPackets& facets, const operators::Halo& halo)
{
  surface::Facets out = facets.facets;
  const auto& map = halo.map();
  const auto range = map.local_range();
  std::vector<std::pair<std::int64_t, std::int32_t>> ghosts;
  for (std::size_t g = 0; g < map.ghosts().size(); ++g)
    ghosts.emplace_back(map.ghosts()[g], map.size_local() + std::int32_t(g));
  std::sort(ghosts.begin(), ghosts.end());
  out.nodes.clear();
  for (std::int64_t node : facets.nodes)
  {
    if (node >= range[0] && node < range[1])
    {
      out.nodes.push_back(std::int32_t(node - range[0]));
      continue;
    }
    const auto at = std::lower_bound(ghosts.begin(), ghosts.end(), std::pair(node, std::int32_t(-1)));
    if (at == ghosts.end() || at->first != node)
      throw std::invalid_argument("the Halo lacks node " + std::to_string(node) + ", which the contact asked for");
    out.nodes.push_back(at->second);
  }
  return out;
}
} // namespace

surface::Facets NodeCandidates::around(const operators::Halo& halo) const
{
  return number_facets(_slave_facets, halo);
}

surface::Facets NodeCandidates::numbered(operators::Halo& halo) const
{
  surface::Facets out = number_facets(_found, halo);
  out.gdim = _slave.gdim;
  const int gdim = out.gdim, n_u = out.displacement.num_nodes(), n_x = out.geometry.num_nodes();
  std::vector<double> X(std::size_t(halo.num_nodes()) * gdim, 0.0);
  for (std::size_t i = 0; i < _watched.size(); ++i)
    std::copy_n(_watched_X.data() + i * gdim, gdim, X.data() + std::size_t(_watched[i]) * gdim);
  halo.forward(X, gdim);
  for (std::size_t f = 0; f < out.size(); ++f)
    for (int j = 0; j < n_u; ++j)
      std::copy_n(X.data() + std::size_t(out.nodes_of(f)[j]) * gdim, gdim, out.X.data() + (f * n_x + j) * gdim);
  return out;
}

void NodeCandidates::assign_numbers(std::span<const std::int32_t> numbers)
{
  const auto of = [&](const std::vector<std::int32_t>& nodes, std::vector<std::int32_t>& out)
  {
    out.resize(nodes.size());
    std::transform(nodes.begin(), nodes.end(), out.begin(), [&](std::int32_t node) { return numbers[node]; });
  };
  of(_nodes, _numbers);
  of(_watched, _watched_numbers);
}

std::vector<double> NodeCandidates::master_areas(operators::Halo& halo) const
{
  std::vector<double> out(halo.num_nodes(), 0.0);
  std::copy(_master_areas.begin(), _master_areas.end(), out.begin());
  halo.forward(out, 1);
  return out;
}

void NodeCandidates::advance(double dt)
{
  if (!_fresh)
    _time += dt;
  _fresh = false;
}

/// Are all nodes near enough even if each of them moved as far as any can have? Then none needs to be looked at.
/// @param[out] used as `increment_used`, an upper bound
bool NodeCandidates::surely_near(const NodalState& state, double& used) const
{
  constexpr double enough = 0.99; // a hundredth is left for the rounding of many steps
  const double since = _time - _bound_time;
  double step = 0.0, ahead = 0.0;
  for (int c = 0; c < _slave.gdim; ++c)
  {
    const auto largest = [&](double shift)
    { return std::max(std::abs(state.range.least[c] - shift), std::abs(state.range.largest[c] - shift)); };
    step += std::pow(largest(_velocity[c] * since), 2);
    ahead += std::pow(largest(_velocity[c] * state.dt), 2);
  }
  _motion_bound += std::sqrt(step);
  _bound_time = _time;
  used = 2 * (_motion_bound + 2 * std::sqrt(ahead)) / _room;
  return used < enough;
}

double NodeCandidates::increment_used(const NodalState& state) const
{
  if (_rigid)
    return 0.0;
  if (double used = 0.0; surely_near(state, used))
    return used;
  const int gdim = _slave.gdim;
  const double ahead = _time + 2 * state.dt;
  double motion = 0.0, now = 0.0;
  for (std::size_t i = 0; i < _watched_numbers.size(); ++i)
  {
    const std::size_t k = std::size_t(_watched_numbers[i]) * gdim;
    double far = 0.0, here = 0.0;
    for (int c = 0; c < gdim; ++c)
    {
      const double moved = state.u[k + c] - _from[i * gdim + c];
      const double d = state.u[k + c] + 2 * state.du[k + c] - _from[i * gdim + c] - _velocity[c] * ahead;
      far += d * d;
      here += (moved - _velocity[c] * _time) * (moved - _velocity[c] * _time);
    }
    motion = std::max(motion, far);
    now = std::max(now, here);
  }
  _motion_bound = std::sqrt(now);
  return _room > 0.0 ? 2 * std::sqrt(motion) / _room : 1.0;
}
} // namespace dolfinx_impact::enforcement
