// SPDX-License-Identifier: MIT
#include "MortarContact.h"
#include "../../common/OnAllRanks.h"
#include "../../common/dolfinx_api.h"
#include "../../common/gather.h"
#include "../../common/vectors.h"
#include "../../gap/crossing.h"
#include "../../gap/nearly_touching.h"
#include "../../gap/obstacle_side.h"
#include "../../gap/search_distance.h"
#include "../../operators/petsc_check.h"
#include "DeformableGeometry.h"
#include "JoinedNodes.h"
#include "RigidGeometry.h"
#include "mortar_messages.h"
#include "node_edges.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/la/Vector.h>
#include <functional>
#include <limits>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Of the largest bound: friction tractions of a converged state are off by less.
constexpr double turned = 1e-6;
/// Stands for an infinite opening in checkpoints, which have numbers only; openings are not negative.
constexpr double no_master = -1.0;
/// Of the bodies' size: a gap of a linearised problem, which is solved to a few digits.
constexpr double penetrates = 1e-6;
/// Of positions.
constexpr double position_round_off = 4 * std::numeric_limits<double>::epsilon();

std::unique_ptr<MortarGeometry> make_geometry(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave,
                                              const MortarContact::Master& master, const MortarOptions& options,
                                              std::vector<std::int8_t> fixed)
{
  std::unique_ptr<MortarGeometry> out;
  if (const auto* facets = std::get_if<surface::Facets>(&master))
    out = std::make_unique<DeformableGeometry>(std::move(V), std::move(slave), *facets, options, std::move(fixed));
  else
  {
    out =
        std::make_unique<RigidGeometry>(std::move(V), std::move(slave), std::get<1>(master), options, std::move(fixed));
    gap::check_side(options.name, out->space(), out->slave(), *out->obstacle());
  }
  out->update_gap(out->increment.start);
  return out;
}

/// Options with a search distance within which layers touch. Collective.
MortarOptions with_reach(MortarOptions options, const surface::FunctionSpace& V, const surface::Facets& slave,
                         const MortarContact::Master& master)
{
  const surface::Facets* facets = std::get_if<surface::Facets>(&master);
  options.search_distance =
      gap::search_distance(V.mesh()->comm(), slave, facets, options.search_distance, options.adjustment.offset);
  return options;
}

gap::InitialPenetration initial_penetration(const MortarOptions& options, const MortarGeometry& g)
{
  return {options.name, g.space(), g.slave(), g.master(), g.now().points, g.now().gap, options.adjustment};
}

/// Multiply a node's block with a vector: gdim*gdim entries.
void apply(const double* block, const double* vector, int gdim, double* out)
{
  for (int a = 0; a < gdim; ++a)
    out[a] = dot(&block[a * gdim], vector, gdim);
}

bool any(MPI_Comm comm, std::span<const double> values)
{
  int found = std::any_of(values.begin(), values.end(), [](double v) { return v != 0.0; });
  MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_INT, MPI_MAX, comm);
  return found;
}
} // namespace

MortarState::MortarState(int gdim, std::size_t num)
    : active(num, 0), sliding(num, 0), direction(num * gdim, 0.0), multiplier(num, 0.0),
      friction_traction(num * gdim, 0.0), traction_n(num * gdim, 0.0), total_slip(num * gdim, 0.0), opening(num, 0.0),
      coefficient(num, 0.0)
{
}

MortarContact::MortarContact(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave,
                             const Master& master, MortarOptions options, std::vector<std::int8_t> fixed)
    : _options(with_reach(std::move(options), *V, slave, master)),
      _geometry(make_geometry(std::move(V), std::move(slave), master, _options, std::move(fixed))),
      _initial(enforcement::initial_penetration(_options, *_geometry)),
      _state(_geometry->gdim(), _geometry->num_nodes()), _coulomb(_geometry->gdim(), _geometry->num_nodes()),
      _usable(_geometry->num_nodes(), 0), _redundant(_usable), _crowded(_usable),
      _nodal_stiffness(_geometry->num_nodes(), 1.0), _facing_stiffness(_geometry->num_nodes(), 0.0)
{
  _geometry->offset = _initial.offset();
  SlaveNodes& n = _geometry->now();
  std::transform(n.gap.begin(), n.gap.end(), _geometry->offset.begin(), n.gap.begin(), std::plus<double>());
  _frames = frames_at(_geometry->gdim(), n.normal, _geometry->fixed());
  _at = _linearised = {n.gap, std::vector<double>(n.normal.size(), 0.0)};
  _linear_tilt.assign(n.normal.size(), 0.0);
  std::ranges::fill(_state.coefficient, _options.friction);
  if (!has_law())
    return;
  if (_options.friction_law->gdim() != _geometry->gdim())
    throw std::invalid_argument("the law of friction is one of another dimension");
  update_coefficients();
}

// --- friction, and nodes that belong to several pairs ----------------------------------------------------------------

