#include "NodeToSurface.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace impact::enforcement
{
namespace
{
const NodeToSurfaceOptions& checked(const NodeToSurfaceOptions& o, bool rigid)
{
  const auto number = [](double v) { return std::isfinite(v) && v >= 0.0; };
  if (!number(o.friction) || !number(o.penalty) || !number(o.search_distance))
    throw std::invalid_argument("friction, penalty and search distance of a contact are finite and not negative");
  if (!(o.kappa > 0.0) || !std::isfinite(o.kappa))
    throw std::invalid_argument("kappa is " + std::to_string(o.kappa) + ", it must be positive");
  if (o.kinematic && (o.sweeps < 1 || o.balanced))
    throw std::invalid_argument("kinematic contact takes one sweep or more, and is not balanced");
  if (o.balanced && rigid)
    throw std::invalid_argument("contact with a rigid obstacle has one direction: it cannot be balanced");
  return o;
}
} // namespace

NodeToSurface::NodeToSurface(const surface::FunctionSpace& V, const surface::Facets& slave,
                             const surface::Facets& master, const NodeToSurfaceOptions& options)
    : NodeToSurface(V, slave, &master, nullptr, options)
{
  if (!options.balanced)
    return;
  NodeToSurfaceOptions one_way = options;
  one_way.balanced = false;
  _other = std::make_unique<NodeToSurface>(V, master, slave, one_way);
  _share = _other->_share = 0.5;
}

NodeToSurface::NodeToSurface(const surface::FunctionSpace& V, const surface::Facets& slave, const gap::Rigid& master,
                             const NodeToSurfaceOptions& options)
    : NodeToSurface(V, slave, nullptr, &master, options)
{
}

NodeToSurface::NodeToSurface(const surface::FunctionSpace& V, const surface::Facets& slave,
                             const surface::Facets* master, const gap::Rigid* rigid,
                             const NodeToSurfaceOptions& options)
    : _options(checked(options, rigid != nullptr)), _gdim(slave.gdim), _rigid(rigid != nullptr),
      _obstacle(rigid ? *rigid : gap::Rigid{}),
      _candidates(V, slave, master, options.search_distance, options.axisymmetric), _tracking(_gdim, _candidates.X())
{
  if (rigid && rigid->gdim != _gdim)
    throw std::invalid_argument("the rigid master has another dimension than the slave");
  const std::size_t n = _candidates.nodes().size(), vector = n * _gdim;
  _results = {std::vector<ContactStatus>(n, ContactStatus::open),
              std::vector<double>(n, std::numeric_limits<double>::infinity()),
              std::vector<double>(vector, 0.0),
              std::vector<double>(n, 0.0),
              std::vector<double>(vector, 0.0),
              std::vector<double>(vector, 0.0)};
  _tangential.assign(vector, 0.0);
  _stiffness.assign(n, 0.0);
  _springs.assign(n, {});
  _closed.assign(n, 0);
  _taken.assign(n, 0.0);
  _pulse.assign(n, 0.0);
  for (double area : _candidates.areas())
    _per_area.push_back(1.0 / area);
  if (options.kinematic)
  {
    _num_masters = master ? master->displacement.num_nodes() : 0;
    _closed_now.resize(n);
    _phi.resize(n * _num_masters);
    for (std::vector<double>* a : {&_motion, &_nodal_force})
      a->assign(vector, 0.0);
    _couples.resize(n);
    _arms.resize(vector * _num_masters);
    _along.assign(n, 0.0);
    _across.assign(n, 0.0);
  }
}

void NodeToSurface::search(std::span<const double> u, std::span<const double> du)
{
  double deepest = 0.0;
  for (std::size_t i = 0; i < _closed.size(); ++i)
    if (_closed[i] == 1)
      deepest = std::max(deepest, -_springs[i].gap); // kinematic contact leaves none
  _candidates.search(u, du, deepest);
  if (_other)
    _other->search(u, du);
  const auto nodes = _candidates.remote_nodes();
  const auto owners = _candidates.remote_owners();
  std::vector<std::pair<std::int64_t, int>> all;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    all.emplace_back(nodes[i], owners[i]);
  if (_other)
    for (std::size_t i = 0; i < _other->remote_nodes().size(); ++i)
      all.emplace_back(_other->remote_nodes()[i], _other->remote_owners()[i]);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  _all_remote.clear();
  _all_owners.clear();
  for (const auto& [node, owner] : all)
  {
    _all_remote.push_back(node);
    _all_owners.push_back(owner);
  }
}

std::span<const std::int64_t> NodeToSurface::remote_nodes() const
{
  return _all_remote;
}
std::span<const int> NodeToSurface::remote_owners() const
{
  return _all_owners;
}

std::span<const std::int32_t> NodeToSurface::needs(operators::Halo& all)
{
  // Owners have all their nodes, also those that only slaves of other ranks push.
  _needed.assign(_candidates.watched().begin(), _candidates.watched().end());
  if (!_rigid)
  {
    _areas = _candidates.master_areas(all);
    _facets = _candidates.numbered(all);
    _around = _candidates.around(all);
    for (const surface::Facets* facets : {&_facets, &_around})
      _needed.insert(_needed.end(), facets->nodes.begin(), facets->nodes.end());
  }
  if (_other)
  {
    const auto more = _other->needs(all);
    _needed.insert(_needed.end(), more.begin(), more.end());
  }
  std::sort(_needed.begin(), _needed.end());
  _needed.erase(std::unique(_needed.begin(), _needed.end()), _needed.end());
  return _needed;
}

void NodeToSurface::number(operators::Halo& halo, std::span<const std::int32_t> numbers, const double* mass)
{
  _halo = &halo;
  _candidates.number(numbers);
  _inverse_mass.clear();
  for (std::int32_t node : _candidates.numbers())
    _inverse_mass.push_back(1.0 / mass[node]);
  if (!_rigid)
  {
    std::vector<double> areas(halo.num_nodes(), 0.0);
    for (std::int32_t& node : _facets.nodes)
    {
      areas[numbers[node]] = _areas[node];
      node = numbers[node];
    }
    for (std::int32_t& node : _around.nodes)
      node = numbers[node];
    _tracking.reset(std::move(_facets), _candidates.numbers(), std::move(_around), _candidates.distance());
    const auto masters = _tracking.master_nodes();
    for (std::size_t k = 0; k < masters.size(); ++k)
      keep(_tracking.masters()[k], mass[masters[k]], areas[masters[k]]);
    _master_force.assign(masters.size(), {});
  }
  if (_options.kinematic)
    number_kinematic(halo);
  if (_other)
    _other->number(halo, numbers, mass);
}

double NodeToSurface::used(const NodalState& state) const
{
  return std::max(_candidates.used(state), _other ? _other->used(state) : 0.0);
}

void NodeToSurface::forget()
{
  _candidates.forget();
  if (_other)
    _other->forget();
}

ContactEnergy NodeToSurface::energy() const
{
  ContactEnergy out = _energy;
  if (_other)
  {
    const ContactEnergy more = _other->energy();
    out.stored += more.stored;
    out.friction += more.friction;
    out.normal += more.normal;
    out.later_friction += more.later_friction;
    out.later_normal += more.later_normal;
    out.recoverable += more.recoverable;
  }
  return out;
}

void NodeToSurface::keep_normals(bool keep)
{
  _tracking.keep_normals(keep);
  if (_other)
    _other->keep_normals(keep);
}

void NodeToSurface::set_obstacle(const std::array<double, 3>& displacement, const std::array<double, 3>& increment)
{
  _obstacle.displacement = displacement;
  _obstacle_increment = increment;
}

Passage NodeToSurface::passage() const
{
  const Passage more = _other ? _other->passage() : Passage{};
  return more.facets > _passage.facets ? more : _passage;
}

NodalHistory NodeToSurface::history() const
{
  std::vector<double> springs;
  for (const Spring& s : _springs)
    springs.insert(springs.end(), {s.force, s.compliance, s.gap, s.surplus, s.tangential_surplus});
  return {_tangential,         _results.slip, springs, _closed, {_tracking.held().begin(), _tracking.held().end()},
          _tracking.held_xi(), _taken,        _pulse};
}

void NodeToSurface::set_history(const NodalHistory& history)
{
  const std::size_t n = _closed.size(), vector = n * _gdim;
  if (history.tangential.size() != vector || history.slip.size() != vector || history.closed.size() != n ||
      history.springs.size() != 5 * n || history.facet.size() != n || history.xi.size() != 2 * n ||
      history.taken.size() != n || history.pulse.size() != n)
    throw std::invalid_argument("the history belongs to other nodes: this rank has " + std::to_string(n) +
                                " slave nodes, found " + std::to_string(history.closed.size()));
  _tangential = history.tangential;
  _results.slip = history.slip;
  for (std::size_t i = 0; i < n; ++i)
  {
    const double* s = history.springs.data() + 5 * i;
    _springs[i] = {s[0], s[1], s[2], s[3], s[4]};
  }
  _closed = history.closed;
  _taken = history.taken;
  _pulse = history.pulse;
  _passage = {};
  _tracking.set_held(history.facet, history.xi);
}
} // namespace impact::enforcement
