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
constexpr double negligible = 1e-9;    ///< a mass ratio below this means that the node cannot move along the normal
constexpr double impulse_decay = 0.95; ///< factor per step on the impulse that bounds a release

KinematicContactOptions checked(const KinematicContactOptions& o)
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
  _absorbed_energy.assign(n, 0.0);
  _impulse.assign(n, 0.0);
  _closed_now.resize(n);
  _phi.resize(n * _num_masters);
  for (std::vector<double>* a : {&_motion, &_turn, &_nodal_force})
    a->assign(vector, 0.0);
  _moment_corrections.resize(n);
  _arms.resize(vector * _num_masters);
  _corrections.resize(vector * _num_masters);
  _normal_mass.assign(n, 0.0);
  _isotropic_mass.assign(n, 0.0);
  _coefficients.value.assign(n, options.friction);
  if (!options.friction_law)
    return;
  if (options.friction_law->gdim() != _gdim)
    throw std::invalid_argument("the law of friction is one of another dimension");
  _friction_points = options.friction_law->make_points(n);
  _fields = FieldsAtNodes(options.friction_law->fields());
}

void KinematicContact::add_to(state::State& saved) const
{
  saved.add_own("absorbed_energy", state::Place::node, _absorbed_energy);
  saved.add_own("impulse", state::Place::node, _impulse);
  if (_options.friction_law) // the first coefficients of a step are those of the pressure of the last one
    saved.add_own("friction_pressure", state::Place::node, _results.pressure);
}

void KinematicContact::resume_nodes(const state::State& saved)
{
  std::ranges::copy(saved.values<double>("absorbed_energy"), _absorbed_energy.begin());
  std::ranges::copy(saved.values<double>("impulse"), _impulse.begin());
  if (_options.friction_law)
    std::ranges::copy(saved.values<double>("friction_pressure"), _results.pressure.begin());
}

void KinematicContact::assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                                      std::span<const double> mass)
{
  NodeToSurface::assign_numbers(halo, numbers, mass);
  _fields.assign_numbers(halo, numbers, _candidates.num_owned());
  _contact_nodes.assign(_candidates.watched_numbers().begin(), _candidates.watched_numbers().end());
  _contact_nodes.insert(_contact_nodes.end(), _tracker.master().nodes.begin(), _tracker.master().nodes.end());
  std::sort(_contact_nodes.begin(), _contact_nodes.end());
  _contact_nodes.erase(std::unique(_contact_nodes.begin(), _contact_nodes.end()), _contact_nodes.end());
}

/// Value at closed node q minus the value interpolated at its projection on the master.
template <int D>
inline void KinematicContact::relative_to_master(std::size_t q, const double* values, double* out) const
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