void MortarContact::check_without_time() const
{
  if (has_law() && _options.friction_law->has_rates())
    throw std::invalid_argument(name() + ": the law of friction depends on the slip velocity, and a static problem has "
                                         "no time: use a NewmarkProblem, an ExplicitProblem or a RollingProblem");
}

bool MortarContact::has_own_friction() const
{
  return _options.slip == Slip::of_increments && _options.has_friction();
}

bool MortarContact::has_friction() const
{
  return has_own_friction() ||
         std::ranges::any_of(partners, [](const Partner& p) { return p.contact->has_own_friction(); });
}

/// Does a coefficient of this pair, or of one that shares nodes with it, depend on the state?
bool MortarContact::any_law() const
{
  return has_law() || std::ranges::any_of(partners, [](const Partner& p) { return p.contact->has_law(); });
}

double MortarContact::own_friction() const
{
  return has_own_friction() ? (has_law() ? common::largest_modulus(_state.coefficient) : _options.friction) : 0.0;
}

double MortarContact::friction() const
{
  double out = own_friction();
  for (const Partner& p : partners)
    out = std::max(out, p.contact->own_friction());
  return out;
}

/// Coefficients of friction of the nodes [1].
std::vector<double> MortarContact::coefficients() const
{
  if (!_geometry->joined())
    return has_law() ? _state.coefficient : std::vector<double>(_geometry->num_nodes(), own_friction());
  std::vector<double> friction(partners.size() + 1);
  if (!any_law())
  {
    friction[_geometry->member()] = own_friction();
    for (const Partner& p : partners)
      friction[p.contact->_geometry->member()] = p.contact->own_friction();
    return _geometry->joined()->mean(_geometry->member(), friction);
  }
  // Each pair counts by the part of the node's cover that it has.
  const auto part = [&](int member)
  {
    std::ranges::fill(friction, 0.0);
    friction[member] = 1.0;
    return _geometry->joined()->mean(_geometry->member(), friction);
  };
  std::vector<double> out = part(_geometry->member());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] *= has_own_friction() ? _state.coefficient[i] : 0.0;
  for (const Partner& p : partners)
  {
    const std::vector<double> share = part(p.contact->_geometry->member());
    for (std::size_t i = 0; i < out.size(); ++i)
      if (p.index[i] >= 0 && p.contact->has_own_friction())
        out[i] += share[i] * p.contact->_state.coefficient[p.index[i]];
  }
  return out;
}

FrictionPoints MortarContact::law_points() const
{
  const FrictionLaw& law = *_options.friction_law;
  const std::size_t num = _geometry->num_nodes(), g = _geometry->gdim();
  FrictionPoints out = law.make_points(num);
  out.normal = _geometry->now().normal;
  if (law.fields().empty())
    return out;
  dolfinx::la::Vector<double> on_slave(_geometry->map(), 1);
  std::ranges::fill(common::array(on_slave), 0.0);
  for (std::int32_t node : _geometry->slave().nodes)
    common::array(on_slave)[node] = 1.0;
  on_slave.scatter_rev(std::plus<double>());
  for (std::size_t f = 0; f < law.fields().size(); ++f)
  {
    // Means over what a multiplier covers, as those of gaps: the field is a displacement's first component, of the
    // slave alone and of both bodies.
    const std::span<const double> field = law.fields()[f].function->x()->array();
    std::vector<double> slave(std::size_t(_geometry->map()->size_local()) * g, 0.0), both(slave);
    for (std::size_t node = 0; node < both.size() / g; ++node)
    {
      both[node * g] = field[node];
      slave[node * g] = common::array(on_slave)[node] > 0.0 ? field[node] : 0.0;
    }
    const std::vector<double> here = _geometry->jump(slave), jump = _geometry->jump(both);
    for (std::size_t i = 0; i < num; ++i)
    {
      const bool faces = std::isfinite(here[i * g]);
      out.slave_fields[f][i] = faces ? here[i * g] : field[nodes()[i]];
      out.master_fields[f][i] = faces && !_geometry->obstacle() ? here[i * g] - jump[i * g] : 0.0;
    }
  }
  return out;
}

FrictionCoefficients MortarContact::law_coefficients(std::span<const double> pressure,
                                                     std::span<const double> slip_rate) const
{
  FrictionPoints points = law_points();
  points.pressure.assign(pressure.begin(), pressure.end());
  points.slip_rate.assign(slip_rate.begin(), slip_rate.end());
  FrictionCoefficients out;
  _options.friction_law->evaluate(points, out);
  long long unknown = 0;
  for (std::size_t i = 0; i < out.value.size(); ++i)
    unknown += _usable[i] && !std::isfinite(out.value[i]);
  if (unknown = common::sum(_geometry->comm(), unknown); unknown > 0)
    throw common::BadValue(name() + ": the law of friction returns no finite number at " + std::to_string(unknown) +
                           " nodes");
  return out;
}

