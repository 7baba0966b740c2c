// SPDX-License-Identifier: MIT
#include "NodeLaw.h"
#include "../../common/gather.h"
#include "../../common/vectors.h"
#include "../interface/tangential.h"
#include "MomentCorrection.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace dolfinx_impact::enforcement
{
namespace
{
const std::string of_variable = "variable ";

NodeToSurfaceOptions without_friction(const NodeToSurfaceOptions& options)
{
  if (options.has_friction())
    throw std::invalid_argument("a law of the interface has its own friction: the pair's must be zero");
  return options;
}

bool is_zero(const InterfaceDerivative& d, std::size_t p, int rows)
{
  const std::size_t size = std::size_t(rows) * d.size;
  return d.values.empty() ||
         std::all_of(d.values.begin() + p * size, d.values.begin() + (p + 1) * size, [](double x) { return x == 0.0; });
}
} // namespace

NodeLaw::NodeLaw(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets& master,
                 std::shared_ptr<const InterfaceLaw> law, const NodeToSurfaceOptions& options)
    : NodeLaw(V, slave, &master, nullptr, std::move(law), options)
{
}

NodeLaw::NodeLaw(const surface::FunctionSpace& V, const surface::Facets& slave, const gap::Rigid& master,
                 std::shared_ptr<const InterfaceLaw> law, const NodeToSurfaceOptions& options)
    : NodeLaw(V, slave, nullptr, &master, std::move(law), options)
{
}

NodeLaw::NodeLaw(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets* master,
                 const gap::Rigid* rigid, std::shared_ptr<const InterfaceLaw> law, const NodeToSurfaceOptions& options)
    : NodeToSurface(V, slave, master, rigid, without_friction(options)), _law(std::move(law))
{
  if (!_law || _law->gdim() != _gdim)
    throw std::invalid_argument("the law of the interface is one of another dimension");
  const std::size_t num = num_nodes();
  _history = _law->make_history(num);
  _points = _law->make_points(num);
  _found.reserve(num);
  _last.assign(num, {});
  _corrections.resize(num);
  _arms.resize(num * surface::FacetElement::max_nodes * _gdim);
  for (std::vector<double>* values : {&_last_pressure, &_last_stored, &_last_shear_stored})
    values->assign(num, 0.0);
  for (std::vector<double>* values : {&_last_shear, &_last_normal, &_last_motion, &_motion})
    values->assign(num * _gdim, 0.0);
  _fields = FieldsAtNodes(_law->fields());
}

void NodeLaw::assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers, std::span<const double> mass)
{
  NodeToSurface::assign_numbers(halo, numbers, mass);
  _master_forces.resize(_tracker.master_nodes().size());
  _fields.assign_numbers(halo, numbers, _candidates.num_owned());
  const surface::Facets& master = _tracker.master();
  for (LastForce& last : _last) // its numbers are those of before
  {
    const auto at = std::ranges::lower_bound(master.id, last.facet);
    if (last.facet >= 0 && at != master.id.end() && *at == last.facet)
      std::copy_n(master.nodes_of(at - master.id.begin()), master.displacement.num_nodes(), last.corners);
    else
      last.facet = -1;
  }
}

