// SPDX-License-Identifier: MIT
#include "static_state.h"
#include "../common/dolfinx_api.h"
#include "contact_states.h"
#include <algorithm>
#include <stdexcept>

using dolfinx_impact::state::Place;
using dolfinx_impact::state::State;

namespace dolfinx_impact::problems
{
namespace
{
/// Whether a load is nodal forces; otherwise it is the same numbers on all ranks. Collective.
bool is_nodal(const solve::EquilibriumProblem& equilibrium, std::size_t size)
{
  int nodal = size == equilibrium.num_owned() || size == equilibrium.fixed.size();
  MPI_Allreduce(MPI_IN_PLACE, &nodal, 1, MPI_INT, MPI_MIN, equilibrium.comm());
  return nodal != 0;
}
} // namespace

State saved_state(StaticProblem& problem)
{
  const solve::EquilibriumProblem& p = *problem.equilibrium();
  State out("static problem");
  const auto u = common::array(*p.u->x()).subspan(0, p.num_owned());
  out.add_own("displacement", Place::node, std::vector<double>(u.begin(), u.end()), p.space().dofmap()->index_map_bs());
  if (State bodies = p.body->saved_state(); !bodies.fields().empty())
    out.add(std::move(bodies));
  State reached("reached");
  for (std::size_t i = 0; i < problem.loads().size(); ++i)
  {
    std::span<const double> values = problem.loads()[i].reached;
    const bool nodal = is_nodal(p, values.size());
    if (nodal) // forces of ghosts are not read
      values = values.first(p.num_owned());
    reached.add_own("load " + std::to_string(i), nodal ? Place::node : Place::all,
                    std::vector<double>(values.begin(), values.end()), nodal ? p.space().dofmap()->index_map_bs() : 1);
  }
  out.add(std::move(reached));
  add_contacts(out, p.contacts);
  return out;
}

void resume(StaticProblem& problem, const State& saved)
{
  const solve::EquilibriumProblem& p = *problem.equilibrium();
  const State& reached = saved.part("reached");
  for (std::size_t i = 0; i < problem.loads().size(); ++i)
    if (reached.field("load " + std::to_string(i)).size() > problem.loads()[i].reached.size())
      throw std::invalid_argument("load " + std::to_string(i) + " has another number of values");
  for (std::size_t i = 0; i < problem.loads().size(); ++i)
    std::ranges::copy(reached.values<double>("load " + std::to_string(i)), problem.loads()[i].reached.begin());
  std::ranges::copy(saved.values<double>("displacement"), common::array(*p.u->x()).begin());
  problem.resume();
  if (const State bodies = p.body->saved_state(); !bodies.fields().empty())
    p.body->resume(saved.part("material"));
  resume_contacts(saved, p.contacts, p.u->x()->array());
}
} // namespace dolfinx_impact::problems