/// Coefficients of the law at the present pressures and slips. Collective.
void MortarContact::update_coefficients()
{
  std::vector<double> pressure(_state.multiplier), slip_rate(_linearised.slip);
  const std::size_t g = _geometry->gdim();
  for (std::size_t i = 0; i < pressure.size(); ++i)
    pressure[i] = _usable[i] ? std::max(pressure[i], 0.0) : 0.0;
  for (std::size_t k = 0; k < slip_rate.size(); ++k)
    slip_rate[k] = _time_step > 0.0 && _usable[k / g] ? slip_rate[k] / _time_step : 0.0;
  _state.coefficient = law_coefficients(pressure, slip_rate).value;
}

/// Joined nodes have the state of their carrier in all contacts.
void MortarContact::tell_partners()
{
  const std::size_t g = _geometry->gdim();
  for (const Partner& p : partners)
  {
    MortarContact& other = *p.contact;
    for (std::size_t i = 0; i < p.index.size(); ++i)
    {
      const std::int32_t at = p.index[i];
      if (at < 0 || !_geometry->now().carrier[i] || other._geometry->now().carrier[at])
        continue;
      other._state.active[at] = _state.active[i];
      other._state.sliding[at] = _state.sliding[i];
      other._state.multiplier[at] = _state.multiplier[i];
      const auto tell = [&](const std::vector<double>& from, std::vector<double>& to)
      { std::copy_n(&from[i * g], g, &to[at * g]); };
      tell(_state.direction, other._state.direction);
      tell(_state.friction_traction, other._state.friction_traction);
      tell(_state.traction_n, other._state.traction_n);
      tell(_state.total_slip, other._state.total_slip);
      if (has_friction())
        tell(_coulomb.imposed, other._coulomb.imposed);
    }
  }
}

/// Nodes at which this pair is in contact: an active node that pairs share need not lie on both.
std::vector<std::int8_t> MortarContact::touching() const
{
  std::vector<std::int8_t> out(_state.active);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = out[i] && _geometry->now().part[i];
  return out;
}

/// Nodes at which this pair has a force.
std::vector<std::int8_t> MortarContact::loaded() const
{
  std::vector<std::int8_t> out = touching();
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = out[i] && _frames.place[i] >= 0;
  return out;
}

/// Projectors on directions without slip: locked ones, and those that other contacts hold.
std::vector<double> MortarContact::still() const
{
  std::vector<double> out = held_by_others(*this);
  if (!has_friction())
    return out;
  if (out.empty())
    return _coulomb.locked();
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = _coulomb.locked()[k] + out[k];
  return out;
}

// --- load steps ------------------------------------------------------------------------------------------------------

state::State MortarContact::state()
{
  const int g = _geometry->gdim();
  state::State out(name());
  out.at(state::Place::node, {nodes().begin(), nodes().end()});
  out.add("active", state::Place::node, _state.active).add("sliding", state::Place::node, _state.sliding);
  out.add("multiplier", state::Place::node, _state.multiplier).add("opening", state::Place::node, _state.opening);
  out.add("direction", state::Place::node, _state.direction, g);
  out.add("friction_traction", state::Place::node, _state.friction_traction, g);
  out.add("traction_n", state::Place::node, _state.traction_n, g);
  out.add("total_slip", state::Place::node, _state.total_slip, g);
  out.add("imposed", state::Place::node, _coulomb.imposed, g);
  if (has_law())
    out.add("coefficient", state::Place::node, _state.coefficient);
  out.add("begun", state::Place::all, _state.begun);
  out.add(_geometry->state());
  return out;
}

state::State MortarContact::saved_state()
{
  std::vector<std::string> names = {"active",     "sliding",    "multiplier",
                                    "opening",    "direction",  "friction_traction",
                                    "traction_n", "total_slip", "imposed"};
  if (has_law())
    names.push_back("coefficient");
  state::State out = state().copy_of(names);
  for (double& opening : out.values<double>("opening"))
    opening = std::isfinite(opening) ? opening : no_master;
  _totals.add_to(out, _geometry->gdim());
  const auto& place = _geometry->increment.displacement;
  out.add_own("master", state::Place::all, std::vector<double>(place.begin(), place.end()));
  if (_geometry->turns())
  {
    const gap::Matrix3& turned = _geometry->increment.rotation;
    out.add_own("rotation", state::Place::all, std::vector<double>(turned.begin(), turned.end()), 9);
  }
  return out;
}

void MortarContact::resume(const state::State& saved, std::span<const double> u)
{
  std::optional<std::array<double, 3>> place;
  if (_geometry->obstacle())
    std::ranges::copy(saved.values<double>("master"), place.emplace().begin());
  std::optional<gap::Matrix3> rotation;
  if (_geometry->turns())
    std::ranges::copy(saved.values<double>("rotation"), rotation.emplace().begin());
  _geometry->begin_step(u, place, {}, rotation);
  update_gap(u);
  state().assign_common(saved);
  for (double& opening : _state.opening)
    opening = opening == no_master ? std::numeric_limits<double>::infinity() : opening;
  _totals.resume(saved, _state.total_slip);
  _state.begun = _totals.known; // an increment has been accepted
}

