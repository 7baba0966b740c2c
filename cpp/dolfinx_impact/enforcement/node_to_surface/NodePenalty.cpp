// SPDX-License-Identifier: MIT
#include "NodePenalty.h"
#include "../../common/gather.h"
#include "MomentCorrection.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Names and members of a spring.
constexpr std::array<std::pair<const char*, double Spring::*>, 6> spring_members{
    {{"spring_force", &Spring::force},
     {"spring_compliance", &Spring::compliance},
     {"spring_gap", &Spring::gap},
     {"spring_surplus", &Spring::surplus},
     {"spring_tangential_surplus", &Spring::tangential_surplus},
     {"spring_offset", &Spring::offset}}};

/// Largest stiffness of a node times dt^2 over its mass: what a step of 0.9 of the stable one leaves of the square of
/// the highest frequency, 1/0.9^2 - 1, times the 4 of the stable step itself.
constexpr double most = 4.0 * 0.19 / 0.81;

NodePenaltyOptions checked(const NodePenaltyOptions& o)
{
  if (!std::isfinite(o.penalty) || !(o.penalty >= 0.0))
    throw std::invalid_argument("the penalty of a contact is finite and not negative");
  if (!(o.kappa > 0.0) || !std::isfinite(o.kappa))
    throw std::invalid_argument("kappa is " + std::to_string(o.kappa) + ", it must be positive");
  if (!(o.share > 0.0) || !(o.share <= 1.0))
    throw std::invalid_argument("the share of a contact's stiffness is " + std::to_string(o.share) +
                                ", it must be positive and at most one");
  return o;
}
} // namespace

NodePenalty::NodePenalty(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets& master,
                         const NodePenaltyOptions& options)
    : NodePenalty(V, slave, &master, nullptr, options)
{
}

NodePenalty::NodePenalty(const surface::FunctionSpace& V, const surface::Facets& slave, const gap::Rigid& master,
                         const NodePenaltyOptions& options)
    : NodePenalty(V, slave, nullptr, &master, options)
{
}

NodePenalty::NodePenalty(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master,
                         const gap::Rigid* rigid, const NodePenaltyOptions& options)
    : NodeToSurface(V, slave, master, rigid, checked(options)), _penalty(options.penalty), _kappa(options.kappa),
      _share(options.share), _by_step(options.by_step), _springs(num_nodes())
{
  for (std::size_t i = 0; i < num_nodes(); ++i)
    _springs[i].per_area = _per_area[i];
}

std::span<const std::int32_t> NodePenalty::required_nodes(operators::Halo& all)
{
  if (!_known.master.empty())
  {
    _all_known.assign(all.num_nodes(), 0.0);
    std::copy(_known.master.begin(), _known.master.end(), _all_known.begin());
    all.forward(_all_known, 1);
  }
  return NodeToSurface::required_nodes(all);
}

void NodePenalty::assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                                 std::span<const double> mass)
{
  NodeToSurface::assign_numbers(halo, numbers, mass);
  const auto masters = _tracker.master_nodes();
  _master_forces.resize(masters.size());
  if (!_all_known.empty())
  {
    std::vector<double> known(halo.num_nodes(), 0.0);
    for (std::size_t node = 0; node < numbers.size(); ++node)
      if (numbers[node] >= 0)
        known[numbers[node]] = _all_known[node];
    _master_here.clear();
    for (std::int32_t master : masters)
      _master_here.push_back(known[master]);
  }
  _compliance_step = 0.0;
}

void NodePenalty::set_nodal_compliances(NodalCompliances compliances)
{
  for (const std::vector<double>* values : {&compliances.slave, &compliances.master})
  {
    if (values->size() != _candidates.num_owned())
      throw std::invalid_argument("nodal compliances: " + std::to_string(_candidates.num_owned()) +
                                  " values are needed, not " + std::to_string(values->size()));
    for (double value : *values)
      if (!std::isfinite(value) || value < 0.0)
        throw std::invalid_argument("a nodal compliance is " + std::to_string(value) + ", it must not be negative");
  }
  _known = std::move(compliances);
  _compliance_step = 0.0;
}

