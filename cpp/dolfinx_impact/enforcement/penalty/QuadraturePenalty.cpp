// SPDX-License-Identifier: MIT
#include "QuadraturePenalty.h"
#include "../../common/text.h"
#include "../../gap/crossing.h"
#include "../../gap/mortar.h"
#include "../../gap/nearly_touching.h"
#include "../../gap/obstacle_side.h"
#include "../../gap/rotation.h"
#include "../../gap/search_distance.h"
#include "../../operators/body_size.h"
#include "../../operators/nodal_sums.h"
#include "automatic_penalty.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
namespace
{
constexpr double infinity = std::numeric_limits<double>::infinity();
/// Gaps below this part of the bodies' size count as closed, so that round-off does not decide at first contact.
constexpr double touch = 1e-12;
/// A slave is much coarser than its master from this ratio of the sizes of their facets on.
constexpr double coarse = 2.0;
/// Least cosine between a master's normal and the slave's inward one where the surfaces face each other. Beside the rim
/// the direction to the master lies along the slave, cosine zero; where surfaces touch, normals differ by a facet's
/// turn.
constexpr double least_facing = 0.5;
/// Part of the bodies' size below which a change of closest points is round-off.
constexpr double still = 1e-12;
/// General contact: points of both sides bear half of the pressure each.
constexpr double share_of_side = 0.5;
/// General contact: penetration of a converged state over the height of the cell behind the facet.
constexpr double deepest_part = 0.5;

/// Diagonal of the box around each facet in the reference configuration [L].
std::vector<double> facet_sizes(const surface::Facets& facets)
{
  const int n = facets.geometry.num_nodes(), gdim = facets.gdim;
  std::vector<double> out(facets.size());
  for (std::size_t f = 0; f < out.size(); ++f)
  {
    double squared = 0.0;
    for (int c = 0; c < gdim; ++c)
    {
      double low = infinity, high = -infinity;
      for (int i = 0; i < n; ++i)
      {
        low = std::min(low, facets.X_of(f)[i * gdim + c]);
        high = std::max(high, facets.X_of(f)[i * gdim + c]);
      }
      squared += (high - low) * (high - low);
    }
    out[f] = std::sqrt(squared);
  }
  return out;
}

/// Sizes of the facets of the points.
std::vector<double> point_sizes(const surface::Facets& facets, const gap::Points& points)
{
  const std::vector<double> sizes = facet_sizes(facets);
  std::vector<double> out(points.size());
  for (std::size_t q = 0; q < out.size(); ++q)
    out[q] = sizes[points.facet[q]];
  return out;
}

std::vector<double> difference(std::span<const double> a, std::span<const double> b)
{
  std::vector<double> out(a.size());
  std::transform(a.begin(), a.end(), b.begin(), out.begin(), std::minus<double>());
  return out;
}

/// Move a point that was there at the start of the increment as the master has moved in it.
void move_with_master(const RigidIncrement& rigid, int gdim, double* x)
{
  // The identity less `turn` is the inverse of the rotation of the increment.
  double arm[3] = {}, out[3] = {};
  for (int c = 0; c < gdim; ++c)
    arm[c] = x[c] + rigid.displacement[c] - rigid.centre[c];
  for (int c = 0; c < gdim; ++c)
  {
    out[c] = x[c] + rigid.displacement[c];
    for (int d = 0; d < gdim; ++d)
      out[c] -= rigid.turn[3 * d + c] * arm[d];
  }
  std::copy_n(out, gdim, x);
}

const PenaltyOptions& checked(const PenaltyOptions& o)
{
  if (o.penalty < 0.0 || o.tangential < 0.0 || o.friction < 0.0 || !(o.tolerance > 0.0) || o.max_augmentations < 1)
    throw std::invalid_argument("penalties and friction are not negative, a tolerance and max_augmentations positive");
  if (o.law && (o.penalty > 0.0 || o.tangential > 0.0 || o.friction > 0.0 || o.augmented))
    throw std::invalid_argument("a law of the interface stands in the place of penalties, friction and augmentation");
  return o;
}

/// Options with a search distance within which layers touch. Collective.
PenaltyForces made_forces(const PenaltyForces::Setup& setup, const std::shared_ptr<gap::Rigid>& rigid,
                          std::unique_ptr<search::GeneralSearch> general, const surface::Facets* master,
                          double search_distance)
{
  if (general)
    return PenaltyForces(setup, std::move(general));
  return rigid ? PenaltyForces(setup, rigid) : PenaltyForces(setup, *master, search_distance);
}

PenaltyOptions with_reach(PenaltyOptions o, MPI_Comm comm, const surface::Facets& slave, const surface::Facets* master)
{
  o.search_distance = gap::search_distance(comm, slave, master, o.search_distance, o.adjustment.offset);
  return o;
}
} // namespace

