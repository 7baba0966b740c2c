// SPDX-License-Identifier: MIT
#include "NodeToSurface.h"
#include "../../common/gather.h"
#include "../../gap/search_distance.h"
#include "../../search/closest_point/linear_facet.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::enforcement
{
using search::Projection;

namespace
{
using surface::FacetElement;
using surface::FacetShape;

constexpr double shallow = 0.05; ///< of the facet: as deep a node may be met at first, as it may be beside the rim
constexpr int most_parts = 1000; ///< of a step's way: nodes that move by more than 500 facets are found out somewhere

NodeToSurfaceOptions checked(const NodeToSurfaceOptions& o)
{
  for (double value : {o.friction, o.search_distance})
    if (!std::isfinite(value) || !(value >= 0.0))
      throw std::invalid_argument("friction and search distance of a contact are finite and not negative");
  return o;
}

/// Below the surface, not beside its rim.
bool is_below(const Projection& at)
{
  return at.gap < 0.0 && at.rim != Projection::Rim::beside && at.rim != Projection::Rim::below;
}

void shape_values(const FacetElement& element, const double* xi, double* phi)
{
  if (element.degree > 1)
    return element.values(xi, phi);
  if (element.shape == FacetShape::quadrilateral)
    search::linear::values<FacetShape::quadrilateral>(xi, phi);
  else if (element.shape == FacetShape::triangle)
    search::linear::values<FacetShape::triangle>(xi, phi);
  else
    search::linear::values<FacetShape::interval>(xi, phi);
}
} // namespace

NodeToSurface::NodeToSurface(const surface::FunctionSpace& V, const surface::Facets& slave,
                             const surface::Facets* master, const gap::Rigid* rigid,
                             const NodeToSurfaceOptions& options)
    : _options(checked(options)), _gdim(slave.gdim), _rigid(rigid != nullptr), _obstacle(rigid ? *rigid : gap::Rigid{}),
      _candidates(
          V, slave, master,
          gap::search_distance(V.mesh()->comm(), slave, master, options.search_distance, options.adjustment.offset),
          options.axisymmetric),
      _tracker(_gdim, _candidates.X())
{
  if (rigid)
  {
    gap::Rigid undisplaced = *rigid;
    undisplaced.displacement = {};
    _undisplaced_size = gap::largest_position(undisplaced);
    _obstacle_size = gap::largest_position(*rigid);
  }
  if (rigid && rigid->gdim != _gdim)
    throw std::invalid_argument("the rigid master has another dimension than the slave");
  for (std::size_t f = 0; f < slave.size(); ++f)
  {
    double square = 0.0;
    for (int c = 0; c < _gdim; ++c)
    {
      double low = slave.X_of(f)[c], high = low;
      for (int i = 1; i < slave.geometry.num_nodes(); ++i)
      {
        low = std::min(low, slave.X_of(f)[i * _gdim + c]);
        high = std::max(high, slave.X_of(f)[i * _gdim + c]);
      }
      square += (high - low) * (high - low);
    }
    _facet_length = std::max(_facet_length, std::sqrt(square));
  }
  _facet_length = common::largest(V.mesh()->comm(), _facet_length);
  const std::size_t n = _candidates.nodes().size(), vector = n * _gdim;
  _results = {std::vector<ContactStatus>(n, ContactStatus::open),
              std::vector<double>(n, std::numeric_limits<double>::infinity()),
              std::vector<double>(vector, 0.0),
              std::vector<double>(n, 0.0),
              std::vector<double>(vector, 0.0),
              std::vector<double>(vector, 0.0)};
  _tangential.assign(vector, 0.0);
  _closed.assign(n, 0);
  for (double area : _candidates.areas())
    _per_area.push_back(1.0 / area);
  if (_options.adjustment.any())
  {
    const std::vector<double> gaps = reference_gaps(V);
    _initial.emplace(_options.name, V, slave, master, _candidates.X(), gaps, _options.adjustment);
    _shift = _initial->offset();
  }
}

/// Gaps of the slave nodes between the meshed surfaces in the reference configuration, infinite beside the master.
/// Collective.
std::vector<double> NodeToSurface::reference_gaps(const surface::FunctionSpace& V)
{
  const std::size_t n = num_nodes();
  std::vector<double> out(n);
  if (_rigid)
  {
    gap::Rigid undisplaced = _obstacle;
    undisplaced.displacement = {};
    for (std::size_t i = 0; i < n; ++i)
      out[i] = gap::evaluate(undisplaced, std::span<const double>(_candidates.X()).subspan(i * _gdim, _gdim)).gap;
    return out;
  }
  const auto map = V.dofmap()->index_map;
  _candidates.search(std::vector<double>(std::size_t(map->size_local()) * _gdim, 0.0), {}, 0.0);
  std::vector<std::int64_t> ghosts(map->ghosts().begin(), map->ghosts().end());
  std::vector<int> owners(map->owners().begin(), map->owners().end());
  ghosts.insert(ghosts.end(), _candidates.remote_nodes().begin(), _candidates.remote_nodes().end());
  owners.insert(owners.end(), _candidates.remote_owners().begin(), _candidates.remote_owners().end());
  operators::Halo halo(
      std::make_shared<const dolfinx::common::IndexMap>(map->comm(), map->size_local(), ghosts, owners));
  std::vector<std::int32_t> same(halo.num_nodes());
  std::iota(same.begin(), same.end(), 0);
  NodeToSurface::required_nodes(halo);
  NodeToSurface::assign_numbers(halo, same, std::vector<double>(same.size(), 1.0));
  const std::vector<double> still(same.size() * _gdim, 0.0);
  _tracker.advance(still.data(), still.data());
  for (std::size_t i = 0; i < n; ++i)
  {
    const Projection at = _tracker.locate(i, still.data(), still.data());
    const bool beside = at.rim == Projection::Rim::beside || at.rim == Projection::Rim::below;
    out[i] = beside ? std::numeric_limits<double>::infinity() : at.gap;
  }
  _candidates.forget();
  _halo = nullptr; // it ends here, and the first step takes another one
  return out;
}

inline void NodeToSurface::adjust(std::size_t i, Projection& at) const
{
  // Layers end where the master does, and nodes beside it were not adjusted.
  if (!_shift.empty() && at.rim != Projection::Rim::beside && at.rim != Projection::Rim::below)
    at.gap += _shift[i];
}

search::Projection NodeToSurface::adjusted(std::size_t i, Projection at) const
{
  adjust(i, at);
  return at;
}

void NodeToSurface::search(std::span<const double> u, std::span<const double> du)
{
  _candidates.search(u, du, deepest_penetration());
}

std::span<const std::int32_t> NodeToSurface::required_nodes(operators::Halo& all)
{
  // An owner keeps all its watched nodes: slaves of other ranks may push them.
  _needed.assign(_candidates.watched().begin(), _candidates.watched().end());
  if (!_rigid)
  {
    _areas = _candidates.master_areas(all);
    _facets = _candidates.numbered(all);
    _slave_facets = _candidates.around(all);
    for (const surface::Facets* facets : {&_facets, &_slave_facets})
      _needed.insert(_needed.end(), facets->nodes.begin(), facets->nodes.end());
  }
  std::sort(_needed.begin(), _needed.end());
  _needed.erase(std::unique(_needed.begin(), _needed.end()), _needed.end());
  return _needed;
}

void NodeToSurface::assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                                   std::span<const double> mass)
{
  _halo = &halo;
  _candidates.assign_numbers(numbers);
  _inverse_mass.clear();
  for (std::int32_t node : _candidates.numbers())
    _inverse_mass.push_back(1.0 / mass[node]);
  if (_rigid)
    return;
  std::vector<double> areas(halo.num_nodes(), 0.0);
  for (std::int32_t& node : _facets.nodes)
  {
    areas[numbers[node]] = _areas[node];
    node = numbers[node];
  }
  for (std::int32_t& node : _slave_facets.nodes)
    node = numbers[node];
  _tracker.reset(std::move(_facets), _candidates.numbers(), std::move(_slave_facets), _candidates.distance());
  _master_inverse_mass.clear();
  _master_areas.clear();
  for (std::int32_t master : _tracker.master_nodes())
  {
    _master_inverse_mass.push_back(1.0 / mass[master]);
    _master_areas.push_back(areas[master]);
  }
}

