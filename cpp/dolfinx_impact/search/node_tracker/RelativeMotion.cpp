// SPDX-License-Identifier: MIT
#include "RelativeMotion.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::search
{
namespace
{
constexpr double least_deformation = 0.01; ///< of the largest facet: with less, renewals are not asked for

/// Sum of the motions of nodes.
void add_up(int gdim, std::span<const std::int32_t> nodes, const double* du, double* sum)
{
  std::fill_n(sum, 3, 0.0);
  for (std::int32_t node : nodes)
    for (int c = 0; c < gdim; ++c)
      sum[c] += du[std::size_t(node) * gdim + c];
}

/// The largest motion of a node, `mean` left out.
double largest_motion(int gdim, std::span<const std::int32_t> nodes, const double* du, const double* mean)
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

RelativeMotion::RelativeMotion(int gdim, const std::vector<double>& X)
    : _gdim(gdim), _undeformed(X), _points(X.size() / gdim), _paths(X.size() / gdim, 0.0)
{
  for (std::size_t i = 0; i < _points.size(); ++i)
    std::copy_n(X.data() + i * gdim, gdim, _points[i].x);
}

void RelativeMotion::reset(std::span<const std::int32_t> nodes, std::span<const std::int32_t> others,
                           const TrackedSurface& master)
{
  _nodes.assign(nodes.begin(), nodes.end());
  _others.assign(others.begin(), others.end());
  _slave.from.assign(_nodes.size() * _gdim, 0.0);
  _master.from.assign(master.nodes().size() * _gdim, 0.0);
  _others_from.assign(_others.size() * _gdim, 0.0);
  _least_deformation = least_deformation * master.largest_diameter();
  _first = true;
}

/// Motions of all nodes since the last step, and their bounds.
template <int D>
void RelativeMotion::add_step(const double* u, const double* du, TrackedSurface& surface)
{
  // Room for rounding: sums over many steps must not become too small.
  constexpr double room = 1 + 1e-12;
  // Distances change by motion of node and surface against each other, angles by that within each of them.
  struct Sums
  {
    double sum[D] = {}, largest = 0.0, deformation = 0.0; ///< squares
  } master, slave;
  // The translations of this step are about those of the last one.
  double slave_shift[D], master_shift[D];
  for (int c = 0; c < D; ++c)
  {
    slave_shift[c] = _slave.shift[c] + _slave.mean_step[c];
    master_shift[c] = _master.shift[c] + _master.mean_step[c];
  }
  const auto move =
      [&](Sums& side, const double* shift, const double* X, const double* u, const double* from, double* x)
  {
    double squared = 0.0, within = 0.0;
    for (int c = 0; c < D; ++c)
    {
      const double now = X[c] + u[c], d = now - x[c], far = now - from[c] - shift[c];
      x[c] = now;
      side.sum[c] += d;
      squared += (d - _mean_step[c]) * (d - _mean_step[c]);
      within += far * far;
    }
    side.largest = std::max(side.largest, squared);
    side.deformation = std::max(side.deformation, within);
    return squared;
  };
  const std::span<const std::int32_t> nodes = surface.nodes();
  MasterNode* data = surface.node_data();
  for (std::size_t k = 0; k < nodes.size(); ++k)
  {
    const std::size_t node = std::size_t(nodes[k]) * D;
    move(master, master_shift, surface.X(k), u + node, _master.from.data() + k * D, data[k].x);
    std::copy_n(du + node, D, data[k].du);
  }
  const double by_surface = room * surface.stretch() * std::sqrt(master.largest);
  for (std::size_t i = 0; i < size(); ++i)
  {
    const double* now = u + std::size_t(_nodes[i]) * D;
    const double squared =
        move(slave, slave_shift, _undeformed.data() + i * D, now, _slave.from.data() + i * D, _points[i].x);
    _paths[i] += room * std::sqrt(squared) + by_surface;
  }
  for (std::size_t k = 0; k < _others.size(); ++k)
  {
    double squared = 0.0;
    for (int c = 0; c < D; ++c)
    {
      const double d = u[std::size_t(_others[k]) * D + c] - _others_from[k * D + c] - slave_shift[c];
      squared += d * d;
    }
    slave.deformation = std::max(slave.deformation, squared);
  }
  _step = room * std::sqrt(slave.largest) + by_surface;
  _surface_path += by_surface;
  _slave.deformation = room * std::sqrt(slave.deformation);
  _master.deformation = room * std::sqrt(master.deformation);
  const double num_slaves = double(_nodes.size()), num_masters = double(nodes.size());
  for (int c = 0; c < D; ++c)
  {
    _step_shift[c] = _mean_step[c];
    _shift[c] += _mean_step[c];
    _mean_step[c] = (slave.sum[c] + master.sum[c]) / std::max(num_slaves + num_masters, 1.0);
    _slave.shift[c] += _slave.mean_step[c] = slave.sum[c] / std::max(num_slaves, 1.0);
    _master.shift[c] += _master.mean_step[c] = master.sum[c] / std::max(num_masters, 1.0);
  }
}

/// The last positions of these facets are not known: the increments tell the motion of the step.
void RelativeMotion::restart(const double* du, const TrackedSurface& master)
{
  const std::span<const std::int32_t> nodes = master.nodes();
  _surface_path = 0.0;
  std::fill(_paths.begin(), _paths.end(), 0.0);
  std::fill_n(_step_shift, 3, 0.0);
  const double num_slaves = double(_nodes.size()), num_masters = double(nodes.size());
  add_up(_gdim, _nodes, du, _slave.mean_step);
  add_up(_gdim, nodes, du, _master.mean_step);
  for (int c = 0; c < 3; ++c)
  {
    _mean_step[c] = (_slave.mean_step[c] + _master.mean_step[c]) / std::max(num_slaves + num_masters, 1.0);
    _slave.mean_step[c] /= std::max(num_slaves, 1.0);
    _master.mean_step[c] /= std::max(num_masters, 1.0);
  }
  _step =
      largest_motion(_gdim, _nodes, du, _mean_step) + master.stretch() * largest_motion(_gdim, nodes, du, _mean_step);
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
  _renewal_due = false;
  for (std::size_t i = 0; i < size(); ++i)
    std::copy_n(_points[i].x, _gdim, _slave.from.data() + i * _gdim);
  for (std::size_t k = 0; k < master.nodes().size(); ++k)
    std::copy_n(master.node_data()[k].x, _gdim, _master.from.data() + k * _gdim);
  for (std::size_t k = 0; k < _others.size(); ++k)
    std::copy_n(u + std::size_t(_others[k]) * _gdim, _gdim, _others_from.data() + k * _gdim);
  for (Side* side : {&_slave, &_master})
  {
    side->deformation = 0.0;
    std::fill_n(side->shift, 3, 0.0);
  }
}
} // namespace dolfinx_impact::search