std::vector<double> MortarContact::opened(std::span<const double> gap) const
{
  std::vector<double> out(gap.size());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = !_state.active[i] && gap[i] > _geometry->tolerance() ? gap[i] : 0.0;
  return out;
}

void MortarContact::begin_step(std::span<const double> u, const std::optional<std::array<double, 3>>& displacement,
                               std::span<const double> target)
{
  std::fill(_crowded.begin(), _crowded.end(), std::int8_t(0));
  if (!_state.begun)
  {
    _geometry->update_gap(u);
    std::ranges::copy(opened(_geometry->now().gap), _state.opening.begin());
    _state.begun = 1;
  }
  _geometry->begin_step(u, displacement, target, _next_rotation);
  _next_rotation.reset();
}

void MortarContact::set_rotation(const gap::Matrix3& rotation)
{
  if (!_geometry->turns())
    throw std::invalid_argument(name() + ": the master does not turn: it was not made as one that rotates");
  _next_rotation = rotation;
}

std::optional<gap::Matrix3> MortarContact::rotation() const
{
  return _geometry->turns() ? std::optional(_geometry->increment.rotation) : std::nullopt;
}

std::array<double, 3> MortarContact::centre() const
{
  return _geometry->obstacle() ? _geometry->obstacle()->centre : std::array<double, 3>{};
}

std::optional<std::array<double, 3>> MortarContact::displacement() const
{
  if (!_geometry->obstacle())
    return std::nullopt;
  return _geometry->increment.displacement;
}

void MortarContact::accept_step()
{
  const int g = _geometry->gdim();
  const std::vector<double> still = this->still(), friction = coefficients(); // along locked directions nothing slips
  for (std::size_t i = 0; i < _geometry->num_nodes(); ++i)
  {
    const double* moved = &_linearised.slip[i * g];
    double slip[3], held[3] = {0.0, 0.0, 0.0};
    if (!still.empty())
      apply(&still[i * g * g], moved, g, held);
    for (int a = 0; a < g; ++a)
      slip[a] = moved[a] - held[a];
    // Less what a node slides before it closes.
    double part = 1.0;
    if (_state.opening[i] > 0.0)
    {
      const double free = std::isfinite(_state.opening[i]) ? _state.opening[i] * friction[i] : 0.0;
      part = std::max(0.0, 1.0 - free / std::max(std::sqrt(dot(slip, slip, g)), 1e-300));
    }
    for (int a = 0; a < g; ++a)
      _state.total_slip[i * g + a] = _state.active[i] ? _state.total_slip[i * g + a] + part * slip[a] : 0.0;
  }
  tell_partners();
  std::ranges::copy(opened(_linearised.gap), _state.opening.begin());
  for (std::size_t k = 0; k < _state.traction_n.size(); ++k)
    _state.traction_n[k] = _state.active[k / g] ? _state.friction_traction[k] : 0.0;
  update_totals();
}

void MortarContact::update_totals()
{
  const std::vector<double> traction = this->traction(), covered = this->covered();
  const std::vector<ContactStatus> status = this->status();
  _totals.update(_geometry->comm(), {.gdim = _geometry->gdim(),
                                     .x = _geometry->now().points,
                                     .traction = traction,
                                     .slip = _state.total_slip,
                                     .status = status,
                                     .weight = _geometry->now().own_cover,
                                     .covered = covered});
}

std::string MortarContact::prescribed_overlap()
{
  std::vector<std::int8_t> prescribed(_geometry->now().participates);
  for (std::size_t i = 0; i < prescribed.size(); ++i)
    prescribed[i] = prescribed[i] && _frames.place[i] < 0;
  return describe_overlap(name(), *_geometry, prescribed, _initial.depth());
}

std::string MortarContact::passed_through()
{
  const SlaveNodes& n = _geometry->now();
  const int g = _geometry->gdim();
  std::vector<std::int8_t> passed(_geometry->num_nodes());
  if (const gap::Rigid* given = _geometry->obstacle())
  {
    gap::Rigid obstacle = *given;
    const MortarIncrement& step = _geometry->increment;
    obstacle.displacement = step.displacement;
    obstacle.rotation = step.rotation;
    const std::vector<double> carried = _geometry->motion_of_master();
    std::vector<double> before(n.points);
    for (std::size_t i = 0; i < passed.size(); ++i)
      for (int c = 0; c < g; ++c)
      {
        const std::size_t dof = std::size_t(nodes()[i]) * g + c;
        before[i * g + c] -= n.u[dof] - step.start[dof] - carried[i * g + c];
      }
    passed = gap::through_obstacle(obstacle, before, n.points, _geometry->offset, _geometry->tolerance());
  }
  else
  {
    for (std::size_t i = 0; i < passed.size(); ++i)
      passed[i] = _state.begun && std::isfinite(_state.opening[i]) && !n.participates[i];
    passed = gap::through_master(_geometry->comm(), passed, _geometry->facet_sizes(),
                                 [&](double fraction) { return _geometry->gap_on_the_way(fraction); });
  }
  return gap::describe_crossing(name(), _geometry->comm(), g, n.points, passed);
}

