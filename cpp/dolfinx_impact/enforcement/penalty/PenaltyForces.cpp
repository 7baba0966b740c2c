// SPDX-License-Identifier: MIT
#include "PenaltyForces.h"
#include "../../common/dolfinx_api.h"
#include "../../operators/nodal_sums.h"
#include "../../operators/petsc_check.h"
#include <algorithm>
#include <dolfinx/la/Vector.h>
#include <functional>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{

PenaltyForces::PenaltyForces(Setup setup, std::unique_ptr<search::PairSearch> search,
                             std::shared_ptr<const gap::Rigid> rigid)
    : _space(setup.V), _slave(std::move(setup.slave)), _rigid(std::move(rigid)), _search(std::move(search)),
      _points(gap::make_points(_slave, setup.points, setup.weights, setup.axisymmetric))
{
  history = make_history(_points);
  const std::size_t num = _points.size(), size = num * _points.gdim;
  if (setup.law)
    _law.emplace(std::move(setup.law), num);
  _state = {std::vector<ContactStatus>(num, ContactStatus::open), std::vector<double>(num), std::vector<double>(size),
            std::vector<double>(size), std::vector<double>(size)};
}

PenaltyForces::PenaltyForces(const Setup& setup, const surface::Facets& master, double search_distance)
    : PenaltyForces(setup, std::make_unique<search::PairSearch>(setup.V, setup.slave, master, search_distance), nullptr)
{
}

PenaltyForces::PenaltyForces(const Setup& setup, std::unique_ptr<search::GeneralSearch> general)
    : PenaltyForces(setup, setup.slave)
{
  _general = std::move(general);
  if (_slave.gdim == 3 && _slave.displacement.degree == 1 && _slave.geometry.degree == 1)
    _edges.emplace(_slave);
}

PenaltyForces::PenaltyForces(Setup setup, std::shared_ptr<const gap::Rigid> master)
    : PenaltyForces(std::move(setup), nullptr, std::move(master))
{
  if (!_rigid)
    throw std::invalid_argument("a rigid master is needed");
}

std::shared_ptr<const dolfinx::common::IndexMap> PenaltyForces::map() const
{
  return _search ? _search->map() : _space->dofmap()->index_map;
}

PenaltyPair PenaltyForces::pair() const
{
  return {_points, slave(), master(), parameters, history, _increment, _rigid_increment, law(), _share};
}

void PenaltyForces::update_gap(std::span<const double> u, std::span<const double> start, bool stay)
{
  if (_search)
  {
    _search->update(u, start);
    if (_general)
    {
      _general->update(*_search, start);
      gap::update(_points, _search->slave(), *_general, _search->reach(), stay && _search->kept(), history.depth);
      if (_edges)
        _edges->update(*_search, *_general, u, start);
      return update_shares();
    }
    gap::update(_points, _search->slave(), _search->closest(), _search->reach(), stay && _search->kept());
    return;
  }
  for (std::int32_t node : _slave.nodes)
    if (std::size_t(node + 1) * _slave.gdim > u.size())
      throw std::invalid_argument("the displacements are fewer than the surface's nodes");
  surface::move(_slave, u.data());
  gap::update(_points, _slave, *_rigid);
}

/// The softer one of two bodies decides on the penalties between them.
void PenaltyForces::update_shares()
{
  if (share_of_body.empty())
    return;
  _share.resize(_points.size());
  for (std::size_t q = 0; q < _points.size(); ++q)
  {
    const double own = share_of_body[_general->slave_bodies()[_points.facet[q]]];
    const std::int32_t facet = _points.master[q];
    _share[q] = facet < 0 ? own : std::min(own, share_of_body[_general->master_bodies()[facet]]);
  }
}

void PenaltyForces::forget()
{
  if (_search)
    _search->forget();
  _matrix.forget();
}

void PenaltyForces::evaluate(std::span<const double> increment, const RigidIncrement& rigid_increment)
{
  if (_search)
  {
    _increment.resize(_search->exchange()->size());
    _search->exchange()->forward(increment, _increment);
  }
  else
    _increment.assign(increment.begin(), increment.end());
  _rigid_increment = rigid_increment;
  evaluate();
}