void NodeToSurface::set_obstacle(const gap::RigidMotion& motion)
{
  _obstacle.displacement = motion.displacement;
  _obstacle.rotates = motion.rotates;
  _obstacle.rotation = motion.rotation;
  _obstacle_motion = motion;
  if (!_rigid)
    return;
  double moved = 0.0;
  for (double value : motion.displacement)
    moved = std::max(moved, std::abs(value));
  _obstacle_size = _undisplaced_size + moved;
}

void NodeToSurface::obstacle_increment(const double* x, double* increment) const
{
  const gap::RigidMotion& m = _obstacle_motion;
  for (int c = 0; c < _gdim; ++c)
  {
    increment[c] = m.increment[c];
    if (m.rotates)
      for (int d = 0; d < _gdim; ++d)
        increment[c] += m.turn[3 * c + d] * (x[d] - _obstacle.centre[d] - m.displacement[d]);
  }
}

void NodeToSurface::position(std::size_t i, const double* u, double* x) const
{
  const std::size_t k = std::size_t(_candidates.numbers()[i]) * _gdim;
  for (int c = 0; c < _gdim; ++c)
    x[c] = _candidates.X()[i * _gdim + c] + u[k + c];
}

void NodeToSurface::add_moment(std::size_t i, const double* u, const double* force)
{
  double x[3];
  position(i, u, x);
  for (int c = 0; c < _gdim; ++c)
    for (int d = 0; d < _gdim; ++d)
      _force_moment[3 * c + d] += force[c] * (x[d] - _obstacle.centre[d] - _obstacle.displacement[d]);
}