double NodePenalty::added_square_frequency(std::span<const double> mass) const
{
  return _penalty > 0.0 ? per_mass(_share * _penalty, mass) : 0.0;
}

void NodePenalty::add_to(state::State& saved) const
{
  for (const auto& [name, member] : spring_members)
  {
    std::vector<double> column(num_nodes());
    std::ranges::transform(_springs, column.begin(), [member](const NodeSpring& spring) { return spring.*member; });
    saved.add_own(name, state::Place::node, std::move(column));
  }
}

void NodePenalty::resume_nodes(const state::State& saved)
{
  for (const auto& [name, member] : spring_members)
  {
    const auto column = saved.values<double>(name);
    for (std::size_t i = 0; i < num_nodes(); ++i)
      _springs[i].*member = column[i];
  }
}

std::vector<double> NodePenalty::stiffness() const
{
  std::vector<double> out(num_nodes(), 0.0);
  for (std::size_t i = 0; i < num_nodes(); ++i)
    if (_closed[i] == 1)
      out[i] = 1.0 / _springs[i].compliance;
  return out;
}

double NodePenalty::deepest_penetration() const
{
  double deepest = 0.0;
  for (std::size_t i = 0; i < num_nodes(); ++i)
    if (_closed[i] == 1)
      deepest = std::max(deepest, -_springs[i].gap);
  return deepest;
}

/// The stored energy of a node that opens without leaving through the surface is dissipated.
void NodePenalty::drop_stored_energy(std::size_t i)
{
  Spring& spring = _springs[i];
  double squared = 0.0;
  for (int c = 0; c < _gdim; ++c)
    squared += _tangential[i * _gdim + c] * _tangential[i * _gdim + c];
  if (spring.force > 0.0) // nodes that have borne nothing yet keep it
    spring.offset = 0.0;
  _energy.normal -= normal_release(spring, 0.0);
  _energy.friction += tangential_release(spring, 0.5 * squared * spring.compliance);
}

/// Compliance of a node: the known one, but no less than a step can bear; from mass and step if none is known.
inline double NodePenalty::node_compliance(double known, double inverse_mass, double dt) const
{
  const double per_step = dt * dt * inverse_mass;
  return known > 0.0 ? std::max(known, per_step / most) : per_step / _kappa;
}

void NodePenalty::update_compliances(double dt)
{
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    const double known = _known.slave.empty() ? 0.0 : _known.slave[std::size_t(_candidates.nodes()[i])];
    _springs[i].node_compliance = node_compliance(known, _inverse_mass[i], dt);
  }
  for (std::size_t k = 0; k < _master_inverse_mass.size(); ++k)
  {
    search::MasterNode& master = _tracker.masters()[k];
    master.compliance = node_compliance(_master_here.empty() ? 0.0 : _master_here[k], _master_inverse_mass[k], dt);
    master.area_compliance = _master_areas[k] * master.compliance;
  }
  _compliance_step = dt;
}

/// Opens the spring of a node that leaves through the surface. Half of the last force's work is done in this step.
/// @param[in] motion increment of the node relative to the master [L]
template <int D>
void NodePenalty::open_spring(std::size_t i, const double* n, double change, const double* motion)
{
  Spring& spring = _springs[i];
  double* t = _tangential.data() + i * D;
  _energy.normal -= normal_release(spring, change);
  double along = 0.0, squared = 0.0, left = 0.0, work = 0.0;
  for (int c = 0; c < D; ++c)
    along += n[c] * t[c];
  for (int c = 0; c < D; ++c)
  {
    const double turned = t[c] - along * n[c];
    squared += t[c] * t[c];
    left += turned * turned;
    work += turned * motion[c];
    t[c] = 0.0;
  }
  work *= left > 0.0 ? std::sqrt(squared / left) : 0.0; // the force keeps its size when the normal turns
  _energy.friction += tangential_release(spring, 0.5 * squared * spring.compliance - 0.5 * work);
}