QuadraturePenalty::QuadraturePenalty(std::string name, std::shared_ptr<const surface::FunctionSpace> V,
                                     surface::Facets slave, std::optional<surface::Facets> master,
                                     std::shared_ptr<gap::Rigid> rigid, std::unique_ptr<search::GeneralSearch> general,
                                     const PenaltyOptions& options, TangentFunction bodies)
    : _name(std::move(name)), _space(std::move(V)),
      _options(with_reach(checked(options), _space->mesh()->comm(), slave, master ? &*master : nullptr)),
      _bodies(std::move(bodies)), _slave(std::move(slave)), _master(std::move(master)), _rigid(std::move(rigid)),
      _size(operators::body_size(*_space->mesh())),
      _rule(surface::quadrature(_slave.displacement.shape, _options.quadrature_degree > 0
                                                               ? _options.quadrature_degree
                                                               : 2 * _slave.displacement.degree + 2)),
      _forces(made_forces({_space, _slave, _rule.points, _rule.weights, _options.axisymmetric, _options.law}, _rigid,
                          std::move(general), _master ? &*_master : nullptr, _options.search_distance)),
      _uzawa(_space->dofmap()->index_map, _slave, _rule), _penalty(_options.penalty), _tangential(_options.tangential)
{
  const auto map = _space->dofmap()->index_map;
  _forces.parameters.friction = _options.friction;
  _start.assign(std::size_t(map->size_local() + map->num_ghosts()) * _slave.gdim, 0.0);
  _u = _start;
  _touched.assign(at().size(), 0);
  _last_status.assign(at().size(), ContactStatus::open);
  if (_rigid)
    gap::check_side(_name, *_space, _slave, *_rigid);
  else
  {
    _keeper.emplace(comm());
    _keeper->begin(_forces.points().margin);
  }
  if (this->general())
    refuse_overlap();
  locate(_start);
  std::vector<double> over_master = at().gap; // infinite beside it
  for (std::size_t q = 0; q < over_master.size(); ++q)
    if (at().beside[q])
      over_master[q] = std::numeric_limits<double>::infinity();
  _initial.emplace(_name, *_space, _slave, _master ? &*_master : nullptr, at().x, over_master, _options.adjustment);
  _forces.history.offset = _initial->offset();
  _gap_before = facing_gap();
}

QuadraturePenalty::QuadraturePenalty(std::string name, std::shared_ptr<const surface::FunctionSpace> V,
                                     surface::Facets slave, surface::Facets master, const PenaltyOptions& options,
                                     TangentFunction bodies)
    : QuadraturePenalty(std::move(name), std::move(V), std::move(slave), std::optional(std::move(master)), nullptr,
                        nullptr, options, std::move(bodies))
{
}

QuadraturePenalty::QuadraturePenalty(std::string name, std::shared_ptr<const surface::FunctionSpace> V,
                                     surface::Facets slave, gap::Rigid master, const PenaltyOptions& options,
                                     TangentFunction bodies)
    : QuadraturePenalty(std::move(name), std::move(V), std::move(slave), std::nullopt,
                        std::make_shared<gap::Rigid>(std::move(master)), nullptr, options, std::move(bodies))
{
}

QuadraturePenalty::QuadraturePenalty(std::string name, std::shared_ptr<const surface::FunctionSpace> V,
                                     surface::Facets facets, std::span<const search::NamedPair> named,
                                     const PenaltyOptions& options, TangentFunction bodies)
    : QuadraturePenalty(std::move(name), V, facets, std::optional(facets), nullptr,
                        std::make_unique<search::GeneralSearch>(V, facets, named), options, std::move(bodies))
{
}

double QuadraturePenalty::sum_over_ranks(double value) const
{
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, comm());
  return value;
}

// --- load steps ----------------------------------------------------------------------------------------------------

/// Refuse bodies of general contact that overlap: the side of a facet that a point belongs to would not be known.
/// Collective.
void QuadraturePenalty::refuse_overlap()
{
  if (_options.augmented || _options.law || _options.adjustment.adjusts() || _options.adjustment.offset != 0.0)
    throw std::invalid_argument(_name + ": general contact has no augmentation, law of the interface or adjusted gaps: "
                                        "name the pairs of surfaces that are to have them");
  locate(_start);
  const search::GeneralSearch& general = *_forces.general();
  const surface::Facets& slave = _forces.slave();
  double most = 0.0;
  for (std::size_t q = 0; q < at().size(); ++q)
  {
    const std::int32_t f = at().facet[q];
    const surface::FacetPoint p = surface::evaluate(slave, f, slave.x_of(f), at().xi.data() + 2 * q);
    const search::SearchingPoint point{f, at().xi.data() + 2 * q, p.x, p.normal, 0.0};
    most = std::max(most, general.overlap(point, _forces.search()->reach()) / general.own_height(f));
  }
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, comm());
  if (most > search::GeneralSearch::shallow_part)
    throw std::invalid_argument(_name + ": bodies overlap before anything is loaded, by " + common::text("%.2g", most) +
                                " of the height of a cell, and general contact takes " +
                                common::text("%.2g", search::GeneralSearch::shallow_part) +
                                ": move them apart, or name the surfaces as a pair");
}

