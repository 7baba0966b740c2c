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
  const std::size_t n = num_nodes();
  _absorbed_energy.assign(n, 0.0);
  _impulse.assign(n, 0.0);
  _batches.resize((n + ClosedBatch::size - 1) / ClosedBatch::size);
  _rules = {_gdim, _num_masters, options.has_friction(), corrects_moments(), false};
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
  _rules.linear_facets = !_rigid && _tracker.has_linear_facets();
  _contact_nodes.assign(_candidates.watched_numbers().begin(), _candidates.watched_numbers().end());
  _contact_nodes.insert(_contact_nodes.end(), _tracker.master().nodes.begin(), _tracker.master().nodes.end());
  std::sort(_contact_nodes.begin(), _contact_nodes.end());
  _contact_nodes.erase(std::unique(_contact_nodes.begin(), _contact_nodes.end()), _contact_nodes.end());
}

/// Value at a closed node minus the value interpolated at its projection on the master.
/// @param[in] values padded as in CorrectedNodes
template <int D>
inline void KinematicContact::relative_to_master(const ClosedBatch& b, int l, const double* values, double* out) const
{
  constexpr int stride = CorrectedNodes::stride(D);
  for (int c = 0; c < D; ++c)
    out[c] = values[std::size_t(b.node[l]) * stride + c];
  for_nodes(_num_masters,
            [&](int j)
            {
              for (int c = 0; c < D; ++c)
                out[c] -= b.masters[j].phi[l] * values[std::size_t(b.masters[j].node[l]) * stride + c];
            });
}

/// Puts a node that receives a force into the batch, and completes the batch when it is full.
template <int D>
void KinematicContact::add_node(const ContactPoint& point, bool releases, const PredictedStep& step, const double* u)
{
  const double* du = step.du.data();
  const std::size_t q = _num_closed++, i = point.i, k = std::size_t(point.node) * D;
  ClosedBatch& b = batch(q);
  const int l = lane(q);
  b.num = l + 1;
  b.node[l] = point.node;
  b.slave[l] = std::int32_t(i);
  b.releases[l] = releases;
  b.overlap[l] = -point.at.gap;
  double normal[3];
  std::copy_n(point.at.normal, 3, normal);
  _input.along_facet[l] = 0.0;
  if (!_rigid)
  {
    // Forces act at t_n, along the facet's normal then: the predicted facet is tilted by the lack of these very forces.
    if (_rules.linear_facets)
    {
      _input.along_facet[l] = point.at.on_facet();
      _input.orientation[l] = _tracker.master().orientation[point.at.facet];
      for (int a = 0; a < 2; ++a)
        _input.xi[a][l] = point.at.xi[a];
    }
    else if (point.at.on_facet())
      _tracker.normal_before(point.at, u, du, normal);
    _tracker.track(i, point.at);
  }
  for (int c = 0; c < D; ++c)
  {
    b.normal[c][l] = normal[c];
    b.motion[c][l] = du[k + c] - (_rigid ? _obstacle_motion.increment[c] : 0.0);
    b.force[c][l] = 0.0;
    _input.x[c][l] = _rigid ? 0.0 : _tracker.x(i)[c] - du[k + c];
  }
  for_nodes(_num_masters,
            [&](int j)
            {
              b.masters[j].phi[l] = point.phi[j];
              b.masters[j].node[l] = point.masters[j];
              b.masters[j].corner[l] = point.corners[j];
            });
}

template <int D>
void KinematicContact::find_closed(const PredictedStep& step, const double* u)
{
  const double* du = step.du.data();
  _num_closed = 0;
  const auto complete = [this]
  {
    ClosedBatch& b = batch(_num_closed - 1);
    fill_lanes(_rules, b, _input);
    read_masters(_rules, b, _input, _rigid ? nullptr : _tracker.masters());
  };
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
    add_node<D>(point, releases, step, u);
    if (lane(_num_closed) == 0)
      complete();
  }
  if (lane(_num_closed) != 0)
    complete();
  if (!_options.friction_law)
    for_batches([this](ClosedBatch& b) { std::fill_n(b.friction, ClosedBatch::size, _options.friction); });
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

/// Forces on the master's nodes that balance a unit normal force on a closed node, [j*D + c].
template <int D>
void KinematicContact::reaction(const ClosedBatch& b, int l, double* out) const
{
  double n[D];
  for (int c = 0; c < D; ++c)
    n[c] = b.normal[c][l];
  for (int j = 0; j < _num_masters; ++j)
    for (int c = 0; c < D; ++c)
      out[j * D + c] = -b.masters[j].phi[l] * n[c];
  if (!corrects_moments())
    return;
  double arms[surface::FacetElement::max_nodes * D];
  const MomentCorrection moments = b.moments(_rules, l, arms);
  moments.forces<D>(_num_masters, arms, n, [&](int j, int c, double value) { out[j * D + c] += value; });
}