template <int D>
void KinematicContact::find_closed(const PredictedStep& step, const double* u)
{
  const double* du = step.du.data();
  _num_closed = 0;
  ContactPoint point;
  for (std::size_t i = 0; i < _candidates.nodes().size(); ++i)
  {
    if (!_rigid && _closed[i] != 1 && _tracker.skipped(i)) // a closed node is active
      continue;
    const bool may_release = _absorbed_energy[i] > 0.0; // positive only for nodes that were closed in the last step
    if (!find_contact(i, u, du, may_release ? std::numeric_limits<double>::infinity() : 0.0, false, point))
    {
      _absorbed_energy[i] = _impulse[i] = 0.0;
      continue;
    }
    const bool releases = !(point.at.gap < 0.0);
    if (releases && point.at.rim == search::Projection::Rim::beside)
    {
      open(i, point.at, u);
      _absorbed_energy[i] = _impulse[i] = 0.0;
      continue;
    }
    const std::size_t q = _num_closed++;
    Closed& closed = _closed_now[q];
    closed = {point.masters, point.corners, {}, -point.at.gap, std::uint32_t(i), point.node, releases};
    std::copy_n(point.at.normal, 3, closed.normal);
    // Forces act at t_n, along the facet's normal then: the predicted facet is tilted by the lack of these very forces.
    if (!_rigid && point.at.on_facet())
      _tracker.normal_before(point.at, u, du, closed.normal);
    for_nodes(_num_masters, [&](int j) { _phi[q * _num_masters + j] = point.phi[j]; });
    if (!_rigid)
      _tracker.track(i, point.at);
    if (corrects_moments())
    {
      double x[D];
      for (int c = 0; c < D; ++c)
      {
        const std::size_t k = std::size_t(point.node) * D + c;
        x[c] = _candidates.X()[i * D + c] + (u[k] - du[k]);
      }
      const auto at = [&](int j, int c)
      {
        const search::MasterNode& master = _tracker.masters()[point.corners[j]];
        return master.x[c] - master.du[c];
      };
      _moment_corrections[q].set<D>(_num_masters, at, point.phi, x, _arms.data() + q * _num_masters * D);
    }
    // As relative_to_master, from what the tracker has of the master's nodes: the projection has just read it.
    double* motion = _motion.data() + q * D;
    for (int c = 0; c < D; ++c)
      motion[c] = du[std::size_t(point.node) * D + c] - (_rigid ? _obstacle_motion.increment[c] : 0.0);
    for_nodes(_num_masters,
              [&](int j)
              {
                for (int c = 0; c < D; ++c)
                  motion[c] -= point.phi[j] * _tracker.masters()[point.corners[j]].du[c];
              });
    // A node that sticks at a distance, within layers of the surfaces, turns with the facet: that is no slip.
    double* turn = _turn.data() + q * D;
    std::fill_n(turn, D, 0.0);
    if (corrects_moments() && _options.has_friction())
      _moment_corrections[q].add_rotation<D>(
          _num_masters, _arms.data() + q * _num_masters * D,
          [&](int j, int c) { return _tracker.masters()[point.corners[j]].du[c]; }, turn);
  }
  std::fill_n(_nodal_force.data(), _num_closed * D, 0.0);
}

void KinematicContact::predict(const PredictedStep& step, std::span<const double> u)
{
  _fields.gather(*_halo);
  if (!_rigid)
  {
    _candidates.advance(step.dt);
    _tracker.advance(u.data(), step.du.data());
  }
  _gdim == 2 ? find_closed<2>(step, u.data()) : find_closed<3>(step, u.data());
}

/// Forces on the master nodes of closed node q that balance a unit normal force on it, [j*D + c].
template <int D>
void KinematicContact::reaction(std::size_t q, double* out) const
{
  const double* n = _closed_now[q].normal;
  for (int j = 0; j < _num_masters; ++j)
    for (int c = 0; c < D; ++c)
      out[j * D + c] = -_phi[q * _num_masters + j] * n[c];
  if (corrects_moments())
    _moment_corrections[q].forces<D>(_num_masters, _arms.data() + q * _num_masters * D, n,
                                     [&](int j, int c, double value) { out[j * D + c] += value; });
}

template <int D>
void KinematicContact::weigh(CorrectedNodes& nodes) const
{
  for (std::size_t q = 0; q < _num_closed; ++q)
  {
    const Closed& closed = _closed_now[q];
    const double* n = closed.normal;
    // With friction, forces act in all directions; without, along the normal.
    const auto add = [&](std::size_t node, double part)
    {
      nodes.weight[node] += part;
      if (nodes.largest.empty() || !nodes.shared[node])
        return;
      int entry = 0;
      for (int c = 0; c < D; ++c)
        for (int d = 0; d <= c; ++d, ++entry)
          nodes.tensor[entry / 3][3 * node + entry % 3] +=
              part * (_options.has_friction() ? double(c == d) : n[c] * n[d]);
    };
    add(closed.node, 1.0);
    if (closed.releases)
    {
      double pushed[surface::FacetElement::max_nodes * D];
      reaction<D>(q, pushed);
      for (int j = 0; j < _num_masters; ++j)
        add(closed.masters[j], std::sqrt(dot(pushed + j * D, pushed + j * D, D)));
    }
    else
      for (int j = 0; j < _num_masters; ++j)
        add(closed.masters[j], std::abs(_phi[q * _num_masters + j]));
  }
}

void KinematicContact::add_weights(CorrectedNodes& nodes) const
{
  _gdim == 2 ? weigh<2>(nodes) : weigh<3>(nodes);
}