/// Penalties of general contact, which each body has for itself: the softer one of two decides, and points of both
/// sides bear half each. Collective.
void QuadraturePenalty::set_penalties()
{
  if (!_forces.share_of_body.empty())
    return;
  const int num = _forces.general()->num_bodies();
  if (_penalty > 0.0)
  {
    _forces.share_of_body.assign(num, share_of_side);
    return;
  }
  if (!_bodies)
    throw std::invalid_argument(_name + ": an automatic penalty needs the tangent of the bodies");
  const std::vector<double> each = automatic_penalties(_bodies(), *_space, _slave, _forces.general()->slave_bodies(),
                                                       num, _rule, _options.axisymmetric);
  for (const double value : each)
    _penalty = std::max(_penalty, std::isfinite(value) ? value : 0.0);
  for (const double value : each)
    _forces.share_of_body.push_back(share_of_side * std::min(value / _penalty, 1.0));
}

/// Penetrations of a converged state are what a point may have through the next one. Not collective.
void QuadraturePenalty::keep_depths()
{
  for (std::size_t q = 0; q < at().size(); ++q)
    _forces.history.depth[q] = std::isfinite(at().gap[q]) ? std::max(0.0, -at().gap[q]) : 0.0;
}

double QuadraturePenalty::deepest() const
{
  double out = 0.0;
  for (const double value : gap())
    out = std::max(out, -value);
  if (const CrossedEdges* edges = _forces.edges())
    out = std::max(out, edges->deepest());
  MPI_Allreduce(MPI_IN_PLACE, &out, 1, MPI_DOUBLE, MPI_MAX, comm());
  return out;
}

/// Points of general contact that are deeper than the cell behind the facet is high, in words: beyond it they would be
/// taken for points of the far side. Collective.
std::string QuadraturePenalty::too_deep() const
{
  double most = 0.0;
  for (std::size_t q = 0; q < at().size(); ++q)
    if (const std::int32_t facet = at().master[q]; facet >= 0)
      most = std::max(most, -at().gap[q] / _forces.general()->height(facet));
  if (const CrossedEdges* edges = _forces.edges())
    most = std::max(most, edges->deepest_part());
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, comm());
  if (!(most > deepest_part))
    return "";
  return _name + ": a point is pressed in by " + common::text("%.2g", most) +
         " of the height of a cell: the surface is too coarse, or the bodies too unlike, for a penalty; name the "
         "surfaces as a pair with multipliers (Lagrange), or refine them";
}

double QuadraturePenalty::automatic() const
{
  if (!_bodies)
    throw std::invalid_argument(_name + ": an automatic penalty needs the tangent of the bodies");
  return automatic_penalty(_bodies(), *_space, _slave, _master ? &*_master : nullptr, _rule, _options.axisymmetric);
}

void QuadraturePenalty::check_parameters()
{
  if (_options.penalty > 0.0 && _bodies)
    check_penalty(_name, _options.penalty, automatic());
}

void QuadraturePenalty::check_without_time() const
{
  if (_options.law && _options.law->has_rates())
    throw std::invalid_argument(_name + ": the law of the interface depends on rates of gap or slip, and a static "
                                        "problem has no time: use a NewmarkProblem or an ExplicitProblem");
}

std::optional<std::array<double, 3>> QuadraturePenalty::displacement() const
{
  return _rigid ? std::optional(_displacement) : std::nullopt;
}

void QuadraturePenalty::set_rotation(const gap::Matrix3& rotation)
{
  if (!turns())
    throw std::invalid_argument(_name + ": the master does not turn: it was not made as one that rotates");
  _next_rotation = rotation;
}

std::optional<gap::Matrix3> QuadraturePenalty::rotation() const
{
  return turns() ? std::optional(_rotation) : std::nullopt;
}

std::array<double, 3> QuadraturePenalty::centre() const
{
  return _rigid ? _rigid->centre : std::array<double, 3>{};
}

RigidIncrement QuadraturePenalty::rigid_increment() const
{
  RigidIncrement out;
  for (int c = 0; c < 3; ++c)
    out.displacement[c] = _displacement[c] - _start_displacement[c];
  if (!turns())
    return out;
  out.turn = gap::turn_between(_start_rotation, _rotation);
  for (int c = 0; c < 3; ++c)
    out.centre[c] = _rigid->centre[c] + _displacement[c];
  return out;
}

state::State QuadraturePenalty::state()
{
  using state::Place;
  const std::size_t per_facet = at().per_facet, gdim = at().gdim;
  const std::size_t num_owned = _space->dofmap()->index_map->size_local();
  PenaltyHistory& h = _forces.history;
  state::State out(_name);
  out.at(Place::facet, _slave.id);
  out.add("multiplier", Place::facet, h.multiplier, per_facet);
  out.add("traction", Place::facet, h.traction, per_facet * gdim);
  out.add("slip", Place::facet, h.slip, per_facet * gdim);
  out.add("touched", Place::facet, _touched, per_facet);
  if (LawPoints* law = _forces.law())
    law->add_to(out, per_facet);
  out.add("corners", Place::node, state::View(std::span(_uzawa.multiplier).first(num_owned)));
  out.add("start", Place::node, state::View(std::span(_start).first(num_owned * gdim)), gdim);
  if (general())
  {
    out.add("depth", Place::facet, h.depth, per_facet);
    if (CrossedEdges* edges = _forces.edges())
      edges->add_to(out);
  }
  out.add("start_displacement", Place::all, state::View(std::span<double>(_start_displacement)), 3);
  out.add("displacement", Place::all, state::View(std::span<double>(_displacement)), 3);
  if (turns())
  {
    out.add("start_rotation", Place::all, state::View(std::span<double>(_start_rotation)), 9);
    out.add("rotation", Place::all, state::View(std::span<double>(_rotation)), 9);
  }
  return out;
}