/// Nodes within the law's reach, and what it sees of them.
template <int D>
void NodeLaw::find_points(const NodalState& state)
{
  _found.clear();
  const double per_step = state.dt > 0.0 ? 1.0 / state.dt : 0.0;
  const search::MasterNode* masters = _tracker.masters();
  ContactPoint point;
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    if (!find_contact(i, state.u.data(), state.du.data(), _law->reach(), false, point))
      continue;
    const std::size_t p = _found.size();
    _found.push_back(point);
    if (p == _points.size()) // more nodes than in the step before
      _points.resize(num_nodes());
    const double* n = point.at.normal;
    double* motion = _motion.data() + p * D;
    double increment[D] = {};
    if (_rigid)
    {
      double x[D];
      position(i, state.u.data(), x);
      obstacle_increment(x, increment);
    }
    for (int c = 0; c < D; ++c)
      motion[c] = state.du[std::size_t(point.node) * D + c] - increment[c];
    for (int j = 0; j < point.num; ++j)
      for (int c = 0; c < D; ++c)
        motion[c] -= point.phi[j] * masters[point.corners[j]].du[c];
    if (corrects_moments())
    {
      double x[D], *arms = _arms.data() + p * surface::FacetElement::max_nodes * D;
      position(i, state.u.data(), x);
      MomentCorrection& correction = _corrections[p];
      correction.set<D>(point.num, [&](int j, int c) { return masters[point.corners[j]].x[c]; }, point.phi, x, arms);
      correction.add_rotation<D>(
          point.num, arms, [&](int j, int c) { return masters[point.corners[j]].du[c]; }, motion);
    }
    const double along = dot(n, motion, D);
    _points.row[p] = std::int32_t(i);
    _points.gap[p] = point.at.gap;
    _points.gap_rate[p] = per_step * along;
    double turned[D];
    turn(D, n, _results.slip.data() + i * D, turned);
    for (int c = 0; c < D; ++c)
    {
      const double slip = motion[c] - along * n[c];
      _points.normal[p * D + c] = n[c];
      _points.slip_rate[p * D + c] = per_step * slip;
      _points.slip[p * D + c] = turned[c] + slip;
    }
    for (InterfaceHistory::Variable& v : _history.variables)
      if (v.tangential)
        turn(D, n, v.committed.data() + i * D, v.turned.data() + i * D);
    for (std::size_t f = 0; f < _fields.size(); ++f)
    {
      _points.slave_fields[f][p] = _fields.at(f, point.node);
      _points.master_fields[f][p] = _fields.at(f, point.num, point.masters, point.phi);
    }
  }
  _points.resize(_found.size());
}

template <int D>
void NodeLaw::add_point(std::size_t p, const NodalState& state, std::span<double> f)
{
  const ContactPoint& point = _found[p];
  const std::size_t i = point.i;
  const double* n = point.at.normal;
  const double* motion = _motion.data() + p * D;
  const double area = _candidates.areas()[i], pressure = _tractions.pressure[p];
  // What the law returns along the normal does not count as shear.
  double shear[D], force[4] = {};
  const double out = dot(n, _tractions.shear.data() + p * D, D);
  bool acts = pressure != 0.0, tangential = false;
  for (int c = 0; c < D; ++c)
  {
    shear[c] = _tractions.shear[p * D + c] - out * n[c];
    tangential = tangential || shear[c] != 0.0;
    force[c] = area * (pressure * n[c] + shear[c]);
  }
  acts = acts || tangential || !is_zero(_tractions.by_gap, p, 1 + D) || !is_zero(_tractions.by_slip, p, 1 + D);
  // Work of the tractions by the trapezoidal rule, as the integrator counts it: the last ones act where they acted.
  const double along = dot(n, motion, D);
  double normal_work = 0.0, shear_work = 0.0;
  if (_begun)
  {
    const HalfWork before = last_work(i, motion);
    normal_work = before.normal - 0.5 * pressure * along;
    shear_work = before.shear;
    for (int c = 0; c < D; ++c)
      shear_work -= 0.5 * shear[c] * (motion[c] - along * n[c]);
  }
  const double shear_stored = _tractions.shear_energy.empty() ? 0.0 : _tractions.shear_energy[p];
  const double stored = _law->has_energy()
                            ? _tractions.energy[p]
                            : _last_stored[i] + normal_work +
                                  (_tractions.shear_energy.empty() ? shear_work : shear_stored - _last_shear_stored[i]);
  // What is stored where the run begins was not done by it.
  const double dissipated = _begun ? area * (normal_work + shear_work - (stored - _last_stored[i])) : 0.0;
  if (_law->has_shear())
    _energy.friction += dissipated;
  else
    _energy.normal -= dissipated;
  _energy.stored += area * stored;
  _last_stored[i] = stored;
  _last_shear_stored[i] = shear_stored;
  _last_pressure[i] = pressure;
  for (int c = 0; c < D; ++c)
  {
    _last_shear[i * D + c] = shear[c];
    _last_normal[i * D + c] = n[c];
    _last_motion[i * D + c] = motion[c];
    _results.slip[i * D + c] = _points.slip[p * D + c];
    _results.traction[i * D + c] = pressure * n[c] + shear[c];
    f[std::size_t(point.node) * D + c] += force[c];
  }
  for (int c = 0; c < _gdim; ++c)
    _force[c] += force[c];
  add_to_moments(i, state.u.data(), force);
  _master_forces.react<D>(point.num, point.corners, point.phi, force);
  LastForce& now = _last[i];
  now.facet = -1;
  if (!_rigid)
  {
    now.facet = _tracker.master().id[point.at.facet];
    std::copy_n(point.masters, point.num, now.corners);
    std::copy_n(point.phi, point.num, now.phi);
    std::fill_n(now.turn, point.num * D, 0.0);
    if (corrects_moments() && acts)
      _master_forces.correct<D>(_corrections[p], point.num, point.corners,
                                _arms.data() + p * surface::FacetElement::max_nodes * D, force, now.turn);
  }
  _closed[i] = point.at.gap < 0.0;
  if (!_rigid && _closed[i])
    _tracker.track(i, point.at);
  else if (!_rigid) // the search ends for nodes above the surface, also where the law reaches farther
  {
    search::Projection near = point.at;
    near.clearance = 0.0; // all nodes are active in the next step
    _tracker.release(i, near, state.u.data());
  }
  const bool sticks = _tractions.sticks.empty() ? _law->has_shear() : _tractions.sticks[p] > 0.5;
  _results.status[i] = !acts ? ContactStatus::open : sticks ? ContactStatus::stick : ContactStatus::slip;
  _results.gap[i] = point.at.gap;
  _results.pressure[i] = pressure;
}