void PenaltyForces::evaluate()
{
  if (_law)
    evaluate_law();
  _state = enforcement::evaluate(pair());
  if (_edges)
    _edges->evaluate(parameters, share_of_body);
}

void PenaltyForces::resume_law()
{
  _law->resume();
  _state = enforcement::evaluate(pair());
}

/// Bring the points of the law to the present state. Collective where it has fields.
void PenaltyForces::evaluate_law()
{
  const std::vector<double> increments = relative_increments(pair());
  const auto nodes = map();
  LawPoints::Fields on_slave, on_master;
  double shape[surface::FacetElement::max_nodes];
  for (const InterfaceField& field : _law->law().fields())
  {
    const std::span<const double> given = field.function->x()->array();
    std::vector<double> values(nodes->size_local() + nodes->num_ghosts(), 0.0);
    std::copy_n(given.begin(), std::min(given.size(), std::size_t(nodes->size_local())), values.begin());
    values = operators::from_owners(nodes, std::move(values), 1);
    on_slave.emplace_back(_points.size(), 0.0);
    on_master.emplace_back(_points.size(), 0.0);
    for (std::size_t q = 0; q < _points.size(); ++q)
    {
      slave().displacement.values(_points.xi.data() + 2 * q, shape);
      for (int i = 0; i < slave().displacement.num_nodes(); ++i)
        on_slave.back()[q] += shape[i] * values[slave().nodes_of(_points.facet[q])[i]];
      if (!master() || _points.master[q] < 0)
        continue;
      master()->displacement.values(_points.master_xi.data() + 2 * q, shape);
      for (int i = 0; i < master()->displacement.num_nodes(); ++i)
        on_master.back()[q] += shape[i] * values[master()->nodes_of(_points.master[q])[i]];
    }
  }
  _law->evaluate(_points, {history.offset, history.slip, increments}, on_slave, on_master);
}

/// Forces of a state on both bodies, owned entries; with `closing` the state is `stretched`.
std::vector<double> PenaltyForces::nodal_forces(const PenaltyState& state, bool closing) const
{
  const auto nodes = map();
  const std::size_t owned = std::size_t(nodes->size_local()) * _slave.gdim;
  std::vector<double> out(owned, 0.0);
  if (_search)
  {
    std::vector<double> values(_search->exchange()->size(), 0.0);
    add_force(pair(), state, values);
    if (_edges)
      closing ? _edges->add_closing_force(values) : _edges->add_force(values);
    _search->exchange()->reverse(values, out);
    return out;
  }
  dolfinx::la::Vector<double> values(nodes, _slave.gdim);
  common::fill(values, 0.0);
  add_force(pair(), state, common::array(values));
  values.scatter_rev(std::plus<double>());
  std::copy_n(values.array().begin(), owned, out.begin());
  return out;
}

std::vector<double> PenaltyForces::contact_forces() const
{
  return nodal_forces(_state, false);
}

std::vector<double> PenaltyForces::closing_forces() const
{
  return nodal_forces(stretched(pair(), _state), true);
}

void PenaltyForces::add_residual(Vec b) const
{
  operators::subtract(nodal_forces(_state, false), b);
}

Mat PenaltyForces::tangent(bool convex)
{
  const PenaltyPair now = pair();
  operators::NodalMatrix::Couplings couplings;
  std::int32_t nodes[18];
  const std::int64_t num_master = now.master ? std::int64_t(now.master->size()) : 1;
  for (std::size_t q = 0; q < _points.size(); ++q)
  {
    const std::int64_t key = _points.facet[q] * num_master + (now.master ? _points.master[q] : 0);
    if (_state.status[q] == ContactStatus::open || (!couplings.keys.empty() && couplings.keys.back() == key))
      continue;
    const std::size_t num = coupled_nodes(now, q, nodes);
    couplings.add(key, {nodes, num}, {nodes, num});
  }
  if (_edges)
    _edges->add_couplings(std::int64_t(slave().size()) * num_master, couplings);
  _matrix.reset(map(), _slave.gdim, couplings);
  enforcement::tangent(now, _state, convex, [&](std::span<const std::int32_t> at, std::span<const double> block)
                       { _matrix.add(at, at, block); });
  if (_edges)
    _edges->add_tangent(convex, _matrix);
  _matrix.finish();
  return _matrix.matrix();
}
} // namespace dolfinx_impact::enforcement