/// Puts a node near the master into the batch.
template <int D>
void NodePenalty::add_node(const ContactPoint& point, const NodalState& state)
{
  SpringBatch& b = _batch;
  const int l = b.num++;
  const std::size_t i = point.i;
  const search::Projection& at = point.at;
  // Without friction the force is along the gap but beside the rim, and where sum phi_j x_j is not on the facet.
  const bool oblique = at.rim != search::Projection::Rim::no ||
                       (!_rigid && _tracker.master().geometry.degree != _tracker.master().displacement.degree);
  const bool turns = b.corrects_moments && (b.friction > 0.0 || oblique);
  double place[D], motion[D];
  if (_rigid)
    position(i, state.u.data(), place);
  const double* const x = _rigid ? place : _tracker.x(i);
  for (int c = 0; c < D; ++c)
    motion[c] = state.du[std::size_t(point.node) * D + c];
  // A rigid body that gives way: docs/rigid_bodies.md, "Stable step".
  const NodeSpring& spring = _springs[i];
  const double body = _mobility > 0.0 ? _compliance_step * _compliance_step * _mobility * spring.per_area / most : 0.0;
  if (_rigid)
  {
    double increment[D];
    obstacle_increment(x, increment);
    for (int c = 0; c < D; ++c)
      motion[c] -= increment[c];
  }
  _master_forces.prefetch(point.num, point.corners);
  for_nodes(point.num,
            [&](int j)
            {
              b.phi[j][l] = point.phi[j];
              b.corners[j][l] = point.corners[j];
            });
  for (int c = 0; c < D; ++c)
  {
    b.normal[c][l] = at.normal[c];
    b.motion[c][l] = motion[c];
    if (turns)
      b.x[c][l] = x[c];
    if (b.friction > 0.0)
      b.tangential[c][l] = _tangential[i * D + c];
  }
  b.set_spring(l, spring);
  b.gap[l] = at.gap + spring.offset;
  b.beside[l] = at.rim == search::Projection::Rim::beside;
  b.begins[l] = _closed[i] != 1;
  b.oblique[l] = oblique;
  b.per_area[l] = spring.per_area;
  b.compliance[l] = spring.node_compliance + body;
  b.area_compliance[l] = 0.0;
}

/// Adds the contact forces of the nodes of the batch, which is empty then.
template <int D>
void NodePenalty::add_batch(const NodalState& state, std::span<double> f)
{
  if (_batch.num == 0)
    return;
  if (!_rigid)
    read_masters(_batch, _tracker.masters());
  evaluate(_batch);
  for (int l = 0; l < _batch.num; ++l)
    add_force<D>(_points[l], l, state, f);
  if (!_rigid)
    add_reactions(_batch, _master_forces.data());
  _batch.num = 0;
}

/// Adds the contact force of lane l, or opens its node.
template <int D>
void NodePenalty::add_force(const ContactPoint& point, int l, const NodalState& state, std::span<double> f)
{
  const SpringBatch& b = _batch;
  const std::size_t i = point.i;
  const search::Projection& at = point.at;
  NodeSpring& spring = _springs[i];
  if (!(b.overlap[l] > 0.0))
  {
    double motion[D];
    for (int c = 0; c < D; ++c)
      motion[c] = b.motion[c][l];
    if (b.begins[l] == 0.0)
      open_spring<D>(i, at.normal, b.change[l], motion);
    // A node that is open only by its offset would close again in the next step, with a force from nowhere.
    if (at.gap > 0.0)
      spring.offset = 0.0;
    return open(i, at, state.u.data());
  }
  if (!_rigid)
    _tracker.track(i, at);
  const double offset = spring.offset, per_area = spring.per_area;
  static_cast<Spring&>(spring) = b.spring(l);
  spring.offset = offset;
  _energy.normal -= b.normal_loss[l];
  double force[D];
  for (int c = 0; c < D; ++c)
    force[c] = b.total[c][l];
  ContactStatus status = ContactStatus::slip;
  if (_options.friction > 0.0)
  {
    _energy.friction += b.friction_loss[l];
    for (int c = 0; c < D; ++c)
    {
      _tangential[i * D + c] = b.tangential[c][l];
      _results.slip[i * D + c] += b.slip[c][l];
    }
    if (b.sticks[l] > 0.0)
      status = ContactStatus::stick;
  }
  for (int c = 0; c < D; ++c)
  {
    f[std::size_t(point.node) * D + c] += force[c];
    _results.traction[i * D + c] = force[c] * per_area;
    // Not `force`: a register that is filled from parts just stored would wait for them.
    _force[c] += b.total[c][l];
  }
  add_to_moments(i, state.u.data(), force);
  _closed[i] = 1;
  _results.status[i] = status;
  _results.gap[i] = at.gap;
  _results.pressure[i] = spring.force * per_area;
  _energy.stored += b.stored[l];
}

