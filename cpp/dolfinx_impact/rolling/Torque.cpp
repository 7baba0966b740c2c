// SPDX-License-Identifier: MIT
#include "Torque.h"
#include "../common/dolfinx_api.h"
#include "../common/gather.h"
#include "../common/vectors.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::rolling
{
Torque::Torque(std::shared_ptr<const solve::EquilibriumProblem> problem, const Flow& flow, const Motion& motion)
    : _problem(std::move(problem)), _motion(&motion), _gdim(flow.gdim())
{
  const std::int32_t owned = _problem->space().dofmap()->index_map->size_local();
  for (std::int32_t node : motion.nodes)
    if (node < owned)
    {
      _nodes.push_back(node);
      for (int c = 0; c < 3; ++c)
        _arm.push_back(c < _gdim ? flow.place(node)[c] - motion.spin()->point[c] : 0.0);
    }
}

double Torque::sum_over_ranks(double here) const
{
  return common::sum(_problem->comm(), here);
}

std::array<double, 3> Torque::axle() const
{
  std::array<double, 6> sums{}; // numbers of prescribed components, then sums of their displacements
  const std::span<const double> u = common::array(*_problem->u->x());
  for (std::int32_t node : _nodes)
    for (int c = 0; c < _gdim; ++c)
      if (const std::size_t dof = std::size_t(node) * _gdim + c; _problem->fixed[dof])
      {
        sums[c] += 1.0;
        sums[3 + c] += u[dof];
      }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 6, MPI_DOUBLE, MPI_SUM, _problem->comm());
  std::array<double, 3> out{};
  for (int c = 0; c < 3; ++c)
    out[c] = sums[3 + c] / std::max(sums[c], 1.0);
  return out;
}

/// axis x vector, (3).
void Torque::turned(const double* vector, double* out) const
{
  cross(_motion->spin()->axis.data(), vector, out);
}

/// axis x (deformed place - a point on the axis), [i*gdim + c] [L]. Collective.
std::vector<double> Torque::deformed() const
{
  const std::array<double, 3> axle = this->axle();
  const std::span<const double> u = common::array(*_problem->u->x());
  std::vector<double> out(_nodes.size() * _gdim);
  for (std::size_t i = 0; i < _nodes.size(); ++i)
  {
    double arm[3], full[3];
    for (int c = 0; c < 3; ++c)
      arm[c] = _arm[i * 3 + c] - axle[c] + (c < _gdim ? u[std::size_t(_nodes[i]) * _gdim + c] : 0.0);
    turned(arm, full);
    std::copy_n(full, _gdim, &out[i * _gdim]);
  }
  return out;
}

double Torque::of(std::span<const double> forces) const
{
  const std::vector<double> lever = deformed();
  double here = 0.0;
  for (std::size_t i = 0; i < _nodes.size(); ++i)
    here -= dot(&forces[std::size_t(_nodes[i]) * _gdim], &lever[i * _gdim], _gdim);
  return sum_over_ranks(here);
}

double Torque::of(std::span<const double> forces, std::span<const double> moved) const
{
  double here = 0.0;
  for (std::int32_t node : _nodes)
  {
    double arm[3] = {0.0, 0.0, 0.0}, full[3];
    std::copy_n(&moved[std::size_t(node) * _gdim], _gdim, arm);
    turned(arm, full);
    here -= dot(&forces[std::size_t(node) * _gdim], full, _gdim);
  }
  return sum_over_ranks(here);
}

std::vector<double> Torque::lever() const
{
  const std::vector<double> deformed = this->deformed();
  std::vector<double> out(num_owned(), 0.0);
  for (std::size_t i = 0; i < _nodes.size(); ++i)
    for (int c = 0; c < _gdim; ++c)
      out[std::size_t(_nodes[i]) * _gdim + c] = -deformed[i * _gdim + c];
  return out;
}

std::vector<double> Torque::lever_of(std::span<const double> forces) const
{
  std::vector<double> out(num_owned(), 0.0);
  for (std::int32_t node : _nodes)
  {
    double force[3] = {0.0, 0.0, 0.0}, full[3];
    std::copy_n(&forces[std::size_t(node) * _gdim], _gdim, force);
    turned(force, full); // -f . (axis x m) = m . (axis x f)
    std::copy_n(full, _gdim, &out[std::size_t(node) * _gdim]);
  }
  return out;
}

void Torque::set_rigid_velocities(std::vector<double>& velocities) const
{
  const std::vector<double> deformed = this->deformed();
  for (std::size_t i = 0; i < _nodes.size(); ++i)
    for (int c = 0; c < _gdim; ++c)
      velocities[std::size_t(_nodes[i]) * _gdim + c] = _motion->rate->value[0] * deformed[i * _gdim + c];
}

double Torque::reach() const
{
  double here = 0.0;
  for (std::size_t i = 0; i < _nodes.size(); ++i)
  {
    double full[3];
    turned(&_arm[i * 3], full);
    here = std::max(here, dot(full, full, 3));
  }
  return std::sqrt(common::largest(_problem->comm(), here));
}
} // namespace dolfinx_impact::rolling