template <int D>
void NodeLaw::add_all(const NodalState& state, std::span<double> f)
{
  find_points<D>(state);
  for (InterfaceHistory::Variable& v : _history.variables)
    std::ranges::copy(v.committed, v.updated.begin()); // nodes out of reach keep theirs
  _law->evaluate(_points, _history, _tractions);
  for (std::size_t p = 0; p < _found.size(); ++p)
    add_point<D>(p, state, f);
  for (InterfaceHistory::Variable& v : _history.variables)
    std::ranges::copy(v.updated, v.committed.begin());
  _begun = true;
  _master_forces.add_to(_tracker.master_nodes(), D, f);
}

void NodeLaw::add_forces(const NodalState& state, std::span<double> f)
{
  _force.fill(0.0);
  _force_moment.fill(0.0);
  _energy.stored = 0.0;
  if (!_rigid)
  {
    _candidates.advance(state.dt);
    _tracker.advance(state.u.data(), state.du.data());
    _tracker.activate_all(); // the law may act at a gap
  }
  _fields.gather(*_halo);
  _du = state.du.data();
  _gdim == 2 ? add_all<2>(state, f) : add_all<3>(state, f);
}

/// The last force acts on the nodes that it acted on; where they are not known, along the normal of the last step.
/// @param[in] motion of the present step relative to the master's present point [L]
NodeLaw::HalfWork NodeLaw::last_work(std::size_t i, const double* motion) const
{
  const LastForce& last = _last[i];
  const int num = last.facet >= 0 ? _tracker.master().displacement.num_nodes() : 0;
  const double* const du = _du + std::size_t(_candidates.numbers()[i]) * _gdim;
  double before[3], turn = 0.0;
  for (int c = 0; c < _gdim; ++c)
  {
    before[c] = num > 0 ? du[c] : motion[c];
    for (int j = 0; j < num; ++j)
    {
      const double there = _du[std::size_t(last.corners[j]) * _gdim + c];
      before[c] -= last.phi[j] * there;
      turn += last.turn[j * _gdim + c] * there;
    }
  }
  HalfWork out;
  out.normal = -0.5 * _last_pressure[i] * dot(_last_normal.data() + i * _gdim, before, _gdim);
  out.shear = -0.5 * dot(_last_shear.data() + i * _gdim, before, _gdim) - 0.5 * turn * _per_area[i];
  return out;
}

/// The node is out of reach, so that the law has no traction there. Half of the last one's work is done in this step,
/// where its facet is not known any more by about the motion of the last step; the energy that is stored is dissipated.
void NodeLaw::drop_stored_energy(std::size_t i)
{
  const HalfWork work = last_work(i, _last_motion.data() + i * _gdim);
  const double dissipated = _candidates.areas()[i] * (work.normal + work.shear + _last_stored[i]);
  if (_law->has_shear())
    _energy.friction += dissipated;
  else
    _energy.normal -= dissipated;
  _last_pressure[i] = _last_stored[i] = _last_shear_stored[i] = 0.0;
  std::fill_n(_last_shear.data() + i * _gdim, _gdim, 0.0);
  _last[i].facet = -1;
}

