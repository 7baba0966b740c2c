#include "NodeToSurface.h"
#include "../common/vectors.h"
#include "../search/linear_facet.h"
#include "friction.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

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
  shape_values(master.displacement, at.xi, touch.phi);
  _tracking.hold(i, at);
  return true;
}

double NodeToSurface::stiffness(const Touch& touch, double dt) const
{
  const double area = _candidates.areas()[touch.i];
  if (_options.penalty > 0.0)
    return _share * _options.penalty * area;
  double compliance = 1.0 / _mass[touch.i], masters = 0.0;
  for (int j = 0; j < touch.num; ++j)
  {
    const double weight = std::abs(touch.phi[j]);
    compliance += weight * _inverse[2 * touch.masters[j]];
    masters += weight * _inverse[2 * touch.masters[j] + 1];
  }
  return _share * _options.kappa / (dt * dt * (compliance + masters / area));
}

/// Values at the node less those at its master point.
void NodeToSurface::relative(const Touch& touch, const double* values, double* out) const
{
  for (int c = 0; c < _gdim; ++c)
    out[c] = values[std::size_t(touch.node) * _gdim + c];
  for (int j = 0; j < touch.num; ++j)
    for (int c = 0; c < _gdim; ++c)
      out[c] -= touch.phi[j] * values[std::size_t(touch.masters[j]) * _gdim + c];
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

/// Forces along the normal on the master's nodes, linear in their place along the tangent plane, without resultant:
/// friction on the slave and on the master acts at points that are a gap apart, and this turns back by as much.
void NodeToSurface::add_couple(const Touch& touch, const double* u, const double* tangential, double* f) const
{
  const surface::Facets& master = _tracking.master();
  const double* X = master.X_of(touch.at.facet);
  const double* n = touch.at.normal;
  const int num = touch.num, D = _gdim;
  double b[2][3] = {}, x[FacetElement::max_nodes][3] = {}, mean[3] = {};
  if (D == 2)
  {
    b[0][0] = -n[1];
    b[0][1] = n[0];
  }
  else
  {
    const int least = std::abs(n[0]) < std::abs(n[1]) ? (std::abs(n[0]) < std::abs(n[2]) ? 0 : 2)
                                                      : (std::abs(n[1]) < std::abs(n[2]) ? 1 : 2);
    for (int c = 0; c < 3; ++c)
      b[0][c] = (c == least ? 1.0 : 0.0) - n[least] * n[c];
    const double length = std::sqrt(dot(b[0], b[0], 3));
    for (double& c : b[0])
      c /= length;
    for (int c = 0; c < 3; ++c)
      b[1][c] = n[(c + 1) % 3] * b[0][(c + 2) % 3] - n[(c + 2) % 3] * b[0][(c + 1) % 3];
  }
  for (int j = 0; j < num; ++j)
    for (int c = 0; c < D; ++c)
    {
      x[j][c] = X[j * D + c] + u[std::size_t(touch.masters[j]) * D + c];
      mean[c] += x[j][c] / num;
    }
  double place[FacetElement::max_nodes][2] = {}, S[3] = {};
  for (int j = 0; j < num; ++j)
  {
    for (int c = 0; c < D; ++c)
      x[j][c] -= mean[c];
    for (int a = 0; a < D - 1; ++a)
      place[j][a] = dot(x[j], b[a], D);
    S[0] += place[j][0] * place[j][0];
    S[1] += place[j][1] * place[j][1];
    S[2] += place[j][0] * place[j][1];
  }
  const double t[2] = {touch.at.gap * dot(tangential, b[0], D), D == 3 ? touch.at.gap * dot(tangential, b[1], D) : 0.0};
  const double det = D == 3 ? S[0] * S[1] - S[2] * S[2] : S[0];
  const double slope[2] = {D == 3 ? (S[1] * t[0] - S[2] * t[1]) / det : t[0] / det,
                           D == 3 ? (S[0] * t[1] - S[2] * t[0]) / det : 0.0};
  for (int j = 0; j < num; ++j)
  {
    const double w = slope[0] * place[j][0] + slope[1] * place[j][1];
    for (int c = 0; c < D; ++c)
      f[std::size_t(touch.masters[j]) * D + c] += w * n[c];
  }
}

void NodeToSurface::add_forces(const NodalState& state, double* f)
{
  const int D = _gdim;
  _force.fill(0.0);
  _energy.stored = 0.0;
  if (!_rigid)
  {
    _candidates.advance(state.dt);
    _tracking.advance(state.u, state.du);
  }
  Touch touch;
  for (std::size_t i = 0; i < _candidates.nodes().size(); ++i)
  {
    if ((!_rigid && _tracking.asleep(i)) || !touches(i, state.u, state.du, touch))
      continue;
    const double k = stiffness(touch, state.dt), normal_force = -k * touch.at.gap;
    const double area = _candidates.areas()[i];
    double force[3], *traction = _results.traction.data() + i * D;
    for (int c = 0; c < D; ++c)
      force[c] = normal_force * touch.at.normal[c];
    ContactStatus status = ContactStatus::slip;
    double tangential_squared = 0.0;
    if (_options.friction > 0.0)
    {
      double increment[3];
      relative(touch, state.du, increment);
      const double part = counted_part(touch, state);
      for (int c = 0; c < D; ++c)
        increment[c] = part * (increment[c] - (_rigid ? _obstacle_increment[c] : 0.0));
      double* last = _tangential.data() + i * D;
      const FrictionResult result =
          evaluate(Friction{D, normal_force, _options.friction, k, touch.at.normal, last, increment});
      status = result.slips ? ContactStatus::slip : ContactStatus::stick;
      std::copy_n(result.traction, D, last);
      tangential_squared = dot(last, last, D);
      if (result.slips)
      {
        for (int c = 0; c < D; ++c)
          _results.slip[i * D + c] += result.slip[c];
        _energy.friction += std::sqrt(tangential_squared * dot(result.slip, result.slip, D));
      }
      for (int c = 0; c < D; ++c)
        force[c] += last[c];
      if (!_rigid && tangential_squared > 0.0)
        add_couple(touch, state.u, last, f);
    }
    for (int c = 0; c < D; ++c)
    {
      f[std::size_t(touch.node) * D + c] += force[c];
      _force[c] += force[c];
      traction[c] = force[c] / area;
    }
    for (int j = 0; j < touch.num; ++j)
      for (int c = 0; c < D; ++c)
        f[std::size_t(touch.masters[j]) * D + c] -= touch.phi[j] * force[c];
    _closed[i] = 1;
    _stiffness[i] = k;
    _results.status[i] = status;
    _results.gap[i] = touch.at.gap;
    _results.pressure[i] = normal_force / area;
    _energy.stored += 0.5 * (k * touch.at.gap * touch.at.gap + (k > 0.0 ? tangential_squared / k : 0.0));
  }
  if (_other)
  {
    _other->add_forces(state, f);
    for (int c = 0; c < D; ++c)
      _force[c] -= _other->_force[c];
  }
}
} // namespace impact::enforcement
