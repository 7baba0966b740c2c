// SPDX-License-Identifier: MIT
#include "RelativeMotion.h"
#include <algorithm>
#include <cmath>
#include <utility>

namespace dolfinx_impact::search
{
namespace
{
constexpr double least_deformation = 0.01; ///< of the largest facet: with less, renewals are not asked for
constexpr double most_unseen = 0.005;      ///< of the largest facet: motion since the last look that asks for another
// Room for rounding: sums over many steps must not become too small.
constexpr double room = 1 + 1e-12;

/// Sum of the motions of nodes.
/// @param[in] num number of nodes, node(k): the number of one
void add_up(int gdim, std::size_t num, auto&& node, const double* du, double* sum)
{
  std::fill_n(sum, 3, 0.0);
  for (std::size_t k = 0; k < num; ++k)
    for (int c = 0; c < gdim; ++c)
      sum[c] += du[std::size_t(node(k)) * gdim + c];
}

/// The largest motion of a node, `mean` left out.
double largest_motion(int gdim, std::size_t num, auto&& node, const double* du, const double* mean)
{
  double largest = 0.0;
  for (std::size_t k = 0; k < num; ++k)
  {
    double squared = 0.0;
    for (int c = 0; c < gdim; ++c)
      squared += std::pow(du[std::size_t(node(k)) * gdim + c] - mean[c], 2);
    largest = std::max(largest, squared);
  }
  return std::sqrt(largest);
}
} // namespace

RelativeMotion::RelativeMotion(int gdim, const std::vector<double>& X) : _gdim(gdim), _points(X.size() / gdim)
{
  for (std::size_t i = 0; i < _points.size(); ++i)
  {
    std::copy_n(X.data() + i * gdim, gdim, _points[i].X);
    std::copy_n(X.data() + i * gdim, gdim, _points[i].x);
  }
}

void RelativeMotion::reset(std::span<const std::int32_t> nodes, std::span<const std::int32_t> others,
                           const TrackedSurface& master)
{
  for (std::size_t i = 0; i < size(); ++i)
    _points[i].node = nodes[i];
  _others.assign(others.begin(), others.end());
  _slave.from.assign(size() * _gdim, 0.0);
  _master.from.assign(master.nodes().size() * _gdim, 0.0);
  _others_from.assign(_others.size() * _gdim, 0.0);
  _least_deformation = least_deformation * master.largest_diameter();
  _most_unseen = most_unseen * master.largest_diameter();
  _first = true;
}

/// Motions of all nodes since the last step, and their bounds.
template <int D>
void RelativeMotion::add_step(const double* u, const double* du, TrackedSurface& surface)
{
  // Distances change by motion of node and surface against each other, angles by that within each of them.
  struct Sums
  {
    double sum[D] = {}, largest = 0.0, within = 0.0; ///< squares
    double translation[D];                           ///< of the side in this step
  } master, slave;
  // The translations of this step are about those of the last one.
  for (auto [sums, side] : {std::pair(&slave, &_slave), std::pair(&master, &_master)})
    for (int c = 0; c < D; ++c)
    {
      const double shift = side->shift[c] + side->mean_step[c];
      sums->translation[c] = shift - side->left_out[c];
      side->left_out[c] = shift;
    }
  double mean_step[D];
  std::copy_n(_mean_step, D, mean_step);
  const auto move = [&mean_step](Sums& side, const double* X, const double* u, double* x)
  {
    double squared = 0.0, within = 0.0;
    for (int c = 0; c < D; ++c)
    {
      const double now = X[c] + u[c], d = now - x[c], far = d - side.translation[c];
      x[c] = now;
      side.sum[c] += d;
      squared += (d - mean_step[c]) * (d - mean_step[c]);
      within += far * far;
    }
    side.largest = std::max(side.largest, squared);
    side.within = std::max(side.within, within);
    return squared;
  };
  const std::span<const std::int32_t> nodes = surface.nodes();
  MasterNode* data = surface.node_data();
  for (std::size_t k = 0; k < nodes.size(); ++k)
  {
    const std::size_t node = std::size_t(nodes[k]) * D;
    move(master, surface.X(k), u + node, data[k].x);
    for (int c = 0; c < D; ++c) // std::copy_n calls a function
      data[k].du[c] = du[node + c];
  }
  const double by_surface = room * surface.stretch() * std::sqrt(master.largest);
  for (Point& point : _points)
  {
    const double squared = move(slave, point.X, u + std::size_t(point.node) * D, point.x);
    point.path += room * std::sqrt(squared) + by_surface;
  }
  for (std::int32_t other : _others)
  {
    double squared = 0.0;
    for (int c = 0; c < D; ++c)
    {
      const double far = du[std::size_t(other) * D + c] - slave.translation[c];
      squared += far * far;
    }
    slave.within = std::max(slave.within, squared);
  }
  _step = room * std::sqrt(slave.largest) + by_surface;
  _surface_path += by_surface;
  _slave.since_look += room * std::sqrt(slave.within);
  _master.since_look += room * std::sqrt(master.within);
  if (_look_due || !(_slave.since_look + _master.since_look <= _most_unseen))
    look<D>(u, surface);
  const double num_slaves = double(size()), num_masters = double(nodes.size());
  for (int c = 0; c < D; ++c)
  {
    _step_shift[c] = _mean_step[c];
    _shift[c] += _mean_step[c];
    _mean_step[c] = (slave.sum[c] + master.sum[c]) / std::max(num_slaves + num_masters, 1.0);
    _slave.shift[c] += _slave.mean_step[c] = slave.sum[c] / std::max(num_slaves, 1.0);
    _master.shift[c] += _master.mean_step[c] = master.sum[c] / std::max(num_masters, 1.0);
  }
}

/// How far the nodes are from where they were at the last renewal.
template <int D>
void RelativeMotion::look(const double* u, const TrackedSurface& surface)
{
  const auto squared = [](const double* x, const double* from, const Side& side)
  {
    double sum = 0.0;
    for (int c = 0; c < D; ++c)
    {
      const double far = x[c] - from[c] - side.left_out[c];
      sum += far * far;
    }
    return sum;
  };
  double slave = 0.0, master = 0.0;
  for (std::size_t k = 0; k < surface.nodes().size(); ++k)
    master = std::max(master, squared(surface.node_data()[k].x, _master.from.data() + k * D, _master));
  for (std::size_t i = 0; i < size(); ++i)
    slave = std::max(slave, squared(_points[i].x, _slave.from.data() + i * D, _slave));
  for (std::size_t k = 0; k < _others.size(); ++k)
    slave = std::max(slave, squared(u + std::size_t(_others[k]) * D, _others_from.data() + k * D, _slave));
  _slave.seen = room * std::sqrt(slave);
  _master.seen = room * std::sqrt(master);
  _slave.since_look = _master.since_look = 0.0;
  _look_due = false;
}

/// The last positions of these facets are not known: the increments tell the motion of the step.
void RelativeMotion::restart(const double* du, const TrackedSurface& master)
{
  const std::span<const std::int32_t> nodes = master.nodes();
  const auto slave_node = [this](std::size_t i) { return _points[i].node; };
  const auto master_node = [nodes](std::size_t k) { return nodes[k]; };
  _surface_path = 0.0;
  for (Point& point : _points)
    point.path = 0.0;
  std::fill_n(_step_shift, 3, 0.0);
  const double num_slaves = double(size()), num_masters = double(nodes.size());
  add_up(_gdim, size(), slave_node, du, _slave.mean_step);
  add_up(_gdim, nodes.size(), master_node, du, _master.mean_step);
  for (int c = 0; c < 3; ++c)
  {
    _mean_step[c] = (_slave.mean_step[c] + _master.mean_step[c]) / std::max(num_slaves + num_masters, 1.0);
    _slave.mean_step[c] /= std::max(num_slaves, 1.0);
    _master.mean_step[c] /= std::max(num_masters, 1.0);
  }
  _step = largest_motion(_gdim, size(), slave_node, du, _mean_step) +
          master.stretch() * largest_motion(_gdim, nodes.size(), master_node, du, _mean_step);
}

void RelativeMotion::advance(const double* u, const double* du, TrackedSurface& master)
{
  _gdim == 2 ? add_step<2>(u, du, master) : add_step<3>(u, du, master);
  _restarted = _first;
  _first = false;
  if (_restarted)
    restart(du, master);
}

void RelativeMotion::fit()
{
  _fitted = _surface_path;
  std::fill_n(_shift, 3, 0.0);
}

void RelativeMotion::renew(const double* u, const TrackedSurface& master)
{
  _renewal_due = _look_due = false;
  for (std::size_t i = 0; i < size(); ++i)
    std::copy_n(_points[i].x, _gdim, _slave.from.data() + i * _gdim);
  for (std::size_t k = 0; k < master.nodes().size(); ++k)
    std::copy_n(master.node_data()[k].x, _gdim, _master.from.data() + k * _gdim);
  for (std::size_t k = 0; k < _others.size(); ++k)
    std::copy_n(u + std::size_t(_others[k]) * _gdim, _gdim, _others_from.data() + k * _gdim);
  for (Side* side : {&_slave, &_master})
  {
    side->seen = side->since_look = 0.0;
    std::fill_n(side->shift, 3, 0.0);
    std::fill_n(side->left_out, 3, 0.0);
  }
}
} // namespace dolfinx_impact::search