state::State NodeToSurface::saved_state() const
{
  using state::Place;
  state::State out("direction");
  out.at(Place::node, {_candidates.nodes().begin(), _candidates.nodes().end()});
  out.add_own("tangential", Place::node, _tangential, _gdim).add_own("slip", Place::node, _results.slip, _gdim);
  out.add_own("xi", Place::node, _tracker.tracked_xi(), 2);
  add_to(out);
  out.add_own("closed", Place::node, _closed);
  out.add_own("facet", Place::node, std::vector<std::int64_t>(_tracker.tracked().begin(), _tracker.tracked().end()));
  out.add_own("energies", Place::rank,
              std::vector<double>{_energy.stored, _energy.friction, _energy.normal, _energy.later_friction,
                                  _energy.later_normal, _energy.recoverable});
  out.add_own("force", Place::rank, std::vector<double>(_force.begin(), _force.begin() + _gdim));
  return out;
}

void NodeToSurface::resume(const state::State& saved)
{
  const state::State mine = saved_state();
  if (const std::string found = mine.difference_of_structure(saved); !found.empty())
    throw std::invalid_argument("the state belongs to other nodes: " + found);
  const auto set = [&saved]<typename T>(const char* name, std::vector<T>& to)
  { std::ranges::copy(saved.values<T>(name), to.begin()); };
  set("tangential", _tangential);
  set("slip", _results.slip);
  set("closed", _closed);
  // What a node that opens gives back depends on whether it was open; sticking or slipping is told by the next forces.
  for (std::size_t i = 0; i < num_nodes(); ++i)
    _results.status[i] = _closed[i] == 1 ? ContactStatus::slip : ContactStatus::open;
  _passage = {};
  const auto facet = saved.values<std::int64_t>("facet");
  const auto xi = saved.values<double>("xi");
  _tracker.set_tracked({facet.begin(), facet.end()}, {xi.begin(), xi.end()});
  const auto e = saved.values<double>("energies");
  _energy = {e[0], e[1], e[2], e[3], e[4], e[5]};
  std::ranges::copy(saved.values<double>("force"), _force.begin());
  resume_nodes(saved);
}