void QuadraturePenalty::begin_step(std::span<const double> u, const std::optional<std::array<double, 3>>& displacement,
                                   std::span<const double>)
{
  if (_options.law)
    _penalty = _tangential = 1.0; // not used, but to be positive
  if (general())
    set_penalties();
  if (_penalty == 0.0)
  {
    _penalty = automatic();
    PetscPrintf(_space->mesh()->comm(), "%s: penalty %.3e from material and mesh\n", _name.c_str(), _penalty);
    PetscFFlush(PETSC_STDOUT);
  }
  if (_tangential == 0.0)
    _tangential = _penalty;
  _start.assign(u.begin(), u.end());
  _forces.parameters.normal = _penalty;
  _forces.parameters.tangential = _tangential;
  _touch = touch * _size * _penalty;
  _uzawa.begin();
  _fault.clear();
  if (_keeper)
    _keeper->begin(_forces.points().margin);
  if (_options.friction > 0.0) // the slip of a point is measured from the place where it closes
  {
    locate(_start);
    const std::vector<double> now = gap();
    for (std::size_t q = 0; q < now.size(); ++q)
      _forces.history.gap[q] = _touched[q] || now[q] <= touch * _size ? 0.0 : now[q];
  }
  if (LawPoints* law = _forces.law(); law && !law->has_begun())
  {
    // The traction that the law has where the first increment begins.
    locate(_start);
    _forces.evaluate(std::vector<double>(_start.size(), 0.0), {});
    law->begin();
  }
  if (displacement)
  {
    _start_displacement = _displacement;
    _displacement = *displacement;
    _start_rotation = _rotation;
    _rotation = _next_rotation.value_or(_rotation);
    _next_rotation.reset();
  }
}

void QuadraturePenalty::accept_step()
{
  _forces.accept_step();
  const std::vector<ContactStatus> now = status();
  std::transform(now.begin(), now.end(), _touched.begin(), [](ContactStatus s) { return s != ContactStatus::open; });
  _gap_before = facing_gap();
  const std::vector<double> tractions = traction(), part = covered();
  LawPoints* law = _forces.law();
  // A law tells itself what it dissipates: tractions times slip are not that.
  const std::vector<double> slips = law ? std::vector<double>(tractions.size(), 0.0) : _forces.state().slip;
  _totals.update(comm(), {at().gdim, at().x, tractions, slips, now, at().weight, part});
  if (law)
    _totals.dissipated += sum_over_ranks(law->accept(at().weight));
  if (general())
  {
    keep_depths();
    if (CrossedEdges* edges = _forces.edges())
      _totals.dissipated += sum_over_ranks(edges->accept());
    _totals.force = _totals.moment = {}; // the surface pushes itself
  }
}

void QuadraturePenalty::set_time_step(double dt)
{
  if (LawPoints* law = _forces.law())
    law->time_step = dt;
}

/// Pressure per penetration that the contact has [F/L^3]. Not collective.
double QuadraturePenalty::stiffness() const
{
  return _forces.law() ? _forces.law()->largest_stiffness() : _penalty;
}

bool QuadraturePenalty::augment()
{
  if (leave_facets())
    return true;
  if (general())
    _fault = too_deep();
  if (!_options.augmented)
    return false;
  const double tolerance = _options.tolerance * _size;
  auto multiplier = _uzawa.augment(gap_without_overhang(), at().weight, _penalty, tolerance);
  if (!multiplier)
    return false;
  _forces.history.multiplier = std::move(*multiplier);
  if (_uzawa.rounds() <= _options.max_augmentations)
    return true;
  _fault = _name + ": " + _uzawa.fault(_penalty, tolerance);
  return false;
}

/// Gaps, infinite at open points that the master does not face: theirs are the way to its rim, which no pressure could
/// close. On a slave's facet that the master covers in part they would keep the mean gap open.
std::vector<double> QuadraturePenalty::gap_without_overhang()
{
  const int gdim = at().gdim, n = _slave.displacement.num_nodes();
  std::vector<double> sums(_u.size(), 0.0), out = gap();
  surface::move(_slave, _u.data());
  gap::add_normals(_slave, sums);
  for (std::size_t q = 0; q < out.size(); ++q)
  {
    double inward[3] = {}, squared = 0.0, facing = 0.0;
    for (int c = 0; c < gdim; ++c)
    {
      for (int i = 0; i < n; ++i)
        inward[c] += sums[std::size_t(_slave.nodes_of(at().facet[q])[i]) * gdim + c];
      squared += inward[c] * inward[c];
    }
    for (int c = 0; c < gdim; ++c)
      facing += at().normal[q * gdim + c] * inward[c] / std::max(std::sqrt(squared), 1e-300);
    if (out[q] > 0.0 && facing < least_facing)
      out[q] = infinity;
  }
  return out;
}

