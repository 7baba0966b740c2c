// SPDX-License-Identifier: MIT
#include "KinematicContact.h"
#include "../../common/vectors.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::enforcement
{
namespace
{
constexpr double held = 1e-9;        ///< moved by less than this of what it moves elsewhere, a node does not move
constexpr double over_relaxed = 1.5; ///< every second sweep: what alternates from node to node needs more
constexpr double fading = 0.95;      ///< of the impulse that a release may have, from step to step

const KinematicContactOptions& checked(const KinematicContactOptions& o)
{
  if (o.sweeps < 1)
    throw std::invalid_argument("kinematic contact takes one sweep or more, found " + std::to_string(o.sweeps));
  return o;
}
} // namespace

KinematicContact::KinematicContact(const surface::FunctionSpace& V, const surface::Facets& slave,
                                   const surface::Facets& master, const KinematicContactOptions& options)
    : KinematicContact(V, slave, &master, nullptr, options)
{
}

KinematicContact::KinematicContact(const surface::FunctionSpace& V, const surface::Facets& slave,
                                   const gap::Rigid& master, const KinematicContactOptions& options)
    : KinematicContact(V, slave, nullptr, &master, options)
{
}

KinematicContact::KinematicContact(const surface::FunctionSpace& V, const surface::Facets& slave,
                                   const surface::Facets* master, const gap::Rigid* rigid,
                                   const KinematicContactOptions& options)
    : NodeToSurface(V, slave, master, rigid, checked(options)), _sweeps(options.sweeps),
      _num_masters(master ? master->displacement.num_nodes() : 0)
{
  const std::size_t n = num_nodes(), vector = n * _gdim;
  _taken.assign(n, 0.0);
  _pulse.assign(n, 0.0);
  _closed_now.resize(n);
  _phi.resize(n * _num_masters);
  for (std::vector<double>* a : {&_motion, &_nodal_force})
    a->assign(vector, 0.0);
  _corrections.resize(n);
  _arms.resize(vector * _num_masters);
  _along.assign(n, 0.0);
  _across.assign(n, 0.0);
}

void KinematicContact::set_taken(std::vector<double> taken, std::vector<double> pulse)
{
  if (taken.size() != num_nodes() || pulse.size() != num_nodes())
    throw std::invalid_argument("energies and impulses belong to other nodes: this rank has " +
                                std::to_string(num_nodes()) + " slave nodes, found " + std::to_string(taken.size()));
  _taken = std::move(taken);
  _pulse = std::move(pulse);
}

void KinematicContact::number(operators::Halo& halo, std::span<const std::int32_t> numbers, const double* mass)
{
  NodeToSurface::number(halo, numbers, mass);
  const std::size_t num = halo.num_nodes();
  _touched.assign(_candidates.watched_numbers().begin(), _candidates.watched_numbers().end());
  _touched.insert(_touched.end(), _tracker.master().nodes.begin(), _tracker.master().nodes.end());
  std::sort(_touched.begin(), _touched.end());
  _touched.erase(std::unique(_touched.begin(), _touched.end()), _touched.end());
  _weight.assign(num, 0.0);
  for (std::vector<double>* values : {&_sum, &_moved, &_before})
    values->assign(num * _gdim, 0.0);
}

/// Values at closed node q less those at its master point.
template <int D>
void KinematicContact::relative(std::size_t q, const double* values, double* out) const
{
  const Closed& closed = _closed_now[q];
  const double* phi = _phi.data() + q * _num_masters;
  for (int c = 0; c < D; ++c)
    out[c] = values[std::size_t(closed.node) * D + c];
  for_nodes(_num_masters,
            [&](int j)
            {
              for (int c = 0; c < D; ++c)
                out[c] -= phi[j] * values[std::size_t(closed.masters[j]) * D + c];
            });
}

/// Closed nodes of the predicted configuration, and those that leave the master after having been closed.
template <int D>
void KinematicContact::predict(const PredictedStep& step, const double* u)
{
  const double *du = step.du, *before = step.du_before;
  _num_closed = 0;
  Touch touch;
  for (std::size_t i = 0; i < _candidates.nodes().size(); ++i)
  {
    if (!_rigid && _tracker.skipped(i))
      continue;
    const bool may_release = _taken[i] > 0.0; // so it was among the closed nodes of the step before
    if (!meets(i, u, du, may_release ? std::numeric_limits<double>::infinity() : 0.0, false, touch))
    {
      _taken[i] = _pulse[i] = 0.0;
      continue;
    }
    const bool releases = !(touch.at.gap < 0.0);
    if (releases && touch.at.rim == search::Projection::Rim::beside)
    {
      open(i, touch.at, u);
      _taken[i] = _pulse[i] = 0.0;
      continue;
    }
    const std::size_t q = _num_closed++;
    Closed& closed = _closed_now[q];
    closed = {touch.masters, touch.corners, {}, -touch.at.gap, std::uint32_t(i), touch.node, releases};
    std::copy_n(touch.at.normal, 3, closed.normal);
    // Forces act at t_n, along the facet's normal then: the predicted facet is tilted by the lack of these very forces.
    if (!_rigid && touch.at.on_facet())
      _tracker.normal_before(touch.at, u, du, closed.normal);
    for_nodes(_num_masters, [&](int j) { _phi[q * _num_masters + j] = touch.phi[j]; });
    if (!_rigid)
      _tracker.track(i, touch.at);
    if (turns())
    {
      double x[D];
      for (int c = 0; c < D; ++c)
      {
        const std::size_t k = std::size_t(touch.node) * D + c;
        x[c] = _candidates.X()[i * D + c] + (u[k] - du[k]);
      }
      const auto at = [&](int j, int c)
      {
        const search::MasterNode& master = _tracker.masters()[touch.corners[j]];
        return master.x[c] - master.du[c];
      };
      _corrections[q].set<D>(_num_masters, at, touch.phi, x, _arms.data() + q * _num_masters * D);
    }
    double* motion = _motion.data() + q * D;
    relative<D>(q, du, motion);
    for (int c = 0; c < D; ++c)
      motion[c] -= _rigid ? _obstacle_increment[c] : 0.0;
  }
  std::fill_n(_nodal_force.data(), _num_closed * D, 0.0);
  for (std::int32_t node : _touched)
    for (int c = 0; c < D; ++c)
    {
      const std::size_t k = std::size_t(node) * D + c;
      _before[k] = before[k];
      _moved[k] = 0.0;
    }
}

/// Forces on the masters of closed node q for a unit force on it along the normal, [j*D + c].
template <int D>
void KinematicContact::reaction(std::size_t q, double* out) const
{
  const double* n = _closed_now[q].normal;
  for (int j = 0; j < _num_masters; ++j)
    for (int c = 0; c < D; ++c)
      out[j * D + c] = -_phi[q * _num_masters + j] * n[c];
  if (turns())
    _corrections[q].forces<D>(_num_masters, _arms.data() + q * _num_masters * D, n,
                              [&](int j, int c, double value) { out[j * D + c] += value; });
}

/// How much a force of the sweep moves: the sums of the rows of the bodies' response, along the normal and across it.
template <int D>
void KinematicContact::add_masses(const double* inverse_mass)
{
  if (!_rigid)
  {
    // Ghosts have what their owners sent in the last step, also those that nothing here touches.
    std::fill(_weight.begin(), _weight.end(), 0.0);
    for (std::size_t q = 0; q < _num_closed; ++q)
    {
      const Closed& closed = _closed_now[q];
      if (closed.releases)
      {
        double pushed[surface::FacetElement::max_nodes * D];
        reaction<D>(q, pushed);
        for (int j = 0; j < _num_masters; ++j)
          _weight[closed.masters[j]] += std::sqrt(dot(pushed + j * D, pushed + j * D, D));
      }
      else
        for (int j = 0; j < _num_masters; ++j)
          _weight[closed.masters[j]] += std::abs(_phi[q * _num_masters + j]);
    }
    _halo->reverse(_weight.data(), 1);
    _halo->forward(_weight.data(), 1);
  }
  for (std::size_t q = 0; q < _num_closed; ++q)
  {
    const Closed& closed = _closed_now[q];
    const double* phi = _phi.data() + q * _num_masters;
    double w[D], along = 0.0, across = 0.0;
    for (int c = 0; c < D; ++c)
      w[c] = inverse_mass[std::size_t(closed.node) * D + c];
    for_nodes(_num_masters,
              [&](int j)
              {
                const std::size_t node = closed.masters[j];
                for (int c = 0; c < D; ++c)
                  w[c] += std::abs(phi[j]) * _weight[node] * inverse_mass[node * D + c];
              });
    const double* n = closed.normal;
    for (int c = 0; c < D; ++c)
    {
      along += n[c] * n[c] * w[c];
      across = std::max(across, w[c]);
    }
    _along[q] = along > held * across ? 1.0 / along : 0.0;
    _across[q] = across > 0.0 ? 1.0 / across : 0.0;
  }
}

/// Normal forces of the nodes that leave the master: each gives back at most the energy taken from it since it closed,
/// by no more impulse than contact has had in its last steps (docs/explicit/kinematic.md, "Release").
template <int D>
void KinematicContact::release(const PredictedStep& step)
{
  const double *du = step.du, *inverse_mass = step.inverse_mass, h = step.h, dt = step.dt;
  for (std::size_t q = 0; q < _num_closed; ++q)
  {
    const Closed& closed = _closed_now[q];
    if (!closed.releases)
      continue;
    const double* n = closed.normal;
    double before[3], pushed[surface::FacetElement::max_nodes * D];
    relative<D>(q, _before.data(), before);
    // Work of a unit force with the motion as it is, half of what this force moves per unit of it.
    double way = 0.0, moves = 0.0;
    for (int c = 0; c < D; ++c)
    {
      way += 0.5 * n[c] * (before[c] - (_rigid ? _obstacle_before[c] : 0.0) + _motion[q * D + c]);
      moves += n[c] * n[c] * inverse_mass[std::size_t(closed.node) * D + c];
    }
    reaction<D>(q, pushed);
    for (int j = 0; j < _num_masters; ++j)
    {
      const std::size_t node = closed.masters[j];
      const double phi = _phi[q * _num_masters + j], size = std::sqrt(dot(pushed + j * D, pushed + j * D, D));
      for (int c = 0; c < D; ++c)
      {
        const double push = pushed[j * D + c], correction = push + phi * n[c];
        way += 0.5 * correction * (_before[node * D + c] + du[node * D + c]);
        if (size > 0.0)
          moves += push * push / size * _weight[node] * inverse_mass[node * D + c];
      }
    }
    const double taken = step.release_share * _taken[closed.i], most = _pulse[closed.i] * dt / h;
    const double force =
        taken > 0.0 ? std::min(most, 2.0 * taken / (way + std::sqrt(way * way + 2.0 * h * moves * taken))) : 0.0;
    for (int c = 0; c < D; ++c)
      _nodal_force[q * D + c] = force * n[c];
  }
}

/// Forces of the sweep, within what contact can bear.
/// @param[in] factor of what the masses call for
template <int D>
void KinematicContact::solve_forces(double h, double factor)
{
  for (std::size_t q = 0; q < _num_closed; ++q)
  {
    const Closed& closed = _closed_now[q];
    const double* n = closed.normal;
    double moved[3], more[3] = {0.0, 0.0, 0.0}, *f = _nodal_force.data() + q * D;
    relative<D>(q, _moved.data(), moved);
    const double pushed = closed.releases ? 0.0 : factor / h * _along[q] * (closed.overlap - dot(n, moved, D));
    if (_options.friction > 0.0)
    {
      for (int c = 0; c < D; ++c)
        moved[c] += _motion[q * D + c];
      const double away = dot(n, moved, D);
      for (int c = 0; c < D; ++c)
        more[c] = factor / h * _across[q] * (away * n[c] - moved[c]);
    }
    for (int c = 0; c < D; ++c)
      more[c] += pushed * n[c];
    const double along = dot(n, more, D), before = dot(n, f, D), normal = std::max(0.0, before + along);
    double tangential[3] = {0.0, 0.0, 0.0};
    ContactStatus status = normal > 0.0 ? ContactStatus::slip : ContactStatus::open;
    if (_options.friction > 0.0)
    {
      for (int c = 0; c < D; ++c)
        tangential[c] = f[c] - before * n[c] + more[c] - along * n[c];
      const double size = std::sqrt(dot(tangential, tangential, D)), limit = _options.friction * normal;
      if (size > limit)
        for (int c = 0; c < D; ++c)
          tangential[c] *= limit / size;
      else if (normal > 0.0)
        status = ContactStatus::stick;
    }
    _results.status[closed.i] = status;
    for (int c = 0; c < D; ++c)
      f[c] = normal * n[c] + tangential[c];
  }
}

/// What the forces move.
template <int D>
void KinematicContact::apply(const double* inverse_mass, double h)
{
  for (std::int32_t node : _touched)
    std::fill_n(_sum.data() + std::size_t(node) * D, D, 0.0);
  for (std::size_t q = 0; q < _num_closed; ++q)
  {
    const Closed& closed = _closed_now[q];
    const double *f = _nodal_force.data() + q * D, *phi = _phi.data() + q * _num_masters;
    for (int c = 0; c < D; ++c)
      _sum[std::size_t(closed.node) * D + c] += f[c];
    for_nodes(_num_masters,
              [&](int j)
              {
                for (int c = 0; c < D; ++c)
                  _sum[std::size_t(closed.masters[j]) * D + c] -= phi[j] * f[c];
              });
    if (turns())
      _corrections[q].forces<D>(_num_masters, _arms.data() + q * _num_masters * D, f, [&](int j, int c, double value)
                                { _sum[std::size_t(closed.masters[j]) * D + c] += value; });
  }
  if (!_rigid)
    _halo->reverse(_sum.data(), D);
  for (std::int32_t node : _touched)
    if (node < _halo->num_owned())
      for (int c = 0; c < D; ++c)
      {
        const std::size_t k = std::size_t(node) * D + c;
        _moved[k] = h * _sum[k] * inverse_mass[k];
      }
  if (!_rigid)
    _halo->forward(_moved.data(), D);
}

/// Results and work of the step: half with the motion before it, half with that of it.
template <int D>
void KinematicContact::record(double h, double dt)
{
  _force.fill(0.0);
  _energy.normal += _energy.later_normal;
  _energy.friction += _energy.later_friction;
  _energy.later_normal = _energy.later_friction = _energy.recoverable = 0.0;
  for (std::size_t q = 0; q < _num_closed; ++q)
  {
    const Closed& closed = _closed_now[q];
    const std::size_t i = closed.i;
    const double *n = closed.normal, *f = _nodal_force.data() + q * D, area = _candidates.areas()[i];
    double moved[3], before[3], slip[3];
    relative<D>(q, _moved.data(), moved);
    relative<D>(q, _before.data(), before);
    _results.gap[i] = dot(n, moved, D) - closed.overlap;
    std::copy_n(n, D, _results.normal.data() + i * D);
    const double normal = dot(n, f, D);
    for (int c = 0; c < D; ++c)
    {
      moved[c] += _motion[q * D + c];
      before[c] -= _rigid ? _obstacle_before[c] : 0.0;
      _force[c] += f[c];
      _results.traction[i * D + c] = f[c] / area;
      _tangential[i * D + c] = f[c] - normal * n[c];
    }
    _results.pressure[i] = normal / area;
    for (int c = 0; c < D; ++c)
      slip[c] = moved[c] - dot(n, moved, D) * n[c];
    const double along = 0.5 * normal * dot(n, before, D), along_later = 0.5 * normal * dot(n, moved, D);
    double work = along, later = along_later;
    if (turns())
      _corrections[q].forces<D>(_num_masters, _arms.data() + q * _num_masters * D, f,
                                [&](int j, int c, double value)
                                {
                                  const std::size_t k = std::size_t(closed.masters[j]) * D + c;
                                  const double du = _tracker.masters()[closed.corners[j]].du[c];
                                  work += 0.5 * value * _before[k];
                                  later += 0.5 * value * (du + _moved[k]);
                                });
    _energy.normal += work;
    _energy.friction -= 0.5 * dot(f, before, D) - along;
    _energy.later_normal += later;
    _energy.later_friction -= 0.5 * dot(f, moved, D) - along_later;
    _taken[i] = closed.releases ? 0.0 : _taken[i] - work - later;
    _energy.recoverable += std::max(0.0, _taken[i]);
    _pulse[i] = closed.releases ? 0.0 : fading * _pulse[i] + normal * h / dt;
    if (_options.friction > 0.0 && _results.status[i] == ContactStatus::slip)
      for (int c = 0; c < D; ++c)
        _results.slip[i * D + c] += slip[c];
    _closed[i] = 1;
    if (_results.status[i] == ContactStatus::open)
      std::fill_n(_results.slip.data() + i * D, D, 0.0);
  }
  _obstacle_before = _obstacle_increment;
}

template <int D>
void KinematicContact::correct_all(const PredictedStep& step, double* u, double* f)
{
  predict<D>(step, u);
  add_masses<D>(step.inverse_mass);
  release<D>(step);
  for (int sweep = 0; sweep < _sweeps; ++sweep)
  {
    solve_forces<D>(step.h, sweep % 2 ? over_relaxed : 1.0);
    apply<D>(step.inverse_mass, step.h);
  }
  for (std::int32_t node : _touched)
    if (node < _halo->num_owned())
      for (int c = 0; c < D; ++c)
      {
        const std::size_t k = std::size_t(node) * D + c;
        u[k] += _moved[k];
        f[k] += _sum[k];
      }
  _halo->forward(u, D);
  record<D>(step.h, step.dt);
}

void KinematicContact::correct(const PredictedStep& step, double* u, double* f)
{
  if (!_rigid)
  {
    _candidates.advance(step.dt);
    _tracker.advance(u, step.du);
  }
  _gdim == 2 ? correct_all<2>(step, u, f) : correct_all<3>(step, u, f);
}
} // namespace dolfinx_impact::enforcement
