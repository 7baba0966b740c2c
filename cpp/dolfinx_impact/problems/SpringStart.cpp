// SPDX-License-Identifier: MIT
#include "SpringStart.h"
#include "../common/OnAllRanks.h"
#include "../enforcement/node_to_surface/TrialSprings.h"
#include "../operators/RigidBodyModes.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace dolfinx_impact::problems
{
namespace
{
constexpr double first_guess = 1e-3; ///< of the distance that bounds the penetration: first guess of the approach
constexpr double margin = 1e-2;      ///< of their penetration, by which nodes that bear nothing are open
constexpr double close = 1e-6;       ///< relative accuracy of the approach
constexpr int most_iterations = 100;

/// Root between two places of different signs: Ridders (1979), IEEE Transactions on Circuits and Systems 26.
/// @param[in] f increases; f(low) <= 0 < f(high)
/// @param[in] f_low, f_high values there
/// @param[in] accuracy absolute
double root(const auto& f, double low, double f_low, double high, double f_high, double accuracy)
{
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < most_iterations && f_low < 0.0; ++i)
  {
    const double middle = 0.5 * (low + high), f_middle = f(middle);
    const double part = std::sqrt(f_middle * f_middle - f_low * f_high); // the product is negative
    const double x = std::clamp(middle - (middle - low) * f_middle / part, low, high);
    const double f_x = f(x);
    if (std::abs(x - last) <= accuracy + close * std::abs(x))
      return x;
    last = x;
    const auto take = [&](double place, double value)
    {
      if (value > 0.0 && place < high)
        high = place, f_high = value;
      else if (value <= 0.0 && place > low)
        low = place, f_low = value;
    };
    take(middle, f_middle);
    take(x, f_x);
  }
  return f_low < 0.0 ? last : low;
}

/// Part of the force on a node that presses it on the master.
/// @param[in] forces of all nodes [F]
/// @param[in] normals of the nodes with springs; i: number among them
double pressing(std::span<const double> forces, std::int32_t node, std::span<const double> normals, std::size_t i,
                int gdim)
{
  double out = 0.0;
  for (int c = 0; c < gdim; ++c)
    out += forces[std::size_t(node) * gdim + c] * normals[i * gdim + c];
  return out;
}
} // namespace

SpringStart::SpringStart(std::shared_ptr<const enforcement::StaticContact> steady, ExplicitProblem& problem,
                         std::size_t contact, bool supports_move)
    : _steady(std::move(steady)), _problem(problem), _pair(problem.contacts().at(contact).contact),
      _gdim(problem.displacement()->function_space()->mesh()->geometry().dim())
{
  for (const auto& direction : _pair.directions())
  {
    _springs.push_back(std::dynamic_pointer_cast<enforcement::NodePenalty>(direction));
    if (!_springs.back())
      throw std::invalid_argument(problem.contacts()[contact].name + " is to start with springs, and has none");
  }
  const auto V = problem.displacement()->function_space();
  MPI_Comm comm = V->mesh()->comm();
  _nodes = operators::nodes_of_bodies(*V, _springs.front()->candidates().nodes());
  for (std::int32_t node = 0; node < V->dofmap()->index_map->size_local(); ++node)
    _mass.push_back(problem.body().mass[std::size_t(node) * _gdim]);
  std::array<double, 3> held{}; // nodes of the body, in each direction
  for (const std::int32_t node : _nodes)
    for (int c = 0; c < _gdim && !supports_move; ++c)
      held[c] += problem.supports().mask()[std::size_t(node) * _gdim + c] ? 1.0 : 0.0;
  MPI_Allreduce(MPI_IN_PLACE, held.data(), 3, MPI_DOUBLE, MPI_SUM, comm);
  const std::vector<double> weight = _steady->weight(), pressure = _steady->pressure(), normal = _steady->normal();
  for (std::size_t i = 0; i < weight.size(); ++i)
    for (int c = 0; c < _gdim; ++c)
      _normal[c] += held[c] > 0.0 ? 0.0 : weight[i] * pressure[i] * normal[i * _gdim + c];
  MPI_Allreduce(MPI_IN_PLACE, _normal.data(), 3, MPI_DOUBLE, MPI_SUM, comm);
  _force = std::hypot(_normal[0], _normal[1], _normal[2]);
  for (double& component : _normal)
    component /= _force > 0.0 ? _force : 1.0;
}

/// Force of springs along the normal after a move over the one that they are to bear, minus one.
double SpringStart::excess(double distance) const
{
  const std::span<const double> u = _problem.displacement()->x()->array();
  std::vector<double> moved(u.begin(), u.end());
  move(moved, distance);
  enforcement::TrialSprings trial(*_problem.displacement()->function_space(), _pair, moved, _mass);
  const std::array<double, 3> force = trial.force(_problem.integrator().contact_step());
  return (force[0] * _normal[0] + force[1] * _normal[1] + force[2] * _normal[2]) / _force - 1.0;
}