/// Release points from their facets, once in an increment, and project them anew. Collective.
/// @returns whether a closest point or a traction changes, so that the iteration must continue
bool QuadraturePenalty::leave_facets()
{
  if (!_keeper || !_keeper->leave())
    return false;
  const std::vector<double> closest_before = closest_points(), traction_before = traction();
  update_gap(std::vector<double>(_u));
  const std::vector<double> closest = closest_points(), traction_now = traction();
  const double per_length = stiffness();
  double change = 0.0;
  for (std::size_t i = 0; i < closest.size(); ++i)
  {
    if (_forces.state().status[i / at().gdim] != ContactStatus::open)
      change = std::max(change, std::abs(closest[i] - closest_before[i]));
    if (per_length > 0.0)
      change = std::max(change, std::abs(traction_now[i] - traction_before[i]) / per_length);
  }
  MPI_Allreduce(MPI_IN_PLACE, &change, 1, MPI_DOUBLE, MPI_MAX, comm());
  return change > still * _size;
}

/// Closest points on the master, [q*gdim + c] [L]; without meaning for points without master.
std::vector<double> QuadraturePenalty::closest_points() const
{
  std::vector<double> out = at().x;
  for (std::size_t i = 0; i < out.size(); ++i)
    if (const double gap = at().gap[i / at().gdim]; std::isfinite(gap))
      out[i] -= gap * at().normal[i];
  return out;
}

std::string QuadraturePenalty::passed_through()
{
  const int gdim = at().gdim, n = _slave.displacement.num_nodes();
  std::vector<std::int8_t> passed(at().size(), 0);
  if (_rigid)
  {
    const std::vector<double> moved = difference(_u, _start);
    const RigidIncrement rigid = rigid_increment();
    std::vector<double> from = at().x;
    double shape[surface::FacetElement::max_nodes];
    for (std::size_t q = 0; q < at().size(); ++q)
    {
      _slave.displacement.values(at().xi.data() + 2 * q, shape);
      for (int c = 0; c < gdim; ++c)
      {
        for (int i = 0; i < n; ++i)
          from[q * gdim + c] -= shape[i] * moved[std::size_t(_slave.nodes_of(at().facet[q])[i]) * gdim + c];
      }
      move_with_master(rigid, gdim, from.data() + q * gdim);
    }
    passed = gap::through_obstacle(*_rigid, from, at().x, _initial->offset(), touch * _size);
  }
  else
  {
    const std::vector<double> here = _u, now = facing_gap();
    for (std::size_t q = 0; q < passed.size(); ++q)
      passed[q] = std::isfinite(_gap_before[q]) && std::isinf(now[q]);
    int any = std::ranges::any_of(passed, [](std::int8_t p) { return p != 0; });
    MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, comm());
    if (any)
    {
      const auto gap_on_the_way = [&](double part)
      {
        std::vector<double> there = _start;
        for (std::size_t i = 0; i < there.size(); ++i)
          there[i] += part * (here[i] - there[i]);
        locate(there);
        return facing_gap();
      };
      passed = gap::through_master(comm(), passed, point_sizes(_slave, at()), gap_on_the_way);
      update_gap(here);
    }
  }
  return gap::describe_crossing(_name, comm(), gdim, at().x, passed);
}

// --- checkpoints ---------------------------------------------------------------------------------------------------

state::State QuadraturePenalty::saved_state()
{
  using state::Place;
  const std::size_t per_facet = at().per_facet;
  const state::State now = state();
  static const std::string first[] = {"multiplier", "touched"}, vectors[] = {"traction", "slip"},
                           corners[] = {"corners"};
  state::State out = now.copy_of(first);
  const std::vector<ContactStatus> points = status();
  std::vector<std::int8_t> numbers(points.size());
  std::transform(points.begin(), points.end(), numbers.begin(), [](ContactStatus s) { return std::int8_t(s); });
  out.add_own("status", Place::facet, std::move(numbers), per_facet);
  out.add_own("facet", Place::facet, facet_ids(), per_facet);
  out.add_copies(now, vectors);
  _totals.add_to(out, at().gdim);
  out.add_own("master", Place::all, std::vector<double>(_displacement.begin(), _displacement.end()));
  if (turns())
    out.add_own("rotation", Place::all, std::vector<double>(_rotation.begin(), _rotation.end()), 9);
  out.add_own("penalties", Place::all, std::vector<double>{_penalty, _tangential});
  if (_options.augmented)
    out.add_copies(now, corners);
  static const std::string depth[] = {"depth"};
  if (general())
  {
    out.add_copies(now, depth);
    if (_forces.edges())
      out.add_copies(now, CrossedEdges::state_names());
    std::vector<double> shares = _forces.share_of_body; // none before the first increment
    shares.resize(_forces.general()->num_bodies(), 0.0);
    out.add_own("shares", Place::all, std::move(shares), _forces.general()->num_bodies());
  }
  if (const LawPoints* law = _forces.law())
    out.add_copies(now, law->names());
  return out;
}