/// Effective masses of a sweep: reciprocals of row sums of the response matrix, along the normal and in all directions.
template <int D>
void KinematicContact::set_masses(const double* inverse_mass, const std::vector<double>& weight)
{
  for (std::size_t q = 0; q < _num_closed; ++q)
  {
    const Closed& closed = _closed_now[q];
    const double* phi = _phi.data() + q * _num_masters;
    double w[D], along = 0.0, across = 0.0;
    for (int c = 0; c < D; ++c)
      w[c] = weight[closed.node] * inverse_mass[std::size_t(closed.node) * D + c];
    for_nodes(_num_masters,
              [&](int j)
              {
                const std::size_t node = closed.masters[j];
                for (int c = 0; c < D; ++c)
                  w[c] += std::abs(phi[j]) * weight[node] * inverse_mass[node * D + c];
              });
    const double* n = closed.normal;
    for (int c = 0; c < D; ++c)
    {
      along += n[c] * n[c] * w[c];
      across = std::max(across, w[c]);
    }
    _normal_mass[q] = along > negligible * across ? 1.0 / along : 0.0;
    _isotropic_mass[q] = across > 0.0 ? 1.0 / across : 0.0;
  }
}

/// Normal forces of the nodes that open: each force returns at most the energy that contact has absorbed from the node
/// since it closed, and its impulse is bounded by that of the last steps (docs/explicit/kinematic.md, "Release").
template <int D>
void KinematicContact::solve_release_forces(const PredictedStep& step, const CorrectedNodes& nodes)
{
  const double *du = step.du.data(), *inverse_mass = step.inverse_mass.data(), h = step.h, dt = step.dt;
  for (std::size_t q = 0; q < _num_closed; ++q)
  {
    const Closed& closed = _closed_now[q];
    if (!closed.releases)
      continue;
    const double* n = closed.normal;
    double before[3], pushed[surface::FacetElement::max_nodes * D];
    relative_to_master<D>(q, nodes.before.data(), before);
    // Work of a unit force on the predicted motion, and the displacement (times 2/h) that the unit force adds.
    double way = 0.0, moves = 0.0;
    for (int c = 0; c < D; ++c)
    {
      way += 0.5 * n[c] * (before[c] - (_rigid ? _obstacle_before.increment[c] : 0.0) + _motion[q * D + c]);
      moves += n[c] * n[c] * nodes.weight[closed.node] * inverse_mass[std::size_t(closed.node) * D + c];
    }
    reaction<D>(q, pushed);
    for (int j = 0; j < _num_masters; ++j)
    {
      const std::size_t node = closed.masters[j];
      const double phi = _phi[q * _num_masters + j], size = std::sqrt(dot(pushed + j * D, pushed + j * D, D));
      for (int c = 0; c < D; ++c)
      {
        const double push = pushed[j * D + c], correction = push + phi * n[c];
        way += 0.5 * correction * (nodes.before[node * D + c] + du[node * D + c]);
        if (size > 0.0)
          moves += push * push / size * nodes.weight[node] * inverse_mass[node * D + c];
      }
    }
    const double taken = step.release_share * _absorbed_energy[closed.i], most = _impulse[closed.i] * dt / h;
    const double force =
        taken > 0.0 ? std::min(most, 2.0 * taken / (way + std::sqrt(way * way + 2.0 * h * moves * taken))) : 0.0;
    for (int c = 0; c < D; ++c)
      _nodal_force[q * D + c] = force * n[c];
  }
}

/// What the law of friction sees of the closed nodes: the slip velocity of the step before, as a coefficient that falls
/// with the present one would have several solutions; and the pressure, at first that of the last step.
template <int D>
void KinematicContact::begin_friction(const PredictedStep& step, const CorrectedNodes& nodes)
{
  _friction_points.resize(_num_closed);
  for (std::size_t q = 0; q < _num_closed; ++q)
  {
    const Closed& closed = _closed_now[q];
    const double* n = closed.normal;
    double before[D];
    relative_to_master<D>(q, nodes.before.data(), before);
    // The facet turns by about as much in this step as in the one before.
    for (int c = 0; c < D; ++c)
      before[c] += _turn[q * D + c] - (_rigid ? _obstacle_before.increment[c] : 0.0);
    const double along = dot(n, before, D);
    for (int c = 0; c < D; ++c)
    {
      _friction_points.slip_rate[q * D + c] = (before[c] - along * n[c]) / step.dt;
      _friction_points.normal[q * D + c] = n[c];
    }
    _friction_points.pressure[q] = _results.pressure[closed.i];
    for (std::size_t f = 0; f < _fields.size(); ++f)
    {
      _friction_points.slave_fields[f][q] = _fields.at(f, closed.node);
      _friction_points.master_fields[f][q] = _fields.at(f, _num_masters, closed.masters, &_phi[q * _num_masters]);
    }
  }
  _options.friction_law->evaluate(_friction_points, _coefficients);
}

