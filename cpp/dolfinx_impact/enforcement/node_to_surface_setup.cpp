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
      _candidates(V, slave, master, options.search_distance, options.axisymmetric),
      _tracking(_gdim, _candidates.X(), {_candidates.nodes().begin(), _candidates.nodes().end()})
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
  _closed.assign(n, 0);
  for (double area : _candidates.areas())
    _per_area.push_back(1.0 / area);
  if (options.kinematic)
  {
    _touch.resize(n);
    for (std::vector<double>* a : {&_motion, &_residual, &_nodal_force})
      a->assign(vector, 0.0);
    _couples.resize(n);
  }
}

void NodeToSurface::search(std::span<const double> u)
{
  _candidates.search(u);
  if (_other)
    _other->search(u);
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

void NodeToSurface::number(operators::Halo& halo, const double* mass)
{
  _halo = &halo;
  _mass.resize(_candidates.nodes().size());
  std::transform(_candidates.nodes().begin(), _candidates.nodes().end(), _mass.begin(),
                 [&](std::int32_t node) { return mass[node]; });
  _acting.assign(_candidates.nodes().begin(), _candidates.nodes().end());
  _inverse_mass.resize(_mass.size());
  std::transform(_mass.begin(), _mass.end(), _inverse_mass.begin(), [](double m) { return 1.0 / m; });
  if (!_rigid)
  {
    const std::vector<double> areas = _candidates.master_areas(halo);
    _tracking.reset(_candidates.numbered(halo), _candidates.normals(), _candidates.distance());
    _inverse.clear();
    for (std::int32_t node : _tracking.master_nodes())
      _inverse.insert(_inverse.end(), {1.0 / mass[node], areas[node] / mass[node]});
    _master_force.assign(_tracking.master_nodes().size() * _gdim, 0.0);
    _acting.insert(_acting.end(), _tracking.master_nodes().begin(), _tracking.master_nodes().end());
  }
  if (_options.kinematic)
  {
    // Owners correct their nodes themselves, also those that only slaves of other ranks push.
    _acting.insert(_acting.end(), _candidates.watched().begin(), _candidates.watched().end());
    number_kinematic(halo, mass);
  }
  if (_other)
  {
    _other->number(halo, mass);
    _acting.insert(_acting.end(), _other->_acting.begin(), _other->_acting.end());
  }
  std::sort(_acting.begin(), _acting.end());
  _acting.erase(std::unique(_acting.begin(), _acting.end()), _acting.end());
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
  }
  return out;
}

void NodeToSurface::set_obstacle(const std::array<double, 3>& displacement, const std::array<double, 3>& increment)
{
  _obstacle.displacement = displacement;
  _obstacle_increment = increment;
}

NodalHistory NodeToSurface::history() const
{
  return {_tangential, _results.slip, _closed, {_tracking.held().begin(), _tracking.held().end()}, _tracking.held_xi()};
}

void NodeToSurface::set_history(const NodalHistory& history)
{
  const std::size_t n = _closed.size(), vector = n * _gdim;
  if (history.tangential.size() != vector || history.slip.size() != vector || history.closed.size() != n ||
      history.facet.size() != n || history.xi.size() != 2 * n)
    throw std::invalid_argument("the history belongs to other nodes: this rank has " + std::to_string(n) +
                                " slave nodes, found " + std::to_string(history.closed.size()));
  _tangential = history.tangential;
  _results.slip = history.slip;
  _closed = history.closed;
  _tracking.set_held(history.facet, history.xi);
}
} // namespace impact::enforcement