void QuadraturePenalty::resume(const state::State& saved, std::span<const double> u)
{
  std::vector<ContactStatus> status;
  for (const std::int8_t number : saved.values<std::int8_t>("status"))
    status.push_back(ContactStatus(number));
  const std::span<const std::int64_t> facets = saved.values<std::int64_t>("facet");
  if (status.size() != at().size() || facets.size() != at().size())
    throw std::invalid_argument("a checkpoint has status and facet of every point");
  state().assign_common(saved);
  std::ranges::copy(saved.values<double>("master"), _displacement.begin());
  _penalty = saved.values<double>("penalties")[0];
  _tangential = saved.values<double>("penalties")[1];
  _start_displacement = _displacement;
  if (turns())
    std::ranges::copy(saved.values<double>("rotation"), _rotation.begin());
  if (general())
    if (const auto shares = saved.values<double>("shares"); shares[0] > 0.0)
      _forces.share_of_body.assign(shares.begin(), shares.end());
  begin_step(u, displacement());
  update_gap(u);
  if (_keeper) // points a little beside a facet that they were kept on go back on it
  {
    keep_facets(facets);
    _keeper->begin(_forces.points().margin, FacetKeeper::widest);
    update_gap(u);
  }
  if (_forces.law()) // the increment and the rates that the tractions were made with are over
    _forces.resume_law();
  // A point that has slipped is on the edge of its friction limit, where the evaluation alone says that it sticks.
  _resumed_status = _last_status = std::move(status);
  _gap_before = facing_gap();
  _totals.resume(saved, _forces.law() ? std::vector<double>(at().normal.size(), 0.0) : slip());
}

/// Facet of the master that each point is on, by a number that does not depend on the ranks; -1: none.
std::vector<std::int64_t> QuadraturePenalty::facet_ids() const
{
  std::vector<std::int64_t> out(at().size(), -1);
  if (_master)
    for (std::size_t q = 0; q < out.size(); ++q)
      if (at().master[q] >= 0)
        out[q] = _forces.master()->id[at().master[q]];
  return out;
}

void QuadraturePenalty::keep_facets(std::span<const std::int64_t> ids)
{
  const std::vector<std::int64_t>& known = _forces.master()->id;
  std::vector<std::int32_t> order(known.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::int32_t f) { return known[f]; });
  for (std::size_t q = 0; q < ids.size(); ++q)
  {
    const auto place = std::ranges::lower_bound(order, ids[q], {}, [&](std::int32_t f) { return known[f]; });
    _forces.points().master[q] = place != order.end() && known[*place] == ids[q] ? *place : -1;
  }
}

// --- Newton iterations ---------------------------------------------------------------------------------------------

/// Update closest points and gaps. Collective.
void QuadraturePenalty::locate(std::span<const double> u)
{
  if (_rigid)
    _rigid->displacement = _displacement;
  if (turns())
    _rigid->rotation = _rotation;
  _forces.update_gap(u, _start, _seen && _keeper && _keeper->stay());
}

void QuadraturePenalty::update_gap(std::span<const double> u)
{
  if (!_touch) // a state is asked for before anything was solved
    begin_step(u, displacement());
  _start = operators::from_owners(_space->dofmap()->index_map, std::move(_start), at().gdim);
  _u.assign(u.begin(), u.end());
  _resumed_status.reset();
  locate(_u);
  _seen = true;
  _forces.parameters.touch = *_touch;
  _forces.evaluate(difference(_u, _start), rigid_increment());
  _touch = 0.0;
  _closes_nearest = false;
}

int QuadraturePenalty::update_active_set(bool, std::optional<std::int64_t>)
{
  const std::vector<ContactStatus> now = status();
  int changed = 0;
  std::vector<std::int32_t> facets(now.size());
  for (std::size_t q = 0; q < now.size(); ++q)
  {
    changed += now[q] != _last_status[q];
    facets[q] = now[q] != ContactStatus::open ? at().master[q] : -1;
  }
  if (_keeper)
    changed += _keeper->watch(facets, _forces.search()->kept(), _forces.points().margin);
  if (CrossedEdges* edges = _forces.edges())
    changed += edges->num_changed();
  _last_status = now;
  std::array<int, 2> sums{changed, _forces.law() ? int(_forces.law()->num_unsolved()) : 0};
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_INT, MPI_SUM, comm());
  if (_forces.law())
    _fault = sums[1] == 0 ? ""
                          : _name + ": the local equations of the law of the interface were not solved at " +
                                std::to_string(sums[1]) + " points: take smaller increments";
  return sums[0];
}

bool QuadraturePenalty::symmetric() const
{
  const std::vector<ContactStatus> now = status();
  if (_options.law)
    return !_options.law->has_shear();
  const bool edges_slip = _forces.edges() && std::ranges::any_of(_forces.edges()->closed(), [](const CrossedPair& pair)
                                                                 { return pair.status == ContactStatus::slip; });
  return sum_over_ranks(has_friction() && (edges_slip || std::ranges::count(now, ContactStatus::slip) > 0)) == 0.0;
}

std::int64_t QuadraturePenalty::num_active() const
{
  const std::vector<ContactStatus> now = status();
  std::int64_t number = std::int64_t(now.size()) - std::ranges::count(now, ContactStatus::open);
  if (const CrossedEdges* edges = _forces.edges())
    number += std::int64_t(edges->closed().size());
  MPI_Allreduce(MPI_IN_PLACE, &number, 1, MPI_INT64_T, MPI_SUM, comm());
  return number;
}