double SpringStart::approach() const
{
  if (_force == 0.0)
    return 0.0;
  const double length = _springs.front()->facet_length();
  double step = first_guess * length, low = 0.0, high = 0.0, f_low = excess(0.0), f_high = f_low;
  if (f_low > 0.0)
    for (; f_low > 0.0; step *= 2.0)
    {
      high = std::exchange(low, low - step);
      f_high = std::exchange(f_low, excess(low));
    }
  else
    for (; f_high <= 0.0; step *= 2.0)
    {
      if (step > length)
        throw common::Failure("springs of the explicit contact do not bear the steady force: refine the mesh");
      low = std::exchange(high, high + step);
      f_low = std::exchange(f_high, excess(high));
    }
  return root([this](double distance) { return excess(distance); }, low, f_low, high, f_high, close * (high - low));
}

void SpringStart::move(std::span<double> u, double distance) const
{
  for (const std::int32_t node : _nodes)
    for (int c = 0; c < _gdim; ++c)
      u[std::size_t(node) * _gdim + c] -= distance * _normal[c];
}

bool SpringStart::close_nodes()
{
  _problem.integrator().update_gaps();
  bool closes = false;
  for (const auto& springs : _springs)
    closes = close_nodes_of(*springs) || closes;
  return closes;
}

bool SpringStart::close_nodes_of(enforcement::NodePenalty& springs) const
{
  const std::vector<double> forces = _steady->contact_forces();
  const enforcement::NodalResults& results = springs.results();
  const std::span<const std::int32_t> nodes = springs.candidates().nodes();
  state::State state = springs.saved_state();
  const auto closed = state.values<std::int8_t>("closed");
  const std::span<double> offset = state.values<double>("spring_offset");
  const std::vector<double> stiffnesses = springs.stiffness();
  const double depth = first_guess * springs.facet_length();
  int num = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (!(stiffnesses[i] > 0.0) && std::isfinite(results.gap[i]) &&
        pressing(forces, nodes[i], results.normal, i, _gdim) > 0.0)
    {
      closed[i] = 1;
      offset[i] = -results.gap[i] - depth;
      ++num;
    }
  MPI_Allreduce(MPI_IN_PLACE, &num, 1, MPI_INT, MPI_SUM, _problem.displacement()->function_space()->mesh()->comm());
  if (num > 0)
    springs.resume(state);
  return num > 0;
}

void SpringStart::hand_over()
{
  _problem.integrator().update_gaps();
  for (const auto& springs : _springs)
    hand_over_to(*springs);
}

void SpringStart::hand_over_to(enforcement::NodePenalty& springs) const
{
  std::vector<double> forces = _steady->contact_forces();
  for (double& force : forces)
    force /= double(_springs.size());
  const enforcement::NodalResults& results = springs.results();
  const std::span<const std::int32_t> nodes = springs.candidates().nodes();
  const std::vector<double> stiffnesses = springs.stiffness();
  state::State state = springs.saved_state();
  const auto column = [&state](const char* name) { return state.values<double>(name); };
  const auto closed = state.values<std::int8_t>("closed");
  const std::span<double> tangential = column("tangential"), force = column("spring_force"),
                          compliance = column("spring_compliance"), gap = column("spring_gap"),
                          offset = column("spring_offset");
  for (const char* name : {"spring_surplus", "spring_tangential_surplus", "energies"})
    std::ranges::fill(column(name), 0.0);
  for (std::size_t i = 0; i < nodes.size(); ++i)
  {
    const double *given = forces.data() + std::size_t(nodes[i]) * _gdim, *normal = results.normal.data() + i * _gdim;
    const double pressed = pressing(forces, nodes[i], results.normal, i, _gdim), stiffness = stiffnesses[i];
    const bool inside = stiffness > 0.0, bears = inside && pressed > 0.0;
    const double found = inside ? results.gap[i] : 0.0; // nodes without a master have an infinite one
    compliance[i] = inside ? 1.0 / stiffness : 0.0;
    closed[i] = bears;
    force[i] = bears ? pressed : 0.0;
    gap[i] = bears ? -pressed * compliance[i] : 0.0;
    // Nodes beside the contact, which the approach has pushed in, stay just open.
    offset[i] = !inside ? 0.0 : bears ? gap[i] - found : margin * std::abs(found) - found;
    for (int c = 0; c < _gdim; ++c)
      tangential[i * _gdim + c] = bears ? given[c] - pressed * normal[c] : 0.0;
  }
  springs.resume(state);
}
} // namespace dolfinx_impact::problems