// --- Newton iterations -----------------------------------------------------------------------------------------------

void MortarContact::update_gap(std::span<const double> u)
{
  _geometry->update_gap(u);
  const SlaveNodes& n = _geometry->now();
  _frames = frames_at(_geometry->gdim(), n.normal, _geometry->fixed());
  align_frames(*this, _frames);
  for (std::size_t i = 0; i < _usable.size(); ++i)
    _usable[i] = n.participates[i] && _frames.place[i] >= 0 && n.carrier[i];
  std::fill(_redundant.begin(), _redundant.end(), std::int8_t(0));
  _at = _linearised = {n.gap, _geometry->slip()};
  if (has_friction())
    _coulomb.update_directions(_usable, linearisation().nodes, n.locked);
}

MortarContact::Present MortarContact::present() const
{
  Present out;
  out.stiffness = _nodal_stiffness;
  for (std::size_t i = 0; i < _usable.size(); ++i)
    out.stiffness[i] /= _usable[i] ? _geometry->now().weight[i] : 1.0;
  out.lock = still();
  const bool varies = any_law();
  const double largest = varies ? 1.0 : friction();
  if (varies || (!partners.empty() && largest > 0.0))
  {
    out.roughness = coefficients();
    for (double& value : out.roughness)
      value /= largest;
  }
  out.nodes = {.gdim = _geometry->gdim(),
               .friction = largest,
               .usable = _usable,
               .active = _state.active,
               .gap = _linearised.gap,
               .multiplier = _state.multiplier,
               .sliding = _state.sliding,
               .slip = _linearised.slip,
               .traction = _state.friction_traction,
               .direction = _state.direction,
               .opening = _state.begun ? std::span<const double>(_state.opening) : std::span<const double>(),
               .stiffness = out.stiffness,
               .lock = out.lock,
               .roughness = out.roughness};
  return out;
}

MortarContact::Linearisation MortarContact::linearisation() const
{
  const SlaveNodes& n = _geometry->now();
  std::vector<double> ahead = _geometry->ahead();
  const std::span<const double> view(ahead);
  return {std::move(ahead),
          {.nodes = _geometry->nodes(),
           .normal = n.normal,
           .gap = _at.gap,
           .slip = _at.slip,
           .weight = n.weight,
           .cover = n.cover,
           .fixed = _geometry->fixed(),
           .ahead = view,
           .frames = _frames}};
}

double MortarContact::largest_multiplier() const
{
  double here = 0.0;
  for (double value : _state.multiplier)
    here = std::max(here, value);
  return common::largest(_geometry->comm(), here);
}

int MortarContact::update_active_set(bool first, std::optional<std::int64_t> last)
{
  const std::size_t num = _geometry->num_nodes(), g = _geometry->gdim();
  if (has_law() && !first)
    update_coefficients();
  const double largest = largest_multiplier(), tolerance = _geometry->tolerance();
  for (std::size_t i = 0; i < num; ++i)
    _crowded[i] |= _redundant[i] && _state.active[i] && _linearised.gap[i] < -penetrates * _geometry->size();
  std::vector<std::int8_t> was_stuck(num), changed(num);
  ActiveSet found;
  {
    const Present now = present();
    found = enforcement::update_active_set(now.nodes, first, tolerance, largest);
    for (std::size_t i = 0; i < num && has_friction() && !first; ++i)
      was_stuck[i] = sticks(now.nodes, i);
  }
  std::int64_t latest = -1;
  for (std::size_t i = 0; i < num; ++i)
  {
    // A node whose condition was left out has no multiplier to open it.
    const bool opens = _redundant[i] && _linearised.gap[i] > tolerance;
    const std::int8_t active = found.active[i] && !opens, sliding = found.sliding[i] && !opens;
    const bool own = _geometry->now().carrier[i];
    changed[i] = own && (active != _state.active[i] || sliding != _state.sliding[i]);
    if (changed[i])
      latest = std::max(latest, numbers()[i]);
    if (!own || (last && numbers()[i] != *last))
      continue;
    _state.active[i] = active;
    _state.sliding[i] = sliding;
    std::copy_n(&found.direction[i * g], g, &_state.direction[i * g]);
  }
  MPI_Allreduce(MPI_IN_PLACE, &latest, 1, MPI_INT64_T, MPI_MAX, _geometry->comm());
  _last_change = latest;
  if (has_friction() && !first)
  {
    const std::vector<std::int8_t> other = _coulomb.update_imposed(present().nodes, was_stuck, _state.traction_n);
    for (std::size_t i = 0; i < num; ++i)
      changed[i] |= other[i];
  }
  tell_partners();
  return int(common::sum(_geometry->comm(), (long long)std::count(changed.begin(), changed.end(), 1)));
}