void NodeToSurface::reset()
{
  state::State none = saved_state();
  for (const state::Field& field : none.fields())
    if (field.name != "force")
      std::visit([](auto values) { std::ranges::fill(values, 0); }, field.values);
  std::ranges::fill(none.values<std::int64_t>("facet"), -1);
  resume(none);
}

std::optional<std::int64_t> NodeToSurface::too_deep(std::span<const double> u) const
{
  if (!_rigid)
    return std::nullopt;
  std::int64_t deep = 0;
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    double x[3];
    for (int c = 0; c < _gdim; ++c)
      x[c] = _candidates.X()[i * _gdim + c] + u[std::size_t(_candidates.nodes()[i]) * _gdim + c];
    const double adjustment = _shift.empty() ? 0.0 : _shift[i];
    deep += gap::evaluate(_obstacle, std::span(x, _gdim)).gap + adjustment < -0.5 * _facet_length;
  }
  return deep;
}

double NodeToSurface::per_mass(double per_area, std::span<const double> mass) const
{
  // Largest area, and largest ratio of an area plus another one to the mass, of a surface's nodes on all ranks.
  struct Side
  {
    std::vector<double> areas, masses;
  };
  const auto largest = [this](const Side& side, double more)
  {
    double found = 0.0;
    for (std::size_t i = 0; i < side.areas.size(); ++i)
      found = std::max(found, (side.areas[i] + more) / side.masses[i]);
    return common::largest(_candidates.comm(), found);
  };
  Side slave{_candidates.areas(), {}}, master;
  for (const std::int32_t node : _candidates.nodes())
    slave.masses.push_back(mass[node]);
  const double own = largest(slave, 0.0);
  if (_rigid)
    return per_area * (own + _mobility);
  for (std::size_t node = 0; node < _candidates.master_areas().size(); ++node)
    if (const double area = _candidates.master_areas()[node]; area > 0.0)
    {
      master.areas.push_back(area);
      master.masses.push_back(mass[node]);
    }
  // Largest sum of the absolute values of a facet's shape functions.
  const double phi = _candidates.slave().displacement.degree == 1 ? 1.0 : _gdim == 2 ? 1.25 : 5.0 / 3.0;
  const double area = common::largest(_candidates.comm(), slave.areas.empty() ? 0.0 : std::ranges::max(slave.areas));
  return per_area * (own + phi * largest(master, area));
}

// --- contact detection

search::Projection NodeToSurface::rigid_point(std::size_t i, const double* u, const double* du, double back) const
{
  const std::size_t k = std::size_t(_candidates.numbers()[i]) * _gdim;
  double x[3], increment[3] = {0.0, 0.0, 0.0};
  position(i, u, x);
  if (du)
  {
    obstacle_increment(x, increment);
    for (int c = 0; c < _gdim; ++c)
      x[c] = _candidates.X()[i * _gdim + c] + u[k + c] - back * (du[k + c] - increment[c]);
  }
  const gap::RigidPoint p = gap::evaluate(_obstacle, std::span(x, _gdim));
  search::Projection out;
  out.status = search::ProjectionStatus::converged;
  out.gap = p.gap;
  std::copy_n(p.normal, 3, out.normal);
  return out;
}

void NodeToSurface::open(std::size_t i, const Projection& at, const double* u)
{
  _results.gap[i] = at.gap;
  if (!_rigid)
  {
    Projection meshed = at;
    if (!_shift.empty())
    {
      if (at.rim != Projection::Rim::beside && at.rim != Projection::Rim::below)
        meshed.gap -= _shift[i];
      // What is skipped stays clear of the meshed surface, which is farther than its layers.
      if (_shift[i] < 0.0)
        meshed.clearance = 0.0;
    }
    _tracker.release(i, meshed, u);
  }
  if (_results.status[i] == ContactStatus::open && _closed[i] != 1)
    return; // the node was open already: its results are zero
  drop_stored_energy(i);
  _results.status[i] = ContactStatus::open;
  _results.pressure[i] = 0.0;
  for (std::vector<double>* values : {&_results.traction, &_results.slip, &_tangential})
    std::fill_n(values->data() + i * _gdim, _gdim, 0.0);
  if (_closed[i] == 1)
    _closed[i] = 0;
}