/// Coefficients at the forces of the last sweep.
void KinematicContact::update_friction()
{
  for (std::size_t q = 0; q < _num_closed; ++q)
    _friction_points.pressure[q] =
        dot(_closed_now[q].normal, &_nodal_force[q * _gdim], _gdim) / _candidates.areas()[_closed_now[q].i];
  _options.friction_law->evaluate(_friction_points, _coefficients);
}

void KinematicContact::begin(const PredictedStep& step, const CorrectedNodes& nodes)
{
  if (_options.friction_law)
    _gdim == 2 ? begin_friction<2>(step, nodes) : begin_friction<3>(step, nodes);
  const double* inverse_mass = step.inverse_mass.data();
  if (_gdim == 2)
  {
    set_masses<2>(inverse_mass, nodes.in_sweeps());
    solve_release_forces<2>(step, nodes);
  }
  else
  {
    set_masses<3>(inverse_mass, nodes.in_sweeps());
    solve_release_forces<3>(step, nodes);
  }
}

template <int D>
void KinematicContact::sweep(const double* correction, double h, double factor, bool first)
{
  for (std::size_t q = 0; q < _num_closed; ++q)
  {
    const Closed& closed = _closed_now[q];
    const double* n = closed.normal;
    double moved[3] = {0.0, 0.0, 0.0}, more[3] = {0.0, 0.0, 0.0}, *f = _nodal_force.data() + q * D;
    if (!first)
      relative_to_master<D>(q, correction, moved);
    const double pushed = closed.releases ? 0.0 : factor / h * _normal_mass[q] * (closed.overlap - dot(n, moved, D));
    if (_options.has_friction())
    {
      for (int c = 0; c < D; ++c)
        moved[c] += _motion[q * D + c] + _turn[q * D + c];
      const double away = dot(n, moved, D);
      for (int c = 0; c < D; ++c)
        more[c] = factor / h * _isotropic_mass[q] * (away * n[c] - moved[c]);
    }
    for (int c = 0; c < D; ++c)
      more[c] += pushed * n[c];
    const double along = dot(n, more, D), before = dot(n, f, D), normal = std::max(0.0, before + along);
    double tangential[3] = {0.0, 0.0, 0.0};
    ContactStatus status = normal > 0.0 ? ContactStatus::slip : ContactStatus::open;
    if (_options.has_friction())
    {
      for (int c = 0; c < D; ++c)
        tangential[c] = f[c] - before * n[c] + more[c] - along * n[c];
      const double size = std::sqrt(dot(tangential, tangential, D)), limit = _coefficients.value[q] * normal;
      // Without a branch: nodes slip and stick beside each other. Where a law returns no number, `part` is none: it is
      // seen in the motion, and ends the run.
      const double part = std::min(limit / std::max(size, std::numeric_limits<double>::min()), 1.0);
      for (int c = 0; c < D; ++c)
        tangential[c] *= part;
      if ((size <= limit) & (normal > 0.0))
        status = ContactStatus::stick;
    }
    _results.status[closed.i] = status;
    for (int c = 0; c < D; ++c)
      f[c] = normal * n[c] + tangential[c];
  }
}

void KinematicContact::solve_forces(const CorrectedNodes& nodes, double h, double factor, bool first)
{
  const double* correction = nodes.correction.data();
  _gdim == 2 ? sweep<2>(correction, h, factor, first) : sweep<3>(correction, h, factor, first);
  if (_options.friction_law && _options.friction_law->has_pressure())
    update_friction();
}