template <int D>
void KinematicContact::weigh(CorrectedNodes& nodes) const
{
  for_closed(
      [&](const ClosedBatch& b, int l, std::size_t)
      {
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
                  part * (_options.has_friction() ? double(c == d) : b.normal[c][l] * b.normal[d][l]);
        };
        add(b.node[l], 1.0);
        if (b.releases[l] > 0.0)
        {
          double pushed[surface::FacetElement::max_nodes * D];
          reaction<D>(b, l, pushed);
          for (int j = 0; j < _num_masters; ++j)
            add(b.masters[j].node[l], std::sqrt(dot(pushed + j * D, pushed + j * D, D)));
        }
        else
          for (int j = 0; j < _num_masters; ++j)
            add(b.masters[j].node[l], std::abs(b.masters[j].phi[l]));
      });
}

void KinematicContact::add_weights(CorrectedNodes& nodes) const
{
  _gdim == 2 ? weigh<2>(nodes) : weigh<3>(nodes);
}

/// Effective masses of a sweep: reciprocals of row sums of the response matrix, along the normal and in all directions.
template <int D>
void KinematicContact::set_masses(ClosedBatch& b, const double* inverse_mass, const std::vector<double>& weight)
{
  for (int l = 0; l < ClosedBatch::size; ++l)
  {
    double w[D], along = 0.0, across = 0.0;
    for (int c = 0; c < D; ++c)
      w[c] = weight[b.node[l]] * inverse_mass[std::size_t(b.node[l]) * D + c];
    for_nodes(_num_masters,
              [&](int j)
              {
                const std::size_t node = b.masters[j].node[l];
                const double part = std::abs(b.masters[j].phi[l]) * weight[node];
                for (int c = 0; c < D; ++c)
                  w[c] += part * inverse_mass[node * D + c];
              });
    for (int c = 0; c < D; ++c)
    {
      along += b.normal[c][l] * b.normal[c][l] * w[c];
      across = std::max(across, w[c]);
    }
    b.normal_mass[l] = along > negligible * across ? 1.0 / along : 0.0;
    b.isotropic_mass[l] = across > 0.0 ? 1.0 / across : 0.0;
  }
}

/// Normal forces of the nodes that open: each force returns at most the energy that contact has absorbed from the node
/// since it closed, and its impulse is bounded by that of the last steps (docs/explicit/kinematic.md, "Release").
template <int D>
void KinematicContact::solve_release_forces(ClosedBatch& b, const PredictedStep& step, const CorrectedNodes& nodes)
{
  constexpr int stride = CorrectedNodes::stride(D);
  const double *du = step.du.data(), *inverse_mass = step.inverse_mass.data(), h = step.h, dt = step.dt;
  for (int l = 0; l < b.num; ++l)
  {
    if (!(b.releases[l] > 0.0))
      continue;
    const std::size_t i = std::size_t(b.slave[l]);
    double n[D], before[D], pushed[surface::FacetElement::max_nodes * D];
    for (int c = 0; c < D; ++c)
      n[c] = b.normal[c][l];
    relative_to_master<D>(b, l, nodes.before.data(), before);
    // Work of a unit force on the predicted motion, and the displacement (times 2/h) that the unit force adds.
    double way = 0.0, moves = 0.0;
    for (int c = 0; c < D; ++c)
    {
      way += 0.5 * n[c] * (before[c] - (_rigid ? _obstacle_before.increment[c] : 0.0) + b.motion[c][l]);
      moves += n[c] * n[c] * nodes.weight[b.node[l]] * inverse_mass[std::size_t(b.node[l]) * D + c];
    }
    reaction<D>(b, l, pushed);
    for (int j = 0; j < _num_masters; ++j)
    {
      const std::size_t node = b.masters[j].node[l];
      const double phi = b.masters[j].phi[l], size = std::sqrt(dot(pushed + j * D, pushed + j * D, D));
      for (int c = 0; c < D; ++c)
      {
        const double push = pushed[j * D + c], correction = push + phi * n[c];
        way += 0.5 * correction * (nodes.before[node * stride + c] + du[node * D + c]);
        if (size > 0.0)
          moves += push * push / size * nodes.weight[node] * inverse_mass[node * D + c];
      }
    }
    const double taken = step.release_share * _absorbed_energy[i], most = _impulse[i] * dt / h;
    const double force =
        taken > 0.0 ? std::min(most, 2.0 * taken / (way + std::sqrt(way * way + 2.0 * h * moves * taken))) : 0.0;
    for (int c = 0; c < D; ++c)
      b.force[c][l] = force * n[c];
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
    const ClosedBatch& b = batch(q);
    const int l = lane(q);
    double n[D], before[D], phi[surface::FacetElement::max_nodes];
    std::int32_t masters[surface::FacetElement::max_nodes];
    for (int j = 0; j < _num_masters; ++j)
    {
      phi[j] = b.masters[j].phi[l];
      masters[j] = b.masters[j].node[l];
    }
    relative_to_master<D>(b, l, nodes.before.data(), before);
    // The facet turns by about as much in this step as in the one before.
    for (int c = 0; c < D; ++c)
    {
      n[c] = b.normal[c][l];
      before[c] += b.turn[c][l] - (_rigid ? _obstacle_before.increment[c] : 0.0);
    }
    const double along = dot(n, before, D);
    for (int c = 0; c < D; ++c)
    {
      _friction_points.slip_rate[q * D + c] = (before[c] - along * n[c]) / step.dt;
      _friction_points.normal[q * D + c] = n[c];
    }
    _friction_points.pressure[q] = _results.pressure[b.slave[l]];
    for (std::size_t f = 0; f < _fields.size(); ++f)
    {
      _friction_points.slave_fields[f][q] = _fields.at(f, b.node[l]);
      _friction_points.master_fields[f][q] = _fields.at(f, _num_masters, masters, phi);
    }
  }
  take_coefficients();
}

