// SPDX-License-Identifier: MIT
#include "ReducedContacts.h"
#include "../common/agree.h"
#include <cmath>

namespace dolfinx_impact::rolling
{
namespace
{
/// Relative change of the flow with which the compliance of velocities is made again.
constexpr double other_flow = 0.05;

std::vector<std::int8_t> as_mask(const std::vector<double>& values)
{
  return {values.begin(), values.end()};
}
} // namespace

ReducedContacts::ReducedContacts(const surface::FunctionSpace& V, std::vector<std::int8_t> fixed)
    : _comm(V.mesh()->comm()), _response(V, std::move(fixed))
{
}

ReducedContacts::Solution ReducedContacts::forces(const ContactOperators& operators,
                                                  const std::vector<std::vector<std::int8_t>>& near, const States& at,
                                                  const ReducedTorque* torque)
{
  update(operators, near);
  const Candidates& candidates = *_candidates;
  const int g = operators.gdim();
  Candidates::ByContact friction;
  std::vector<std::vector<std::int8_t>> carriers;
  std::vector<std::size_t> sizes;
  for (const RollingContact* c : operators.contacts())
  {
    friction.emplace_back(c->nodes().size(), c->steady_friction());
    carriers.push_back(c->carriers());
    sizes.push_back(c->nodes().size());
  }
  const LinearState state{candidates.gather(at.forces, g), candidates.gather(at.gaps, 1),
                          candidates.gather(at.slips, g)};
  CandidateNodes nodes{g, candidates.gather(operators.frames(), g * g), candidates.gather(friction, 1),
                       as_mask(candidates.gather(carriers, 1)), as_mask(candidates.gather(operators.held(), g))};
  std::optional<TorqueOfCandidates> reduced;
  if (torque)
    reduced = torque->gathered(operators, candidates);
  TorqueOfCandidates::Solution found;
  int rank = 0;
  MPI_Comm_rank(_comm, &rank);
  const auto solve = [&]
  {
    if (rank != 0)
      return;
    const FrictionProblem problem(std::move(nodes), _compliance);
    if (reduced)
      found = reduced->solve(problem, state);
    else
    {
      FrictionProblem::Solution alone = problem.solve(state);
      found = {std::move(alone.forces), 0.0, std::move(alone.fault)};
    }
  };
  common::agree(_comm, solve);
  MPI_Bcast(&found.change, 1, MPI_DOUBLE, 0, _comm);
  int length = int(found.fault.size());
  MPI_Bcast(&length, 1, MPI_INT, 0, _comm);
  found.fault.resize(length);
  MPI_Bcast(found.fault.data(), length, MPI_CHAR, 0, _comm);
  return {candidates.scatter(found.forces, sizes, g), found.change, std::move(found.fault)};
}

/// Candidates and their compliance. Collective.
void ReducedContacts::update(const ContactOperators& operators, const std::vector<std::vector<std::int8_t>>& near)
{
  double speed = 0.0;
  for (const RollingContact* c : operators.contacts())
    speed += c->speed();
  int renew = !_candidates || _response.num_factors() != _factors || std::abs(speed - _speed) > other_flow * _speed;
  for (std::size_t k = 0; k < _chosen.size(); ++k)
    for (std::size_t i = 0; i < near[k].size(); ++i)
      renew = renew || (near[k][i] && !_chosen[k][i]);
  MPI_Allreduce(MPI_IN_PLACE, &renew, 1, MPI_INT, MPI_MAX, _comm);
  if (!renew)
    return;
  std::vector<std::vector<std::int8_t>> chosen(near);
  for (std::size_t k = 0; k < _chosen.size(); ++k)
    for (std::size_t i = 0; i < near[k].size(); ++i)
      chosen[k][i] = chosen[k][i] || _chosen[k][i];
  _chosen = std::move(chosen);
  _candidates.emplace(_comm, _chosen);
  _compliance = _response.compliance(operators, *_candidates);
  _factors = _response.num_factors();
  _speed = speed;
}
} // namespace dolfinx_impact::rolling
