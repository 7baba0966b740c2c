#include "NodeToSurface.h"
#include "../search/linear_facet.h"
#include <algorithm>
#include <cmath>
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

search::Projection NodeToSurface::rigid_point(std::size_t i, const double* u, const double* du) const
{
  const std::size_t k = std::size_t(_candidates.nodes()[i]) * _gdim;
  double x[3];
  gap::Rigid obstacle = _obstacle;
  for (int c = 0; c < _gdim; ++c)
  {
    x[c] = _candidates.X()[i * _gdim + c] + (u[k + c] - (du ? du[k + c] : 0.0));
    obstacle.displacement[c] -= du ? _obstacle_increment[c] : 0.0;
  }
  const gap::RigidPoint p = gap::evaluate(obstacle, x);
  search::Projection out;
  out.status = search::ProjectionStatus::converged;
  out.gap = p.gap;
  std::copy_n(p.normal, 3, out.normal);
  return out;
}

void NodeToSurface::open(std::size_t i, double gap)
{
  _results.status[i] = ContactStatus::open;
  _results.gap[i] = gap;
  _results.pressure[i] = 0.0;
  _stiffness[i] = 0.0;
  for (int c = 0; c < _gdim; ++c)
    _results.traction[i * _gdim + c] = _results.slip[i * _gdim + c] = _tangential[i * _gdim + c] = 0.0;
  _closed[i] = 0;
  if (!_rigid)
    _tracking.release(i, gap);
}

bool NodeToSurface::touches(std::size_t i, const double* u, const double* du, Touch& touch)
{
  touch.i = i;
  touch.node = _candidates.nodes()[i];
  touch.at = _rigid ? rigid_point(i, u, nullptr) : _tracking.locate(i, u);
  search::Projection& at = touch.at;
  std::copy_n(at.normal, _gdim, _results.normal.data() + i * _gdim);
  if (!(at.gap < 0.0))
  {
    open(i, at.gap);
    return false;
  }
  if (_rigid)
  {
    touch.num = 0;
    return true;
  }
  if (!_closed[i] && -at.gap > 0.5 * _tracking.diameter(at.facet))
    if (const double before = _tracking.locate_before(i, u, du).gap; !(before > 0.0 && std::isfinite(before)))
    {
      ++_implausible;
      open(i, at.gap);
      return false;
    }
  const surface::Facets& master = _tracking.master();
  touch.num = master.displacement.num_nodes();
  touch.masters = master.nodes_of(at.facet);
  touch.corners = _tracking.corners(at.facet);
  shape_values(master.displacement, at.xi, touch.phi);
  _tracking.hold(i, at);
  return true;
}

/// Reciprocal of the contact stiffness.
double NodeToSurface::compliance(const Touch& touch, double dt) const
{
  const double per_area = _per_area[touch.i];
  if (_options.penalty > 0.0)
    return per_area / (_share * _options.penalty);
  double own = _inverse_mass[touch.i], masters = 0.0;
  for (int j = 0; j < touch.num; ++j)
  {
    const double weight = std::abs(touch.phi[j]);
    own += weight * _inverse[2 * touch.corners[j]];
    masters += weight * _inverse[2 * touch.corners[j] + 1];
  }
  return dt * dt * (own + masters * per_area) / (_share * _options.kappa);
}

/// Part of the step's motion that comes after closing.
double NodeToSurface::counted_part(const Touch& touch, const NodalState& state) const
{
  if (_closed[touch.i])
    return 1.0;
  const double before =
      _rigid ? rigid_point(touch.i, state.u, state.du).gap : _tracking.locate_before(touch.i, state.u, state.du).gap;
  return !(before > 0.0) ? 1.0 : std::isinf(before) ? 0.0 : touch.at.gap / (touch.at.gap - before);
}