/// Coefficients at the forces of the last sweep.
void KinematicContact::update_friction()
{
  for (std::size_t q = 0; q < _num_closed; ++q)
  {
    const ClosedBatch& b = batch(q);
    const int l = lane(q);
    double along = 0.0;
    for (int c = 0; c < _gdim; ++c)
      along += b.normal[c][l] * b.force[c][l];
    _friction_points.pressure[q] = along / _candidates.areas()[b.slave[l]];
  }
  take_coefficients();
}

void KinematicContact::take_coefficients()
{
  _options.friction_law->evaluate(_friction_points, _coefficients);
  for (std::size_t q = 0; q < num_batches() * ClosedBatch::size; ++q)
    batch(q).friction[lane(q)] = _coefficients.value[std::min(q, _num_closed - 1)];
}

void KinematicContact::begin(const PredictedStep& step, const CorrectedNodes& nodes)
{
  if (_options.friction_law)
    _gdim == 2 ? begin_friction<2>(step, nodes) : begin_friction<3>(step, nodes);
}

template <int D>
void KinematicContact::sweep_all(const PredictedStep& step, CorrectedNodes& nodes, double factor, Sweep which)
{
  for_batches(
      [&](ClosedBatch& b)
      {
        if (which.first)
        {
          set_masses<D>(b, step.inverse_mass.data(), nodes.in_sweeps());
          solve_release_forces<D>(b, step, nodes);
        }
        enforcement::solve_forces(_rules, b, nodes.correction.data(), step.h, factor, which.first);
        enforcement::add_forces(_rules, b, nodes.force.data(), which.last);
      });
}

void KinematicContact::sweep(const PredictedStep& step, CorrectedNodes& nodes, double factor, Sweep which)
{
  _gdim == 2 ? sweep_all<2>(step, nodes, factor, which) : sweep_all<3>(step, nodes, factor, which);
  if (_options.friction_law && _options.friction_law->has_pressure())
    update_friction();
}

/// A force works half on the increment before it and half on the increment after it.
template <int D>
void KinematicContact::record_all(const CorrectedNodes& nodes, double h, double dt)
{
  _force.fill(0.0);
  _energy.normal += _energy.later_normal;
  _energy.friction += _energy.later_friction;
  _energy.later_normal = _energy.later_friction = _energy.recoverable = 0.0;
  const search::MasterNode* masters = _rigid ? nullptr : _tracker.masters();
  const std::array<double, 3> obstacle = _rigid ? _obstacle_before.increment : std::array<double, 3>{};
  const ClosedResult& r = _result;
  for_batches(
      [&](ClosedBatch& b)
      {
        measure(_rules, b, masters, nodes.correction.data(), nodes.before.data(), obstacle.data(), _result);
        for (int l = 0; l < b.num; ++l)
        {
          const std::size_t i = std::size_t(b.slave[l]);
          const double area = _candidates.areas()[i], normal = r.normal[l], work = r.work[l], later = r.later_work[l];
          const bool releases = b.releases[l] > 0.0;
          const ContactStatus status = b.sticks[l] > 0.0 ? ContactStatus::stick
                                       : normal > 0.0    ? ContactStatus::slip
                                                         : ContactStatus::open;
          _results.gap[i] = r.gap[l];
          _results.status[i] = status;
          _results.pressure[i] = normal / area;
          for (int c = 0; c < D; ++c)
          {
            _force[c] += b.force[c][l];
            _results.normal[i * D + c] = b.normal[c][l];
            _results.traction[i * D + c] = b.force[c][l] / area;
            _tangential[i * D + c] = r.tangential[c][l];
            double& slip = _results.slip[i * D + c];
            slip = status == ContactStatus::open                              ? 0.0
                   : _options.has_friction() && status == ContactStatus::slip ? slip + r.slip[c][l]
                                                                              : slip;
          }
          _energy.normal += work;
          _energy.friction -= r.friction_work[l];
          _energy.later_normal += later;
          _energy.later_friction -= r.later_friction_work[l];
          _absorbed_energy[i] = releases ? 0.0 : _absorbed_energy[i] - work - later;
          _energy.recoverable += std::max(0.0, _absorbed_energy[i]);
          _impulse[i] = releases ? 0.0 : impulse_decay * _impulse[i] + normal * h / dt;
          _closed[i] = 1;
        }
      });
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