/// What rounding of the positions does to the gap of node i. Surfaces that touch have gaps of both signs within it:
/// contact that took the negative ones for overlaps would set a body in motion that is at rest.
template <int D>
double NodeToSurface::rounding(std::size_t i, const double* u) const
{
  const std::size_t k = std::size_t(_candidates.numbers()[i]) * D;
  double size = _obstacle_size;
  for (int c = 0; c < D; ++c)
    size += std::abs(_candidates.X()[i * D + c]) + std::abs(u[k + c]);
  return 4.0 * std::numeric_limits<double>::epsilon() * size;
}

/// Upper bound of that, from what the tracker has read: the displacement is no more than both positions together.
template <int D>
double NodeToSurface::most_rounding(std::size_t i) const
{
  if (_rigid)
    return std::numeric_limits<double>::infinity();
  double size = _obstacle_size;
  for (int c = 0; c < D; ++c)
    size += 2.0 * std::abs(_tracker.X(i)[c]) + std::abs(_tracker.x(i)[c]);
  return 5.0 * std::numeric_limits<double>::epsilon() * size;
}

bool NodeToSurface::find_contact(std::size_t i, const double* u, const double* du, double reach, bool keep_closed,
                                 ContactPoint& point)
{
  return _gdim == 2 ? find_contact_in<2>(i, u, du, reach, keep_closed, point)
                    : find_contact_in<3>(i, u, du, reach, keep_closed, point);
}

template <int D>
bool NodeToSurface::find_contact_in(std::size_t i, const double* u, const double* du, double reach, bool keep_closed,
                                    ContactPoint& point)
{
  point.i = i;
  point.node = _candidates.numbers()[i];
  Projection& at = point.at;
  if (_rigid)
    at = rigid_point(i, u);
  else
    _tracker.locate(i, u, du, at);
  adjust(i, at);
  if (at.gap < 0.0 && at.gap > -most_rounding<D>(i) && at.gap > -rounding<D>(i, u))
    at.gap = 0.0;
  if (_closed[i] != marked && (_rigid || _tracker.step() > 0.5 * _candidates.smallest()) &&
      passes_through(point, u, du))
  {
    open(i, at, u);
    return false;
  }
  for (int c = 0; c < D; ++c)
    _results.normal[i * D + c] = at.normal[c];
  const bool kept = keep_closed && _closed[i] == 1 && std::isfinite(at.gap);
  // Of nodes in contact only those beside the rim, or without a master, can be marked.
  const bool stays = _closed[i] == 1 && at.rim == Projection::Rim::no && std::isfinite(at.gap);
  if ((!stays && is_marked(point, u, du)) || (!(at.gap < reach) && !kept))
  {
    open(i, at, u);
    return false;
  }
  point.num = 0;
  if (_rigid)
    return true;
  const surface::Facets& master = _tracker.master();
  point.num = master.displacement.num_nodes();
  point.masters = master.nodes_of(at.facet);
  point.corners = _tracker.corners(at.facet);
  shape_values(master.displacement, at.xi, point.phi);
  return true;
}

void NodeToSurface::update_gaps(std::span<const double> displacements)
{
  if (_rigid || !_halo)
    return;
  const double* u = displacements.data();
  const double moved = _tracker.moved(u);
  for (std::size_t i = 0; i < num_nodes(); ++i)
    if (_closed[i] != 1)
    {
      const Projection at = adjusted(i, _tracker.evaluate(i, u, moved));
      _results.gap[i] = at.gap;
      std::copy_n(at.normal, _gdim, _results.normal.data() + i * _gdim);
    }
}

// --- passage through the surface