void MortarContact::add_residual(Vec b) const
{
  operators::subtract(contact_forces(), b);
}

void MortarContact::update_nodal_stiffness(Mat K)
{
  std::array<std::vector<double>, 2> found = _geometry->diagonal_stiffness(K);
  _nodal_stiffness = std::move(found[0]);
  _facing_stiffness = std::move(found[1]);
}

Mat MortarContact::tangent()
{
  return _geometry->tangent(_state.multiplier, traction(), loaded());
}

std::int64_t MortarContact::num_active() const
{
  const std::vector<std::int8_t> on = touching();
  return common::sum(_geometry->comm(), (long long)std::count(on.begin(), on.end(), 1));
}

double MortarContact::violation() const
{
  const Violations found = violations(present().nodes, _geometry->now().gap);
  double here = 0.0;
  for (const auto* values : {&found.gap, &found.slip})
    for (double value : *values)
      here = std::max(here, value);
  return common::largest(_geometry->comm(), here) / _geometry->size();
}

std::string MortarContact::largest_violation() const
{
  const Present now = present();
  return describe_violation(name(), *_geometry, violations(now.nodes, _geometry->now().gap));
}

std::string MortarContact::mesh_advice() const
{
  return describe_sharp_edge(name(), *_geometry);
}

double MortarContact::smallest_gap() const
{
  double here = std::numeric_limits<double>::infinity();
  for (double gap : _geometry->now().gap)
    here = std::min(here, gap);
  return -common::largest(_geometry->comm(), -here);
}

std::vector<double> MortarContact::rigid_body_products(const operators::RigidBodyModes& modes) const
{
  const int g = _geometry->gdim(), num = modes.num_modes();
  std::vector<std::int32_t> held;
  for (std::size_t i = 0; i < _usable.size(); ++i)
    if (_state.active[i] && _usable[i])
      held.push_back(std::int32_t(i));
  const std::vector<double> jumps = _geometry->rigid_body_jumps(modes, held);
  std::vector<double> out(std::size_t(num) * num, 0.0), along(num);
  const auto add = [&](const double* row)
  {
    for (int i = 0; i < num; ++i)
      for (int j = 0; j < num; ++j)
        out[i * num + j] += row[i] * row[j];
  };
  for (std::size_t k = 0; k < held.size(); ++k)
  {
    const double *normal = &_geometry->now().normal[held[k] * g], *rows = &jumps[k * g * num];
    // Nothing holds a node along the surface without friction, or that closes only in this increment.
    if (!has_friction() || (_state.begun && _state.opening[held[k]] > 0.0))
    {
      std::fill(along.begin(), along.end(), 0.0);
      for (int a = 0; a < g; ++a)
        for (int i = 0; i < num; ++i)
          along[i] += normal[a] * rows[a * num + i];
      add(along.data());
    }
    else
      for (int a = 0; a < g; ++a)
        add(&rows[a * num]);
  }
  return out;
}

bool MortarContact::close_nearest()
{
  const std::vector<double>& gap = _geometry->now().gap;
  const std::optional<double> near = gap::nearly_touching(_geometry->comm(), gap, _geometry->facet_sizes());
  if (!near)
    return false;
  for (std::size_t i = 0; i < gap.size(); ++i)
    _state.active[i] |= gap[i] < *near && _usable[i];
  tell_partners();
  return true;
}

void MortarContact::open_apart()
{
  const int g = _geometry->gdim();
  const std::vector<double>& gap = _geometry->now().gap;
  for (std::size_t i = 0; i < gap.size(); ++i)
  {
    if (!_state.active[i] || gap[i] <= _geometry->tolerance())
      continue;
    _state.active[i] = _state.sliding[i] = 0;
    _state.multiplier[i] = 0.0;
    std::fill_n(&_state.friction_traction[i * g], g, 0.0);
    std::fill_n(&_state.traction_n[i * g], g, 0.0);
  }
  tell_partners();
}

// --- linear problems -------------------------------------------------------------------------------------------------

std::vector<double> MortarContact::at_nodes(std::span<const double> values) const
{
  const std::size_t g = _geometry->gdim();
  if (values.size() != std::size_t(_geometry->map()->size_local()) * g)
    throw std::invalid_argument("a value of every owned degree of freedom of the space is needed");
  std::vector<double> out(_geometry->num_nodes() * g);
  for (std::size_t i = 0; i < _geometry->num_nodes(); ++i)
    std::copy_n(&values[std::size_t(nodes()[i]) * g], g, &out[i * g]);
  return out;
}

/// Friction traction per pressure of nodes that slip or have closed in this increment; else zero.
std::vector<double> MortarContact::tilt() const
{
  return has_friction() ? friction_tilt(present().nodes)
                        : std::vector<double>(_geometry->num_nodes() * _geometry->gdim(), 0.0);
}