template <int D>
void KinematicContact::add_all(std::span<double> forces, bool last)
{
  double corrections[surface::FacetElement::max_nodes * D];
  for (std::size_t q = 0; q < _num_closed; ++q)
  {
    const Closed& closed = _closed_now[q];
    const double *f = _nodal_force.data() + q * D, *phi = _phi.data() + q * _num_masters;
    for (int c = 0; c < D; ++c)
      forces[std::size_t(closed.node) * D + c] += f[c];
    double* const more = last ? _corrections.data() + q * _num_masters * D : corrections;
    if (corrects_moments())
      _moment_corrections[q].forces<D>(_num_masters, _arms.data() + q * _num_masters * D, f,
                                       [&](int j, int c, double value) { more[j * D + c] = value; });
    else
      std::fill_n(more, _num_masters * D, 0.0);
    for_nodes(_num_masters,
              [&](int j)
              {
                double* to = forces.data() + std::size_t(closed.masters[j]) * D;
                for (int c = 0; c < D; ++c)
                  to[c] = to[c] - phi[j] * f[c] + more[j * D + c];
              });
  }
}

void KinematicContact::add_forces(std::span<double> forces, bool last)
{
  _gdim == 2 ? add_all<2>(forces, last) : add_all<3>(forces, last);
}

/// A force works half on the increment before it and half on the increment after it.
template <int D>
void KinematicContact::record_all(const CorrectedNodes& nodes, double h, double dt)
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
    relative_to_master<D>(q, nodes.correction.data(), moved);
    relative_to_master<D>(q, nodes.before.data(), before);
    _results.gap[i] = dot(n, moved, D) - closed.overlap;
    std::copy_n(n, D, _results.normal.data() + i * D);
    const double normal = dot(n, f, D);
    for (int c = 0; c < D; ++c)
    {
      moved[c] += _motion[q * D + c];
      before[c] -= _rigid ? _obstacle_before.increment[c] : 0.0;
      _force[c] += f[c];
      _results.traction[i * D + c] = f[c] / area;
      _tangential[i * D + c] = f[c] - normal * n[c];
    }
    _results.pressure[i] = normal / area;
    const double* turn = _turn.data() + q * D;
    for (int c = 0; c < D; ++c)
      slip[c] = moved[c] + turn[c] - (dot(n, moved, D) + dot(n, turn, D)) * n[c];
    const double along = 0.5 * normal * dot(n, before, D), along_later = 0.5 * normal * dot(n, moved, D);
    double work = along, later = along_later;
    if (corrects_moments())
      for_nodes(_num_masters,
                [&](int j)
                {
                  const double* const du = _tracker.masters()[closed.corners[j]].du;
                  const std::size_t node = std::size_t(closed.masters[j]) * D;
                  for (int c = 0; c < D; ++c)
                  {
                    const double value = _corrections[(q * _num_masters + j) * D + c];
                    work += 0.5 * value * nodes.before[node + c];
                    later += 0.5 * value * (du[c] + nodes.correction[node + c]);
                  }
                });
    _energy.normal += work;
    _energy.friction -= 0.5 * dot(f, before, D) - along;
    _energy.later_normal += later;
    _energy.later_friction -= 0.5 * dot(f, moved, D) - along_later;
    _absorbed_energy[i] = closed.releases ? 0.0 : _absorbed_energy[i] - work - later;
    _energy.recoverable += std::max(0.0, _absorbed_energy[i]);
    _impulse[i] = closed.releases ? 0.0 : impulse_decay * _impulse[i] + normal * h / dt;
    if (_options.has_friction() && _results.status[i] == ContactStatus::slip)
      for (int c = 0; c < D; ++c)
        _results.slip[i * D + c] += slip[c];
    _closed[i] = 1;
    if (_results.status[i] == ContactStatus::open)
      std::fill_n(_results.slip.data() + i * D, D, 0.0);
  }
  _obstacle_before = _obstacle_motion;
}

void KinematicContact::restore_obstacle(const gap::RigidMotion& motion)
{
  set_obstacle(motion);
  _obstacle_before = motion;
}

void KinematicContact::record(const CorrectedNodes& nodes, double h, double dt)
{
  _gdim == 2 ? record_all<2>(nodes, h, dt) : record_all<3>(nodes, h, dt);
}
} // namespace dolfinx_impact::enforcement