/// A node is marked when it lies below the surface without having passed through it: it came from beside the rim, or it
/// was first found deep inside. A node without a master keeps its mark, because its side is unknown.
bool NodeToSurface::is_marked(const ContactPoint& point, const double* u, const double* du)
{
  const Projection& at = point.at;
  std::int8_t& closed = _closed[point.i];
  if (_rigid || !std::isfinite(at.gap))
    return closed == marked;
  const double diameter = _tracker.diameter(at.facet);
  if (at.rim == Projection::Rim::below)
    closed = marked;
  else if (at.rim == Projection::Rim::beside || !(at.gap < 0.0))
    closed = closed == marked ? 0 : closed;
  else if (closed == 0 && -at.gap > shallow * diameter)
  {
    const Projection before = point_before(point.i, u, du, 1.0);
    const bool met = std::isfinite(before.gap) && before.rim != Projection::Rim::below;
    const double depth = 0.5 * diameter;
    if (!met || (-at.gap > depth && !(before.gap > -depth)))
    {
      closed = marked;
      _num_implausible += -at.gap > depth;
    }
  }
  return closed == marked;
}

Projection NodeToSurface::point_before(std::size_t i, const double* u, const double* du, double back) const
{
  return adjusted(i, _rigid ? rigid_point(i, u, du, back) : _tracker.locate_before(i, u, du, back));
}

void NodeToSurface::relative_motion(std::size_t i, const Projection& at, const double* u, const double* du,
                                    double* motion) const
{
  const std::size_t node = _candidates.numbers()[i];
  double x[3], increment[3] = {0.0, 0.0, 0.0};
  if (_rigid)
  {
    position(i, u, x);
    obstacle_increment(x, increment);
  }
  for (int c = 0; c < _gdim; ++c)
    motion[c] = du[node * _gdim + c] - increment[c];
  if (_rigid)
    return;
  const surface::Facets& master = _tracker.master();
  double phi[surface::FacetElement::max_nodes];
  master.displacement.values(at.xi, phi);
  for (int j = 0; j < master.displacement.num_nodes(); ++j)
    for (int c = 0; c < _gdim; ++c)
      motion[c] -= phi[j] * du[std::size_t(master.nodes_of(at.facet)[j]) * _gdim + c];
}

bool NodeToSurface::passes_through(ContactPoint& point, const double* u, const double* du)
{
  const std::size_t i = point.i;
  const bool open = _closed[i] == 0;
  const double smallest = _candidates.smallest();
  double motion[3];
  const auto length = [&] { return std::sqrt(std::inner_product(motion, motion + _gdim, motion, 0.0)); };
  if (_rigid)
  {
    relative_motion(i, point.at, u, du, motion);
    if (!(length() > 0.5 * smallest))
      return false;
  }
  const Projection before = point_before(i, u, du, 1.0);
  if ((open && !(before.gap > 0.0)) || !std::isfinite(before.gap))
    return false;
  relative_motion(i, before, u, du, motion);
  const double way = length();
  if (!(way > 0.5 * smallest))
    return false;
  const int parts = int(std::min(std::ceil(2.0 * way / smallest), double(most_parts)));
  Projection first = point.at;
  double back = 0.0;
  for (int k = 1; k < parts && back == 0.0; ++k)
    if (const Projection at = point_before(i, u, du, 1.0 - double(k) / parts); is_below(at))
    {
      first = at;
      back = 1.0 - double(k) / parts;
    }
  if (!is_below(first))
    return false;
  const double along = std::inner_product(motion, motion + _gdim, first.normal, 0.0);
  const double diameter = _rigid ? smallest : _tracker.diameter(first.facet), facets = -along / diameter;
  if (open && facets > 1.0)
  {
    if (facets > _passage.facets)
      _passage = {_candidates.nodes()[i], facets};
    return true;
  }
  first.gap += back * along;
  if (back > 0.0 && first.gap < 0.0 && !(is_below(point.at) && point.at.gap < first.gap + 0.5 * diameter))
    point.at = first;
  return false;
}
} // namespace dolfinx_impact::enforcement