namespace
{
/// Coulomb's law over a step, as enforcement/friction.h.
/// @param[in] k,per_k tangential stiffness and its reciprocal. @param[in] limit of the force
/// @param[in,out] t tangential force, of the last step and of this one
/// @param[in,out] s in: motion of the step; out: slip of the step
/// @returns does it slip?
template <int D>
bool coulomb(const double* n, double k, double per_k, double limit, double* t, double* s)
{
  double along = 0.0, turn = 0.0, size = 0.0, left = 0.0;
  for (int c = 0; c < D; ++c)
  {
    along += n[c] * s[c];
    turn += n[c] * t[c];
    size += t[c] * t[c];
  }
  double turned[D];
  for (int c = 0; c < D; ++c)
  {
    s[c] -= along * n[c];
    turned[c] = t[c] - turn * n[c];
    left += turned[c] * turned[c];
  }
  const double scale = left > 0.0 ? std::sqrt(size / left) : 0.0; // the force keeps its size when the normal turns
  double squared = 0.0;
  for (int c = 0; c < D; ++c)
  {
    turned[c] *= scale;
    t[c] = turned[c] - k * s[c];
    squared += t[c] * t[c];
  }
  // A node that slipped in the last step begins this one at its limit: round-off must not make it slip on.
  const bool slips = squared > limit * limit * (1.0 + 2e-12);
  const double factor = slips ? limit / std::sqrt(squared) : 1.0;
  for (int c = 0; c < D; ++c)
  {
    t[c] *= factor;
    s[c] = slips ? s[c] + (t[c] - turned[c]) * per_k : 0.0;
  }
  return slips;
}

/// Forces along the normal on the master's nodes, linear in their place along the tangent plane, without resultant:
/// friction on the slave and on the master acts at points that are a gap apart, and this turns back by as much.
/// @param[out] w their sizes
template <int D>
void couple(int num, const std::int32_t* nodes, const double* positions, const double* n, double gap, const double* t,
            double* w)
{
  // Axes of the tangent plane: along the force, and across it.
  double squared = 0.0, mean[D] = {}, x[FacetElement::max_nodes][D], place[FacetElement::max_nodes][2];
  for (int c = 0; c < D; ++c)
    squared += t[c] * t[c];
  const double size = std::sqrt(squared), per_size = 1.0 / size;
  double a[D], b[3] = {};
  for (int c = 0; c < D; ++c)
    a[c] = t[c] * per_size;
  if constexpr (D == 3)
    for (int c = 0; c < 3; ++c)
      b[c] = n[(c + 1) % 3] * a[(c + 2) % 3] - n[(c + 2) % 3] * a[(c + 1) % 3];
  const double part = 1.0 / num;
  for (int j = 0; j < num; ++j)
    for (int c = 0; c < D; ++c)
    {
      x[j][c] = positions[std::size_t(nodes[j]) * D + c];
      mean[c] += part * x[j][c];
    }
  double aa = 0.0, bb = 0.0, ab = 0.0;
  for (int j = 0; j < num; ++j)
  {
    place[j][0] = place[j][1] = 0.0;
    for (int c = 0; c < D; ++c)
    {
      place[j][0] += (x[j][c] - mean[c]) * a[c];
      place[j][1] += (x[j][c] - mean[c]) * b[c];
    }
    aa += place[j][0] * place[j][0];
    bb += place[j][1] * place[j][1];
    ab += place[j][0] * place[j][1];
  }
  const double moment = gap * size, factor = D == 3 ? moment / (aa * bb - ab * ab) : moment / aa;
  for (int j = 0; j < num; ++j)
  {
    w[j] = D == 3 ? factor * (bb * place[j][0] - ab * place[j][1]) : factor * place[j][0];
  }
}
} // namespace

/// The force of a closed node.
template <int D>
void NodeToSurface::add_node(const Touch& touch, const NodalState& state, double* f)
{
  const std::size_t i = touch.i;
  const double* n = touch.at.normal;
  const double per_k = compliance(touch, state.dt), k = 1.0 / per_k, normal_force = -k * touch.at.gap;
  double force[D], w[FacetElement::max_nodes] = {}, tangential_squared = 0.0;
  for (int c = 0; c < D; ++c)
    force[c] = normal_force * n[c];
  ContactStatus status = ContactStatus::slip;
  if (_options.friction > 0.0)
  {
    double motion[D], *t = _tangential.data() + i * D;
    for (int c = 0; c < D; ++c)
      motion[c] = state.du[std::size_t(touch.node) * D + c] - (_rigid ? _obstacle_increment[c] : 0.0);
    for (int j = 0; j < touch.num; ++j)
      for (int c = 0; c < D; ++c)
        motion[c] -= touch.phi[j] * _tracking.master_du()[std::size_t(touch.corners[j]) * D + c];
    const double part = counted_part(touch, state);
    for (int c = 0; c < D; ++c)
      motion[c] *= part;
    const bool slips = coulomb<D>(n, k, per_k, _options.friction * normal_force, t, motion);
    for (int c = 0; c < D; ++c)
    {
      tangential_squared += t[c] * t[c];
      force[c] += t[c];
    }
    if (slips)
    {
      double squared = 0.0;
      for (int c = 0; c < D; ++c)
      {
        squared += motion[c] * motion[c];
        _results.slip[i * D + c] += motion[c];
      }
      _energy.friction += std::sqrt(tangential_squared * squared);
    }
    else
      status = ContactStatus::stick;
    if (!_rigid && tangential_squared > 0.0)
      couple<D>(touch.num, touch.corners, _tracking.master_x(), n, touch.at.gap, t, w);
  }
  const double per_area = _per_area[i];
  for (int c = 0; c < D; ++c)
  {
    f[std::size_t(touch.node) * D + c] += force[c];
    _force[c] += force[c];
    _results.traction[i * D + c] = force[c] * per_area;
  }
  for (int j = 0; j < touch.num; ++j)
    for (int c = 0; c < D; ++c)
      _master_force[std::size_t(touch.corners[j]) * D + c] += w[j] * n[c] - touch.phi[j] * force[c];
  _closed[i] = 1;
  _stiffness[i] = k;
  _results.status[i] = status;
  _results.gap[i] = touch.at.gap;
  _results.pressure[i] = normal_force * per_area;
  _energy.stored += 0.5 * (k * touch.at.gap * touch.at.gap + tangential_squared * per_k);
}

template <int D>
void NodeToSurface::add_all(const NodalState& state, double* f)
{
  Touch touch;
  for (std::size_t i = 0; i < _candidates.nodes().size(); ++i)
    if ((_rigid || !_tracking.asleep(i)) && touches(i, state.u, state.du, touch))
      add_node<D>(touch, state, f);
  // Zero again for the next step.
  const auto masters = _tracking.master_nodes();
  for (std::size_t k = 0; k < masters.size(); ++k)
    for (int c = 0; c < D; ++c)
      f[std::size_t(masters[k]) * D + c] += std::exchange(_master_force[k * D + c], 0.0);
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