Constraints MortarContact::constraints()
{
  _linear_tilt = tilt();
  const Present now = present();
  return constrain(now.nodes, linearisation().nodes, _linear_tilt,
                   _geometry->master_rows(constrained_nodes(now.nodes)));
}

std::optional<std::pair<Mat, std::vector<double>>> MortarContact::friction_springs()
{
  if (!has_friction())
    return std::nullopt;
  _coulomb.set_edges(held_by_others(*this));
  const Present now = present();
  const CoulombFriction::Springs springs =
      _coulomb.update_springs(now.nodes, linearisation().nodes, _nodal_stiffness, _facing_stiffness);
  const bool imposed = any(_geometry->comm(), _coulomb.imposed);
  if (common::sum(_geometry->comm(), (long long)springs.rows.size()) == 0 && !imposed)
    return std::nullopt;
  return std::pair{_geometry->springs(springs.rows, springs.blocks), _geometry->joined_forces(springs.traction)};
}

std::vector<double> MortarContact::imposed_friction_forces() const
{
  if (!has_friction() || !any(_geometry->comm(), _coulomb.imposed))
    return {};
  return _geometry->joined_forces(_coulomb.imposed);
}

void MortarContact::update_linearised_gap(std::span<const double> increments)
{
  add_jump(linearisation().nodes, _geometry->jump(increments), _linearised.gap, _linearised.slip);
  if (has_friction())
    _coulomb.raise_imposed(present().nodes);
}

std::pair<std::vector<double>, std::vector<double>>
MortarContact::linearised_response(std::span<const double> increments, std::span<const double> forces) const
{
  const int g = _geometry->gdim();
  const std::vector<double> jump = _geometry->jump(increments);
  std::vector<double> gap(_geometry->num_nodes());
  for (std::size_t i = 0; i < gap.size(); ++i)
    gap[i] = dot(&_geometry->now().normal[i * g], &jump[i * g], g);
  return {std::move(gap), normal_tractions(_usable, linearisation().nodes, at_nodes(forces))};
}

void MortarContact::predict_active_set(std::span<const double> increments, double part)
{
  if (has_friction())
    return;
  const int g = _geometry->gdim();
  const std::vector<double> jump = _geometry->jump(increments);
  const SlaveNodes& n = _geometry->now();
  std::vector<double> overlap(_geometry->num_nodes(), 0.0);
  double deepest = 0.0;
  for (std::size_t i = 0; i < overlap.size(); ++i)
  {
    if (!_usable[i])
      continue;
    overlap[i] = -n.gap[i] - dot(&n.normal[i * g], &jump[i * g], g);
    deepest = std::max(deepest, overlap[i]);
  }
  deepest = common::largest(_geometry->comm(), deepest);
  if (deepest <= _geometry->tolerance())
    return;
  for (std::size_t i = 0; i < overlap.size(); ++i)
    _state.active[i] |= _usable[i] && overlap[i] > part * deepest;
  tell_partners();
}

void MortarContact::correct_linearisation(std::span<const double> u)
{
  const GapAndSlip there = _geometry->evaluate_at(u);
  GapAndSlip corrected = _at;
  add_linearisation_error(present().nodes, linearisation().nodes, there.gap, there.slip, corrected.gap, corrected.slip);
  _at = std::move(corrected);
}

void MortarContact::update_multipliers(std::span<const double> residual)
{
  const bool friction = has_friction();
  const Present now = present();
  std::vector<double> multiplier(_geometry->num_nodes()), traction(_state.friction_traction), known, follow;
  if (friction)
  {
    known = _coulomb.known_tractions(now.nodes);
    follow = _coulomb.prescribed();
  }
  evaluate_multipliers(now.nodes, linearisation().nodes, at_nodes(residual),
                       friction && _coulomb.has_springs() ? _linear_tilt : tilt(), known, follow, multiplier, traction);
  set(multiplier, traction);
}

void MortarContact::set_multipliers(std::span<const double> forces)
{
  const Present now = present();
  std::vector<double> multiplier(_geometry->num_nodes()), traction(_state.friction_traction.size());
  take_multipliers(now.nodes, linearisation().nodes, forces, _linear_tilt, _coulomb.known_tractions(now.nodes),
                   multiplier, traction);
  set(multiplier, traction);
}

/// Take over multipliers and friction tractions at the nodes that are this contact's, and tell its partners.
void MortarContact::set(std::span<const double> multiplier, std::span<const double> traction)
{
  const std::size_t g = _geometry->gdim();
  for (std::size_t i = 0; i < _geometry->num_nodes(); ++i)
    if (_geometry->now().carrier[i])
    {
      _state.multiplier[i] = multiplier[i];
      std::copy_n(&traction[i * g], g, &_state.friction_traction[i * g]);
    }
  tell_partners();
}

void MortarContact::rotate_friction_traction()
{
  const Present now = present();
  set(_state.multiplier, enforcement::rotate_friction_traction(now.nodes, _geometry->now().normal));
}

