// SPDX-License-Identifier: MIT
#include "NodeTracking.h"
#include "../boxes.h"
#include <algorithm>
#include <cmath>
#include <numeric>

namespace dolfinx_impact::search
{
namespace
{
constexpr double never = std::numeric_limits<double>::infinity();
constexpr double tree_slack = 0.25; ///< of the largest facet: travel after which the tree is fitted again

/// Sum of the motions of nodes.
void add_up(int gdim, std::span<const std::int32_t> nodes, const double* du, double* sum)
{
  std::fill_n(sum, 3, 0.0);
  for (std::int32_t node : nodes)
    for (int c = 0; c < gdim; ++c)
      sum[c] += du[std::size_t(node) * gdim + c];
}

/// The farthest that any node moves, `mean` left out.
double farthest(int gdim, std::span<const std::int32_t> nodes, const double* du, const double* mean)
{
  double largest = 0.0;
  for (std::int32_t node : nodes)
  {
    double squared = 0.0;
    for (int c = 0; c < gdim; ++c)
      squared += std::pow(du[std::size_t(node) * gdim + c] - mean[c], 2);
    largest = std::max(largest, squared);
  }
  return std::sqrt(largest);
}
} // namespace

NodeTracking::NodeTracking(int gdim, const std::vector<double>& X) : _gdim(gdim)
{
  const std::size_t n = X.size() / gdim;
  _node.resize(n);
  for (std::size_t i = 0; i < n; ++i)
  {
    Node& node = _node[i];
    node = {-never, 0.0, -1, 0, -1, -1, {0.0, 0.0}, {}, {}, {}, never, 1.0, -never};
    std::copy_n(X.data() + i * gdim, gdim, node.X);
    std::copy_n(node.X, 3, node.x);
  }
  _travelled.assign(n, {0.0, -never});
  _turn_wake.assign(n, never);
  _lists.resize(n);
  _held.assign(n, -1);
}

void NodeTracking::reset(surface::Facets master, std::span<const std::int32_t> nodes, surface::Facets slave,
                         double reach)
{
  _master = std::move(master);
  _nodes.assign(nodes.begin(), nodes.end());
  for (std::size_t i = 0; i < size(); ++i)
    _node[i].number = nodes[i];
  _normals.reset(std::move(slave), nodes);
  _reach = reach;
  const surface::FacetElement& element = _master.geometry;
  const int corners = element.num_corners(), n_x = element.num_nodes(), n_u = _master.displacement.num_nodes();
  const bool linear = element.degree == 1 && _master.displacement.degree == 1;
  _kind = linear && int(element.shape == surface::FacetShape::interval) == int(_gdim == 2) ? Kind(int(element.shape))
                                                                                           : Kind::general;
  _size.assign(_master.size(), 0.0);
  for (std::size_t f = 0; f < _master.size(); ++f)
    for (int i = 0; i < corners; ++i)
      for (int j = 0; j < i; ++j)
      {
        double squared = 0.0;
        for (int c = 0; c < _gdim; ++c)
          squared += std::pow(_master.X_of(f)[i * _gdim + c] - _master.X_of(f)[j * _gdim + c], 2);
        _size[f] = std::max(_size[f], std::sqrt(squared));
      }
  _largest = _size.empty() ? 0.0 : *std::max_element(_size.begin(), _size.end());
  _slope = Turning::slope(element);
  _phi.assign(n_x * n_u, 0.0);
  for (int i = 0; i < n_x; ++i)
    _master.displacement.values(element.node(i).data(), _phi.data() + i * n_u);
  bounding_boxes(_master, _boxes);
  _tree = BoxTree(_gdim, _boxes);
  _master_nodes = _master.nodes;
  std::sort(_master_nodes.begin(), _master_nodes.end());
  _master_nodes.erase(std::unique(_master_nodes.begin(), _master_nodes.end()), _master_nodes.end());
  _master_X.assign(_master_nodes.size() * _gdim, 0.0);
  _masters.assign(_master_nodes.size(), {});
  _slave_from.assign(size() * _gdim, 0.0);
  _master_from.assign(_master_nodes.size() * _gdim, 0.0);
  _others_from.assign(_normals.others().size() * _gdim, 0.0);
  _corners.resize(_master.nodes.size());
  for (std::size_t f = 0; f < _master.size(); ++f)
    for (int j = 0; j < n_u; ++j)
    {
      const std::size_t k = f * n_u + j;
      const auto at = std::lower_bound(_master_nodes.begin(), _master_nodes.end(), _master.nodes[k]);
      _corners[k] = std::int32_t(at - _master_nodes.begin());
      std::copy_n(_master.X_of(f) + j * _gdim, _gdim, _master_X.data() + std::size_t(_corners[k]) * _gdim);
    }
  find_held();
  _fresh = true;
}

/// Moves of all nodes since the last step, and their bounds.
template <int D>
void NodeTracking::move(const double* u, const double* du)
{
  // Room for rounding: what is added up over many steps must not be too small.
  constexpr double room = 1 + 1e-12;
  // Distances change by motion of node and surface against each other, angles by that within each of them.
  struct Side
  {
    double sum[D] = {}, farthest = 0.0, bent = 0.0; ///< squares
  } master, slave;
  // The translations of this step are about those of the last one.
  double slave_shift[D], master_shift[D];
  for (int c = 0; c < D; ++c)
  {
    slave_shift[c] = _slave_shift[c] + _slave_mean[c];
    master_shift[c] = _master_shift[c] + _master_mean[c];
  }
  const auto move =
      [&](Side& side, const double* shift, const double* X, const double* u, const double* from, double* x)
  {
    double squared = 0.0, within = 0.0;
    for (int c = 0; c < D; ++c)
    {
      const double now = X[c] + u[c], d = now - x[c], far = now - from[c] - shift[c];
      x[c] = now;
      side.sum[c] += d;
      squared += (d - _mean[c]) * (d - _mean[c]);
      within += far * far;
    }
    side.farthest = std::max(side.farthest, squared);
    side.bent = std::max(side.bent, within);
    return squared;
  };
  for (std::size_t k = 0; k < _master_nodes.size(); ++k)
  {
    const std::size_t node = std::size_t(_master_nodes[k]) * D;
    move(master, master_shift, _master_X.data() + k * D, u + node, _master_from.data() + k * D, _masters[k].x);
    std::copy_n(du + node, D, _masters[k].du);
  }
  const double surface = room * std::sqrt(master.farthest);
  for (std::size_t i = 0; i < size(); ++i)
  {
    const double* now = u + std::size_t(_nodes[i]) * D;
    const double squared = move(slave, slave_shift, _node[i].X, now, _slave_from.data() + i * D, _node[i].x);
    _travelled[i].now += room * std::sqrt(squared) + surface;
  }
  const auto others = _normals.others();
  for (std::size_t k = 0; k < others.size(); ++k)
  {
    double squared = 0.0;
    for (int c = 0; c < D; ++c)
    {
      const double d = u[std::size_t(others[k]) * D + c] - _others_from[k * D + c] - slave_shift[c];
      squared += d * d;
    }
    slave.bent = std::max(slave.bent, squared);
  }
  _step = room * std::sqrt(slave.farthest) + surface;
  _travel += surface;
  _bent = room * std::sqrt(slave.bent);
  _master_bent = room * std::sqrt(master.bent);
  const double num_slaves = double(_nodes.size()), num_masters = double(_master_nodes.size());
  for (int c = 0; c < D; ++c)
  {
    _step_shift[c] = _mean[c];
    _shift[c] += _mean[c];
    _mean[c] = (slave.sum[c] + master.sum[c]) / std::max(num_slaves + num_masters, 1.0);
    _slave_shift[c] += _slave_mean[c] = slave.sum[c] / std::max(num_slaves, 1.0);
    _master_shift[c] += _master_mean[c] = master.sum[c] / std::max(num_masters, 1.0);
  }
}

/// Motions that turn normals count from here.
void NodeTracking::renew(const double* u)
{
  ++_counters.renewals;
  _renew = false;
  _bent = _master_bent = 0.0;
  for (std::size_t i = 0; i < size(); ++i)
  {
    std::copy_n(_node[i].x, _gdim, _slave_from.data() + i * _gdim);
    _node[i].bent = never; // to be evaluated anew
    _node[i].rate = 1.0;
  }
  for (std::size_t k = 0; k < _master_nodes.size(); ++k)
    std::copy_n(_masters[k].x, _gdim, _master_from.data() + k * _gdim);
  const auto others = _normals.others();
  for (std::size_t k = 0; k < others.size(); ++k)
    std::copy_n(u + std::size_t(others[k]) * _gdim, _gdim, _others_from.data() + k * _gdim);
  for (double* shift : {_slave_shift, _master_shift})
    std::fill_n(shift, 3, 0.0);
}

void NodeTracking::advance(const double* u, const double* du)
{
  ++_counters.steps;
  _ahead = _ahead_end = 0;
  _gdim == 2 ? move<2>(u, du) : move<3>(u, du);
  if (_fresh) // the last positions of these facets are not known
  {
    _fresh = false;
    _travel = 0.0;
    std::fill_n(_step_shift, 3, 0.0);
    const double num_slaves = double(_nodes.size()), num_masters = double(_master_nodes.size());
    add_up(_gdim, _nodes, du, _slave_mean);
    add_up(_gdim, _master_nodes, du, _master_mean);
    for (int c = 0; c < 3; ++c)
    {
      _mean[c] = (_slave_mean[c] + _master_mean[c]) / std::max(num_slaves + num_masters, 1.0);
      _slave_mean[c] /= std::max(num_slaves, 1.0);
      _master_mean[c] /= std::max(num_masters, 1.0);
    }
    _step = farthest(_gdim, _nodes, du, _mean) + farthest(_gdim, _master_nodes, du, _mean);
    wake_all();
    for (std::size_t i = 0; i < size(); ++i)
    {
      _node[i].expire = -never;
      _travelled[i].now = 0.0;
    }
    renew(u);
    return refit(u);
  }
  if (_bent + _master_bent > _least_wake || _renew)
    wake_turned();
  if (_renew && !_keep_normals)
    renew(u);
  if (_travel - _fitted > tree_slack * _largest)
    refit(u);
}

void NodeTracking::refit(const double* u)
{
  ++_counters.refits;
  for (std::size_t f = 0; f < _master.size(); ++f)
    positions(std::int32_t(f), {u, nullptr}, _master.x.data() + f * _master.geometry.num_nodes() * _gdim);
  bounding_boxes(_master, _boxes);
  _tree.refit(_boxes);
  _fitted = _travel;
  std::fill_n(_shift, 3, 0.0);
}

void NodeTracking::find_held()
{
  for (std::size_t i = 0; i < size(); ++i)
  {
    const auto at = std::lower_bound(_master.id.begin(), _master.id.end(), _held[i]);
    const bool there = _held[i] >= 0 && at != _master.id.end() && *at == _held[i];
    _node[i].held = there ? std::int32_t(at - _master.id.begin()) : -1;
  }
}

void NodeTracking::hold(std::size_t i, const Projection& at)
{
  Node& node = _node[i];
  if (node.held != at.facet || _held[i] < 0)
    _held[i] = _master.id[at.facet];
  node.held = at.facet;
  node.xi[0] = at.xi[0];
  node.xi[1] = at.xi[1];
  _travelled[i].wake = -never;
}

std::vector<double> NodeTracking::held_xi() const
{
  std::vector<double> out;
  for (const Node& node : _node)
    out.insert(out.end(), node.xi, node.xi + 2);
  return out;
}

void NodeTracking::set_held(std::span<const std::int64_t> ids, std::span<const double> xi)
{
  std::copy(ids.begin(), ids.end(), _held.begin());
  for (std::size_t i = 0; i < size(); ++i)
    std::copy_n(xi.data() + 2 * i, 2, _node[i].xi);
  find_held();
  wake_all();
}
} // namespace dolfinx_impact::search
