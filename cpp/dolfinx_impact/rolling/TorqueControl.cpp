// SPDX-License-Identifier: MIT
#include "TorqueControl.h"
#include "../common/gather.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::rolling
{
namespace
{
std::vector<double> sum_of_forces(std::span<RollingContact* const> contacts)
{
  std::vector<double> out;
  for (const RollingContact* c : contacts)
  {
    const std::vector<double> forces = c->contact_forces();
    out.resize(forces.size(), 0.0);
    for (std::size_t k = 0; k < forces.size(); ++k)
      out[k] += forces[k];
  }
  return out;
}
} // namespace

TorqueControl::TorqueControl(std::shared_ptr<const solve::EquilibriumProblem> problem, const Flow& flow,
                             const Motion& motion, double target)
    : _problem(problem), _torque(std::move(problem), flow, motion), _target(target), _reach(_torque.reach())
{
}

double TorqueControl::error(std::span<RollingContact* const> contacts) const
{
  std::vector<std::vector<double>> forces;
  double torque = 0.0;
  for (const RollingContact* c : contacts)
    torque += _torque.of(forces.emplace_back(c->contact_forces()));
  return relative(torque, forces);
}

double TorqueControl::relative(double torque, std::span<const std::vector<double>> forces) const
{
  double here = 0.0;
  for (const std::vector<double>& one : forces)
    for (double f : one)
      here += f * f;
  const double scale = std::sqrt(common::sum(_problem->comm(), here)) * _reach, off = std::abs(torque - _target);
  return scale > 0.0 ? off / scale : off;
}

std::vector<double> TorqueControl::residual_slope() const
{
  const double omega = this->omega();
  const double step = omega != 0.0 ? 0.5 * omega : 1.0; // forces are quadratic in it: any step gives the derivative
  set_omega(omega + step);
  std::vector<double> out = operators::values_of(_problem->body->residual());
  set_omega(omega - step);
  const std::vector<double> below = operators::values_of(_problem->body->residual());
  set_omega(omega);
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = (out[k] - below[k]) / (2.0 * step);
  return out;
}

ReducedTorque::ReducedTorque(const TorqueControl& control, std::span<RollingContact* const> contacts,
                             BodyResponse& response)
    : _control(control), _contacts(contacts.begin(), contacts.end()), _load(control.residual_slope()),
      _forces(sum_of_forces(contacts))
{
  const Motion& spin = control.torque().motion();
  for (const RollingContact* c : _contacts)
  {
    _slopes.push_back(c->velocity_slope(spin, c->geometry().now().u));
    _speed = std::max(_speed, c->speed());
  }
  std::vector<double> down(_load);
  for (double& f : down)
    f = -f;
  BodyResponse::Solution turned = response.solve(std::move(down));
  BodyResponse::Solution lever = response.solve(control.torque().lever_of(_forces));
  _turned = std::move(turned.displacements);
  _lever = std::move(lever.displacements);
  _fault = turned.fault.empty() ? lever.fault : turned.fault;
}

double ReducedTorque::value(std::span<const double> nodal_forces, std::span<const double> moved) const
{
  return _control.torque().of(nodal_forces) + _control.torque().of(_forces, moved);
}

double ReducedTorque::missing(const ContactOperators& operators, const Candidates::ByContact& forces,
                              std::span<const double> moved) const
{
  const std::vector<std::vector<double>> here{operators.nodal_forces(forces)};
  return _control.relative(value(here.front(), moved), here);
}

void ReducedTorque::count_from(const ContactOperators& operators, const Candidates::ByContact& forces,
                               std::span<const double> moved)
{
  _now = value(operators.nodal_forces(forces), moved);
}

TorqueOfCandidates ReducedTorque::gathered(const ContactOperators& operators, const Candidates& candidates) const
{
  Candidates::ByContact row = operators.jumps(_control.torque().lever());
  const Candidates::ByContact by_motion = operators.jumps(_lever);
  Candidates::ByContact gaps, slips;
  for (std::size_t k = 0; k < _contacts.size(); ++k)
  {
    for (std::size_t i = 0; i < row[k].size(); ++i)
      row[k][i] += by_motion[k][i];
    gaps.push_back(_contacts[k]->gap_change(_turned));
    std::vector<double>& slip = slips.emplace_back(_contacts[k]->slip_change(_turned));
    for (std::size_t i = 0; i < slip.size(); ++i)
      slip[i] += _slopes[k][i];
  }
  const int g = operators.gdim();
  TorqueOfCandidates out;
  out.wanted = _control.target() - _now;
  out.row = candidates.gather(row, g);
  out.by_spin = _control.torque().of(_forces, _turned);
  out.slope.forces.assign(out.row.size(), 0.0);
  out.slope.gap = candidates.gather(gaps, 1);
  out.slope.slip = candidates.gather(slips, g);
  out.speed = _speed;
  return out;
}
} // namespace dolfinx_impact::rolling