/// Penalty times the rounding of positions, at points that are closed, or open by no more than that.
double QuadraturePenalty::round_off() const
{
  const double per_length = stiffness();
  double sum = 0.0;
  const std::vector<double> now = gap();
  for (std::size_t q = 0; q < now.size(); ++q)
  {
    const int gdim = at().gdim;
    double squared = 0.0;
    for (int c = 0; c < gdim; ++c)
      squared += at().x[q * gdim + c] * at().x[q * gdim + c];
    const double rounding = std::numeric_limits<double>::epsilon() * std::sqrt(squared);
    if (_forces.law() ? _forces.law()->acts(q) : now[q] <= rounding)
      sum += std::pow(per_length * at().weight[q] * rounding, 2);
  }
  return std::sqrt(sum_over_ranks(sum));
}

std::string QuadraturePenalty::mesh_advice() const
{
  if (!_master)
    return "";
  double sums[4]; // sizes of the slave's facets and their number, of the master's
  for (int side = 0; side < 2; ++side)
  {
    const std::vector<double> sizes = facet_sizes(side == 0 ? _slave : *_master);
    sums[2 * side] = std::accumulate(sizes.begin(), sizes.end(), 0.0);
    sums[2 * side + 1] = double(sizes.size());
  }
  MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_DOUBLE, MPI_SUM, comm());
  const double ratio = (sums[0] / sums[1]) / (sums[2] / sums[3]);
  if (ratio < coarse)
    return "";
  return _name + ": the slave's facets are " + common::text("%.1f", ratio) +
         " times as long as the master's, which is dented between its points: exchange slave and master, refine the "
         "slave, or take multipliers";
}

double QuadraturePenalty::smallest_gap() const
{
  const std::vector<double> now = gap();
  double least = now.empty() ? infinity : std::ranges::min(now);
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_DOUBLE, MPI_MIN, comm());
  return least;
}

// --- bodies that are supported by contact alone --------------------------------------------------------------------

std::vector<double> QuadraturePenalty::rigid_body_products(const operators::RigidBodyModes& modes) const
{
  const int gdim = at().gdim, num = modes.num_modes(), per_body = modes.per_body();
  std::vector<double> out(std::size_t(num) * num, 0.0);
  std::vector<std::int32_t> body(modes.body().begin(), modes.body().end());
  if (_master) // the search knows facets of other ranks as well
  {
    const auto near = _forces.map();
    std::vector<double> known(near->size_local() + near->num_ghosts(), 0.0);
    std::copy_n(body.begin(), modes.num_owned(), known.begin());
    known = operators::from_owners(near, std::move(known), 1);
    body.assign(known.begin(), known.end());
  }
  const std::vector<ContactStatus> now = status();
  const std::vector<double> closest = closest_points();
  std::vector<double> row(num, 0.0);
  // Two points that are held together along a direction, or along all of them.
  const auto add =
      [&](std::int32_t own, const double* x, std::int32_t other, const double* y, const double* n, bool sticks)
  {
    for (int k = 0; k < (sticks ? gdim : 1); ++k)
    {
      double direction[3];
      for (int c = 0; c < gdim; ++c)
        direction[c] = !sticks ? n[c] : c == k ? 1.0 : 0.0;
      modes.add_work(own, x, direction, 1.0, row);
      if (_master)
        modes.add_work(other, y, direction, -1.0, row);
      for (int i = 0; i < (other == own ? per_body : 2 * per_body); ++i)
        for (int j = 0; j < (other == own ? per_body : 2 * per_body); ++j)
        {
          const int a = i < per_body ? own * per_body + i : (other - 1) * per_body + i;
          const int b = j < per_body ? own * per_body + j : (other - 1) * per_body + j;
          out[std::size_t(a) * num + b] += row[a] * row[b];
        }
      for (std::int32_t b : {own, other})
        std::fill_n(row.begin() + b * per_body, per_body, 0.0);
    }
  };
  for (std::size_t q = 0; q < now.size(); ++q)
  {
    if (now[q] == ContactStatus::open)
      continue;
    const std::int32_t own = body[_forces.slave().nodes_of(at().facet[q])[0]];
    const std::int32_t other = _master ? body[_forces.master()->nodes_of(at().master[q])[0]] : own;
    // With friction the point is held in all directions; but nothing holds a point along the surface that closes only
    // in this increment.
    add(own, at().x.data() + q * gdim, other, closest.data() + q * gdim, at().normal.data() + q * gdim,
        has_friction() && !(_forces.history.gap[q] > 0.0));
  }
  if (const CrossedEdges* edges = _forces.edges())
    for (const CrossedPair& pair : edges->closed())
    {
      double x[2][3] = {};
      for (int i = 0; i < 4; ++i)
        for (int c = 0; c < 3; ++c)
          x[i / 2][c] += std::abs(pair.weights[i]) * pair.ends[i][c];
      add(body[pair.nodes[0]], x[0], body[pair.nodes[2]], x[1], pair.normal,
          has_friction() && !(pair.gap_before > 0.0));
    }
  return out;
}