std::int64_t MortarContact::num_turning() const
{
  const int g = _geometry->gdim();
  const bool varies = any_law(); // then the size of a traction may be another one, too
  if (!has_friction() || (g == 2 && !varies))
    return 0;
  const std::vector<double> friction = coefficients(), still = this->still();
  const double bound = turned * common::largest(_geometry->comm(), this->friction()) * largest_multiplier();
  long long number = 0;
  for (std::size_t i = 0; i < _geometry->num_nodes(); ++i)
  {
    if (!_state.active[i] || !_usable[i] || !_state.sliding[i])
      continue;
    const double* traction = &_state.friction_traction[i * g];
    double held[3], error[3];
    apply(&still[i * g * g], traction, g, held);
    for (int a = 0; a < g; ++a)
      error[a] = traction[a] - held[a] - friction[i] * _state.multiplier[i] * _state.direction[i * g + a];
    number += std::sqrt(dot(error, error, g)) > bound;
  }
  return common::sum(_geometry->comm(), number);
}

void MortarContact::set_redundant(std::span<const std::int32_t> redundant)
{
  std::fill(_redundant.begin(), _redundant.end(), std::int8_t(0));
  for (std::int32_t i : redundant)
    _redundant.at(i) = 1;
}

std::vector<std::int32_t> MortarContact::over_constrained() const
{
  std::vector<std::int32_t> out;
  for (std::size_t i = 0; i < _crowded.size(); ++i)
    if (_crowded[i])
      out.push_back(nodes()[i]);
  return out;
}

double MortarContact::gap_round_off() const
{
  const int g = _geometry->gdim();
  const SlaveNodes& n = _geometry->now();
  double squared = 0.0;
  for (std::size_t i = 0; i < _geometry->num_nodes(); ++i)
  {
    if (!n.carrier[i])
      continue;
    const double distance = std::sqrt(dot(&n.points[i * g], &n.points[i * g], g));
    const double force = (_nodal_stiffness[i] + _facing_stiffness[i]) * (position_round_off * distance);
    squared += force * force;
  }
  return std::sqrt(common::sum(_geometry->comm(), squared));
}

std::vector<double> MortarContact::unit_gap(std::int64_t number) const
{
  const std::size_t g = _geometry->gdim();
  std::vector<double> out(std::size_t(_geometry->map()->size_local()) * g, 0.0);
  for (std::size_t i = 0; i < _geometry->num_nodes(); ++i)
    for (std::size_t a = 0; a < g && numbers()[i] == number && _frames.place[i] >= 0; ++a)
      out[std::size_t(nodes()[i]) * g + a] = _frames.frames[(i * g + a) * g + _frames.place[i]] / _frames.length[i];
  return out;
}

std::vector<double> MortarContact::unit_force(std::int64_t number) const
{
  std::vector<double> traction(_geometry->now().normal);
  for (std::size_t k = 0; k < traction.size(); ++k)
    traction[k] = numbers()[k / _geometry->gdim()] == number ? traction[k] : 0.0;
  return _geometry->forces(traction);
}

void MortarContact::set_linearised(std::span<const std::int8_t> active, std::span<const double> gap,
                                   std::span<const double> multiplier)
{
  const std::size_t num = _geometry->num_nodes();
  if (active.size() != num || gap.size() != num || multiplier.size() != num)
    throw std::invalid_argument("a status, a gap and a multiplier of every node are needed");
  std::ranges::copy(active, _state.active.begin());
  _linearised.gap.assign(gap.begin(), gap.end());
  std::ranges::copy(multiplier, _state.multiplier.begin());
}

// --- results ---------------------------------------------------------------------------------------------------------

std::vector<double> MortarContact::pressure() const
{
  const std::vector<std::int8_t> on = touching();
  std::vector<double> out(on.size());
  for (std::size_t i = 0; i < on.size(); ++i)
    out[i] = on[i] ? std::max(_state.multiplier[i], 0.0) : 0.0;
  return out;
}

std::vector<double> MortarContact::traction() const
{
  const std::vector<std::int8_t> on = touching();
  const std::size_t g = _geometry->gdim();
  std::vector<double> out(on.size() * g);
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = on[k / g] ? _state.multiplier[k / g] * _geometry->now().normal[k] + _state.friction_traction[k] : 0.0;
  return out;
}

std::vector<ContactStatus> MortarContact::status() const
{
  const std::vector<std::int8_t> on = touching();
  std::vector<ContactStatus> out(on.size(), ContactStatus::open);
  for (std::size_t i = 0; i < on.size(); ++i)
    if (on[i])
      out[i] = _state.sliding[i] || !has_own_friction() ? ContactStatus::slip : ContactStatus::stick;
  return out;
}

std::vector<double> MortarContact::covered() const
{
  return _geometry->part_in_contact(pressure(), loaded());
}
} // namespace dolfinx_impact::enforcement