NodeLaw::Derivatives NodeLaw::largest_derivatives() const
{
  // Where the surfaces touch, and a little to both sides of it, where laws have a kink.
  InterfacePoints touching = _law->make_points(3);
  const double little = 1e-9 * facet_length();
  for (std::size_t p = 0; p < 3; ++p)
  {
    touching.row[p] = std::int32_t(p);
    touching.gap[p] = little * (double(p) - 1.0);
    touching.normal[p * _gdim] = 1.0;
  }
  InterfaceHistory history = _law->make_history(3);
  InterfaceTractions there;
  _law->evaluate(touching, history, there);
  Derivatives out;
  for (const InterfaceTractions* t : {static_cast<const InterfaceTractions*>(&there), &_tractions})
  {
    for (const InterfaceDerivative* d : {&t->by_gap, &t->by_slip})
      out.by_motion = std::max(out.by_motion, common::largest_modulus(d->values));
    for (const InterfaceDerivative* d : {&t->by_gap_rate, &t->by_slip_rate})
      out.by_rate = std::max(out.by_rate, common::largest_modulus(d->values));
  }
  out.by_motion = common::largest(_candidates.comm(), out.by_motion);
  out.by_rate = common::largest(_candidates.comm(), out.by_rate);
  return out;
}

double NodeLaw::added_square_frequency(std::span<const double> mass) const
{
  return per_mass(largest_derivatives().by_motion, mass);
}

double NodeLaw::added_damping_rate(std::span<const double> mass) const
{
  return per_mass(largest_derivatives().by_rate, mass);
}

void NodeLaw::add_to(state::State& saved) const
{
  using state::Place;
  saved.add_own("law_begun", Place::rank, std::vector<double>{double(_begun)});
  saved.add_own("law_pressure", Place::node, _last_pressure);
  saved.add_own("law_shear", Place::node, _last_shear, _gdim);
  saved.add_own("law_normal", Place::node, _last_normal, _gdim);
  saved.add_own("law_motion", Place::node, _last_motion, _gdim);
  saved.add_own("law_energy", Place::node, _last_stored);
  const int most = surface::FacetElement::max_nodes;
  std::vector<double> facets, phi, turn;
  for (const LastForce& last : _last)
  {
    facets.push_back(double(last.facet + 1)); // 0: not known
    const bool known = last.facet >= 0;
    for (int j = 0; j < most; ++j)
      phi.push_back(known && j < _tracker.master().displacement.num_nodes() ? last.phi[j] : 0.0);
    for (int k = 0; k < most * _gdim; ++k)
      turn.push_back(known && k < _tracker.master().displacement.num_nodes() * _gdim ? last.turn[k] : 0.0);
  }
  saved.add_own("law_facet", Place::node, std::move(facets));
  saved.add_own("law_phi", Place::node, std::move(phi), most);
  saved.add_own("law_correction", Place::node, std::move(turn), most * _gdim);
  saved.add_own("law_shear_energy", Place::node, _last_shear_stored);
  for (const InterfaceHistory::Variable& v : _history.variables)
    saved.add_own(of_variable + v.name, Place::node, v.committed, v.size);
}

void NodeLaw::resume_nodes(const state::State& saved)
{
  const auto set = [&saved](const std::string& name, std::vector<double>& to)
  { std::ranges::copy(saved.values<double>(name), to.begin()); };
  _begun = saved.values<double>("law_begun")[0] > 0.0; // a sum over ranks where the ranks are others
  set("law_pressure", _last_pressure);
  set("law_shear", _last_shear);
  set("law_normal", _last_normal);
  set("law_motion", _last_motion);
  set("law_energy", _last_stored);
  const auto facets = saved.values<double>("law_facet");
  const auto phi = saved.values<double>("law_phi"), turn = saved.values<double>("law_correction");
  constexpr std::size_t most = surface::FacetElement::max_nodes;
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    _last[i] = {};
    _last[i].facet = std::int64_t(facets[i]) - 1;
    std::copy_n(phi.data() + i * most, most, _last[i].phi);
    std::copy_n(turn.data() + i * most * _gdim, most * _gdim, _last[i].turn);
  }
  set("law_shear_energy", _last_shear_stored);
  for (InterfaceHistory::Variable& v : _history.variables)
    set(of_variable + v.name, v.committed);
}
} // namespace dolfinx_impact::enforcement