bool QuadraturePenalty::close_nearest()
{
  const std::optional<double> near = gap::nearly_touching(comm(), gap(), point_sizes(_slave, at()));
  if (!near || num_active() > 0 || _options.law)
    return false;
  _forces.parameters.touch = *near * _penalty;
  _forces.evaluate();
  _closes_nearest = true;
  return true;
}

std::vector<double> QuadraturePenalty::closing_forces() const
{
  if (!_closes_nearest)
    return {};
  std::vector<double> out = _forces.closing_forces();
  for (double& force : out)
    force = -force;
  return out;
}

// --- results -------------------------------------------------------------------------------------------------------

std::vector<double> QuadraturePenalty::gap() const
{
  std::vector<double> out = at().gap;
  for (std::size_t q = 0; q < out.size(); ++q)
    out[q] += at().beside[q] ? 0.0 : _forces.history.offset[q];
  return out;
}

/// Infinite where a point is open over an edge or a corner, as beside the master: that may be its far side.
std::vector<double> QuadraturePenalty::facing_gap() const
{
  std::vector<double> out = gap();
  for (std::size_t q = 0; q < out.size(); ++q)
    if (out[q] > 0.0 && at().status[q] != search::ProjectionStatus::converged)
      out[q] = std::numeric_limits<double>::infinity();
  return out;
}

std::vector<ContactStatus> QuadraturePenalty::status() const
{
  return _resumed_status ? *_resumed_status : _forces.state().status;
}

std::vector<double> QuadraturePenalty::traction() const
{
  // Evaluated again, friction at its limit is scaled to it once more, which rounds.
  const std::vector<double>& tangential = _resumed_status ? _forces.history.traction : _forces.state().tangential;
  const std::vector<ContactStatus> now = status();
  std::vector<double> out(at().normal.size(), 0.0);
  for (std::size_t i = 0; i < out.size(); ++i)
    if (const std::size_t q = i / at().gdim; now[q] != ContactStatus::open)
      out[i] = _forces.state().pressure[q] * at().normal[i] + tangential[i];
  return out;
}

double QuadraturePenalty::stored_energy() const
{
  if (const LawPoints* law = _forces.law())
    return sum_over_ranks(law->energy(at().weight));
  if (_penalty == 0.0 || _tangential == 0.0)
    return 0.0;
  const std::vector<double> pressures = pressure(), tractions = traction(), normals = normal(), weights = weight();
  const std::size_t gdim = _space->mesh()->geometry().dim();
  double out = 0.0;
  for (std::size_t i = 0; i < pressures.size(); ++i)
  {
    double density = 0.5 * pressures[i] * pressures[i] / (_penalty * _forces.share_of(i));
    if (has_friction())
      for (std::size_t c = 0; c < gdim; ++c)
      {
        const double tangential = tractions[i * gdim + c] - pressures[i] * normals[i * gdim + c];
        density += 0.5 * tangential * tangential / (_tangential * _forces.share_of(i));
      }
    out += weights[i] * density;
  }
  if (const CrossedEdges* edges = _forces.edges())
    out += edges->energy();
  return sum_over_ranks(out);
}

std::vector<double> QuadraturePenalty::covered() const
{
  const std::vector<ContactStatus> now = status();
  std::vector<double> out(now.size());
  std::transform(now.begin(), now.end(), out.begin(), [](ContactStatus s) { return s != ContactStatus::open; });
  return out;
}

std::pair<std::vector<std::int32_t>, std::vector<double>> QuadraturePenalty::nodal_means(std::span<const double> values,
                                                                                         std::size_t columns) const
{
  if (values.size() != at().size() * columns)
    throw std::invalid_argument("nodal means need the values of every point");
  const auto map = _space->dofmap()->index_map;
  const int n = _slave.displacement.num_nodes();
  const std::size_t width = columns + 1; // the last one: weights
  std::vector<double> sums((map->size_local() + map->num_ghosts()) * width, 0.0);
  double shape[surface::FacetElement::max_nodes];
  for (std::size_t q = 0; q < at().size(); ++q)
  {
    _slave.displacement.values(at().xi.data() + 2 * q, shape);
    for (int i = 0; i < n; ++i)
    {
      double* sum = sums.data() + std::size_t(_slave.nodes_of(at().facet[q])[i]) * width;
      const double weight = at().weight[q] * shape[i] * shape[i];
      for (std::size_t c = 0; c < columns; ++c)
        sum[c] += weight * values[q * columns + c];
      sum[columns] += weight;
    }
  }
  sums = operators::sum_over_ranks(map, std::move(sums), int(width));
  std::pair<std::vector<std::int32_t>, std::vector<double>> out;
  for (std::int32_t node = 0; node < map->size_local(); ++node)
    if (const double* sum = sums.data() + std::size_t(node) * width; sum[columns] != 0.0)
    {
      out.first.push_back(node);
      for (std::size_t c = 0; c < columns; ++c)
        out.second.push_back(sum[c] / sum[columns]);
    }
  return out;
}
} // namespace dolfinx_impact::enforcement
