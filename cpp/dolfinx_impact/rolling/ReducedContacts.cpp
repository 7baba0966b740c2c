// SPDX-License-Identifier: MIT
#include "ReducedContacts.h"
#include "../common/agree.h"
#include <algorithm>
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
  Candidates::ByContact friction, fields, number, areas = operators.weights();
  int width = 1;
  for (const RollingContact* c : operators.contacts())
    if (const auto& law = c->options().friction_law)
      width = std::max(width, 2 * int(law->fields().size()));
  std::vector<std::vector<std::int8_t>> carriers;
  std::vector<std::size_t> sizes;
  for (const RollingContact* c : operators.contacts())
  {
    const std::size_t num = c->nodes().size();
    friction.emplace_back(num, c->options().friction);
    number.emplace_back(num, double(number.size()));
    std::vector<double>& values = fields.emplace_back(num * width, 0.0);
    if (c->options().friction_law)
    {
      const enforcement::FrictionPoints found = c->law_points();
      for (std::size_t f = 0; f < found.slave_fields.size(); ++f)
        for (std::size_t i = 0; i < num; ++i)
        {
          values[i * width + 2 * f] = found.slave_fields[f][i];
          values[i * width + 2 * f + 1] = found.master_fields[f][i];
        }
    }
    carriers.push_back(c->carriers());
    sizes.push_back(c->nodes().size());
  }
  const LinearState state{candidates.gather(at.forces, g), candidates.gather(at.gaps, 1),
                          candidates.gather(at.slips, g)};
  CandidateNodes nodes{g,
                       candidates.gather(operators.frames(), g * g),
                       candidates.gather(friction, 1),
                       as_mask(candidates.gather(carriers, 1)),
                       as_mask(candidates.gather(operators.held(), g)),
                       {}};
  const std::vector<double> numbers = candidates.gather(number, 1), all_fields = candidates.gather(fields, width),
                            all_areas = candidates.gather(areas, 1);
  for (std::size_t k = 0; k < operators.contacts().size(); ++k)
    if (const auto& law = operators.contacts()[k]->options().friction_law)
    {
      CandidateLaw& of = nodes.laws.emplace_back();
      of.law = law.get();
      for (std::size_t i = 0; i < numbers.size(); ++i)
        if (numbers[i] == double(k))
          of.nodes.push_back(i);
      of.points = law->make_points(of.nodes.size());
      for (std::size_t q = 0; q < of.nodes.size(); ++q)
      {
        const std::size_t i = of.nodes[q];
        of.areas.push_back(all_areas[i]);
        std::copy_n(&nodes.frames[i * g * g], g, &of.points.normal[q * g]);
        for (std::size_t f = 0; f < law->fields().size(); ++f)
        {
          of.points.slave_fields[f][q] = all_fields[i * width + 2 * f];
          of.points.master_fields[f][q] = all_fields[i * width + 2 * f + 1];
        }
      }
    }
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
