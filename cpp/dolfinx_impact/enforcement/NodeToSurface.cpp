#include "NodeToSurface.h"
#include "../search/linear_facet.h"
#include "friction.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace impact::enforcement
{
namespace
{
using surface::FacetElement;
using surface::FacetShape;

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

search::Projection NodeToSurface::rigid_point(std::size_t i, const double* u, const double* du, double back) const
{
  const std::size_t k = std::size_t(_candidates.numbers()[i]) * _gdim;
  double x[3];
  for (int c = 0; c < _gdim; ++c)
    x[c] = _candidates.X()[i * _gdim + c] + u[k + c] - (du ? back * (du[k + c] - _obstacle_increment[c]) : 0.0);
  const gap::RigidPoint p = gap::evaluate(_obstacle, x);
  search::Projection out;
  out.status = search::ProjectionStatus::converged;
  out.gap = p.gap;
  std::copy_n(p.normal, 3, out.normal);
  return out;
}

void NodeToSurface::open(std::size_t i, const search::Projection& at, const double* u)
{
  _results.gap[i] = at.gap;
  if (!_rigid)
    _tracking.release(i, at, u);
  if (_results.status[i] == ContactStatus::open && _closed[i] != 1)
    return; // it was before: all is zero
  _results.status[i] = ContactStatus::open;
  _results.pressure[i] = 0.0;
  _stiffness[i] = 0.0;
  // What is stored still, in a node that has not left through the surface, is lost.
  Spring& spring = _springs[i];
  double squared = 0.0;
  for (int c = 0; c < _gdim; ++c)
  {
    squared += _tangential[i * _gdim + c] * _tangential[i * _gdim + c];
    _results.traction[i * _gdim + c] = _results.slip[i * _gdim + c] = _tangential[i * _gdim + c] = 0.0;
  }
  if (!_options.kinematic)
  {
    _energy.normal -= normal_release(spring, 0.0);
    _energy.friction += tangential_release(spring, 0.5 * squared * spring.compliance);
  }
  if (_closed[i] == 1)
    _closed[i] = 0;
}

bool NodeToSurface::meets(std::size_t i, const double* u, const double* du, double reach, Touch& touch)
{
  touch.i = i;
  touch.node = _candidates.numbers()[i];
  touch.at = _rigid ? rigid_point(i, u) : _tracking.locate(i, u, du);
  search::Projection& at = touch.at;
  if (_closed[i] != came_in && (_rigid || _tracking.step() > 0.5 * _candidates.smallest()) && passes(touch, u, du))
  {
    open(i, at, u);
    return false;
  }
  std::copy_n(at.normal, _gdim, _results.normal.data() + i * _gdim);
  // One that leaves the surface is looked at once more: its last force has worked on the way.
  const bool leaves = _closed[i] == 1 && !_options.kinematic && std::isfinite(at.gap);
  if (barred(touch, u, du) || (!(at.gap < reach) && !leaves))
  {
    open(i, at, u);
    return false;
  }
  touch.num = 0;
  if (_rigid)
    return true;
  const surface::Facets& master = _tracking.master();
  touch.num = master.displacement.num_nodes();
  touch.masters = master.nodes_of(at.facet);
  touch.corners = _tracking.corners(at.facet);
  shape_values(master.displacement, at.xi, touch.phi);
  return true;
}

/// Reciprocal of the contact stiffness.
inline double NodeToSurface::compliance(const Touch& touch, double dt) const
{
  const double per_area = _per_area[touch.i];
  if (_options.penalty > 0.0)
    return per_area / (_share * _options.penalty);
  double own = _inverse_mass[touch.i], masters = 0.0;
  for_nodes(touch.num,
            [&](int j)
            {
              const double weight = std::abs(touch.phi[j]);
              const search::MasterNode& master = _tracking.masters()[touch.corners[j]];
              own += weight * inverse_mass(master);
              masters += weight * area_per_mass(master);
            });
  return dt * dt * (own + masters * per_area) / (_share * _options.kappa);
}

namespace
{
/// Mean of max(-g, 0) over gaps from g - |r|/2 to g + |r|/2.
double mean_overlap(double g, double r)
{
  const double half = 0.5 * std::abs(r);
  return g >= half ? 0.0 : g <= -half ? -g : (half - g) * (half - g) / (4.0 * half);
}

/// Part of the way from gap g - r to g that lies below zero.
double part_below(double g, double r)
{
  if (g < 0.0)
    return r < 0.0 ? std::min(1.0, g / r) : 1.0;
  return r > g ? 1.0 - g / r : 0.0;
}
} // namespace

/// A node leaves the surface: half of its last force's work is done on the way.
/// @param[in] motion of the node against the master in the step [L]
template <int D>
void NodeToSurface::leave(std::size_t i, const double* n, double change, const double* motion)
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

/// The force of a node that is near the master.
template <int D>
void NodeToSurface::add_node(Touch& touch, const NodalState& state, double* f)
{
  const std::size_t i = touch.i;
  const search::Projection& at = touch.at;
  const double* n = at.normal;
  constexpr int W = search::padded<D>;
  double motion[W] = {}, r = 0.0, way_squared = 0.0;
  for (int c = 0; c < D; ++c)
    motion[c] = state.du[std::size_t(touch.node) * D + c] - (_rigid ? _obstacle_increment[c] : 0.0);
  const search::MasterNode* masters = _tracking.masters();
  for_nodes(touch.num,
            [&](int j)
            {
              for (int c = 0; c < W; ++c)
                motion[c] -= touch.phi[j] * masters[touch.corners[j]].du[c];
            });
  for (int c = 0; c < D; ++c)
  {
    r += n[c] * motion[c];
    way_squared += motion[c] * motion[c];
  }
  // Who passes beside an edge is not pushed.
  const double overlap = at.gap >= 0.0 && at.rim == search::Projection::Rim::beside ? 0.0 : mean_overlap(at.gap, r);
  Spring& spring = _springs[i];
  const bool begins = _closed[i] != 1;
  double change = begins ? r : at.gap - spring.gap;
  if (change * change > 4.0 * way_squared) // another facet is the nearest now: nothing has moved so far
    change = std::copysign(2.0 * std::sqrt(way_squared), change);
  double* t = _tangential.data() + i * D;
  if (!(overlap > 0.0))
  {
    if (!begins)
      leave<D>(i, n, change, motion);
    return open(i, at, state.u);
  }
  if (!_rigid)
    _tracking.hold(i, at);

  const double per_k = compliance(touch, state.dt), k = 1.0 / per_k, last_compliance = spring.compliance;
  _energy.normal -= normal_step(spring, k * overlap, k, per_k, at.gap, change, begins);
  const double normal_force = spring.force;
  double force[W] = {}, tangential_squared = 0.0;
  for (int c = 0; c < D; ++c)
    force[c] = normal_force * n[c];
  ContactStatus status = ContactStatus::slip;
  if (_options.friction > 0.0)
  {
    const double part = part_below(at.gap, r), limit = _options.friction * normal_force;
    double trial[D], turned[D], slip[D], stored = 0.0;
    for (int c = 0; c < D; ++c)
    {
      stored += 0.5 * t[c] * t[c] * last_compliance;
      motion[c] -= r * n[c];
      slip[c] = part * motion[c];
    }
    bool slips = coulomb<D>(n, k, per_k, limit, t, slip, trial), changed = false;
    for (int c = 0; c < D; ++c)
      turned[c] = trial[c] + k * part * motion[c];
    _energy.friction +=
        tangential_step<D>(spring.tangential_surplus, turned, stored, motion, k, per_k, limit, t, changed);
    for (int c = 0; c < D; ++c)
    {
      if (changed)
        slip[c] = part * motion[c] + (t[c] - turned[c]) * per_k;
      tangential_squared += t[c] * t[c];
      force[c] += t[c];
      _results.slip[i * D + c] += slip[c];
    }
    if (!slips && !changed)
      status = ContactStatus::stick;
  }
  const double per_area = _per_area[i];
  for (int c = 0; c < D; ++c)
  {
    f[std::size_t(touch.node) * D + c] += force[c];
    _force[c] += force[c];
    _results.traction[i * D + c] = force[c] * per_area;
  }
  Sum* sums = _master_force.data();
  for_nodes(touch.num,
            [&](int j)
            {
              for (int c = 0; c < W; ++c)
                sums[touch.corners[j]].force[c] -= touch.phi[j] * force[c];
            });
  // Without friction the force is along the gap but beside the rim, and where sum phi_j x_j is not on the facet.
  const surface::Facets& master = _tracking.master();
  if (turns() && (tangential_squared > 0.0 || at.rim != search::Projection::Rim::no ||
                  master.geometry.degree != master.displacement.degree))
  {
    double x[D], r[FacetElement::max_nodes * D];
    for (int c = 0; c < D; ++c)
      x[c] = _candidates.X()[i * D + c] + state.u[std::size_t(touch.node) * D + c];
    Couple couple;
    couple.set<D>(touch.num, [&](int j, int c) { return masters[touch.corners[j]].x[c]; }, touch.phi, x, r);
    couple.forces<D>(touch.num, r, force,
                     [&](int j, int c, double value) { sums[touch.corners[j]].force[c] += value; });
  }
  _closed[i] = 1;
  _stiffness[i] = k;
  _results.status[i] = status;
  _results.gap[i] = at.gap;
  _results.pressure[i] = normal_force * per_area;
  _energy.stored += spring.stored() + 0.5 * tangential_squared * per_k;
}

template <int D>
void NodeToSurface::add_all(const NodalState& state, double* f)
{
  Touch touch;
  // No gap changes by more than this in a step.
  const double reach = _rigid ? std::numeric_limits<double>::infinity() : 0.5 * _tracking.step();
  for (std::size_t i = 0; i < _candidates.nodes().size(); ++i)
    if ((_rigid || !_tracking.asleep(i)) && meets(i, state.u, state.du, reach, touch))
      add_node<D>(touch, state, f);
  // Zero again for the next step.
  const auto masters = _tracking.master_nodes();
  for (std::size_t k = 0; k < masters.size(); ++k)
    for (int c = 0; c < D; ++c)
      f[std::size_t(masters[k]) * D + c] += std::exchange(_master_force[k].force[c], 0.0);
}

void NodeToSurface::look(const double* u)
{
  if (_rigid || !_halo)
    return;
  const double moved = _tracking.moved(u);
  for (std::size_t i = 0; i < _candidates.nodes().size(); ++i)
    if (_closed[i] != 1)
    {
      const search::Projection at = _tracking.look(i, u, moved);
      _results.gap[i] = at.gap;
      std::copy_n(at.normal, _gdim, _results.normal.data() + i * _gdim);
    }
}

void NodeToSurface::add_forces(const NodalState& state, double* f)
{
  _force.fill(0.0);
  _energy.stored = 0.0;
  if (!_rigid)
  {
    _candidates.advance(state.dt);
    _tracking.advance(state.u, state.du);
  }
  _gdim == 2 ? add_all<2>(state, f) : add_all<3>(state, f);
  if (_other)
  {
    _other->add_forces(state, f);
    for (int c = 0; c < _gdim; ++c)
      _force[c] -= _other->_force[c];
  }
}
} // namespace impact::enforcement