template <int D>
void NodePenalty::add_all(const NodalState& state, std::span<double> f)
{
  SpringBatch& b = _batch;
  b.gdim = D;
  b.num_masters = _rigid ? 0 : _tracker.master().displacement.num_nodes();
  b.friction = _options.friction;
  b.given = _penalty > 0.0 ? _share * _penalty : 0.0;
  b.share = _share;
  b.corrects_moments = corrects_moments();
  // No gap changes by more than this in a step.
  const double reach = _rigid ? std::numeric_limits<double>::infinity() : 0.5 * _tracker.step();
  for (std::size_t i = 0; i < _candidates.nodes().size(); ++i)
  {
    ContactPoint& point = _points[b.num];
    if ((!_rigid && _closed[i] != 1 && _tracker.skipped(i)) || // a closed node is active
        !find_contact(i, state.u.data(), state.du.data(), reach, true, point))
      continue;
    add_node<D>(point, state);
    if (b.num == SpringBatch::size)
      add_batch<D>(state, f);
  }
  add_batch<D>(state, f);
  _master_forces.add_to(_tracker.master_nodes(), D, f);
}

void NodePenalty::add_forces(const NodalState& state, std::span<double> f)
{
  _force.fill(0.0);
  _force_moment.fill(0.0);
  _energy.stored = 0.0;
  if (state.dt != _compliance_step)
    update_compliances(state.dt);
  if (!_rigid)
  {
    _candidates.advance(state.dt);
    _tracker.advance(state.u.data(), state.du.data());
  }
  _gdim == 2 ? add_all<2>(state, f) : add_all<3>(state, f);
}

NodalSprings NodePenalty::springs_at(std::span<const double> displacements)
{
  const double* u = displacements.data();
  if (!(_penalty > 0.0))
    throw std::invalid_argument("springs without a given penalty depend on the step");
  const surface::FacetElement& element = _tracker.master().displacement;
  NodalSprings out;
  out.num_masters = _rigid ? 0 : element.num_nodes();
  const std::vector<double> still(_rigid ? 0 : std::size_t(_halo->num_nodes()) * _gdim, 0.0);
  if (!_rigid)
    _tracker.advance(u, still.data());
  for (std::size_t i = 0; i < _candidates.nodes().size(); ++i)
  {
    const search::Projection at = _rigid ? rigid_point(i, u) : _tracker.locate(i, u, still.data());
    if (!std::isfinite(at.gap))
      continue;
    out.nodes.push_back(_candidates.numbers()[i]);
    out.stiffness.push_back(_share * _penalty * _candidates.areas()[i]);
    out.normal.insert(out.normal.end(), at.normal, at.normal + _gdim);
    if (_rigid)
      continue;
    double phi[surface::FacetElement::max_nodes];
    element.values(at.xi, phi);
    const std::int32_t* masters = _tracker.master().nodes_of(at.facet);
    out.masters.insert(out.masters.end(), masters, masters + out.num_masters);
    out.phi.insert(out.phi.end(), phi, phi + out.num_masters);
  }
  return out;
}
} // namespace dolfinx_impact::enforcement
