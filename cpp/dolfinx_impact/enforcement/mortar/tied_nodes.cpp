// SPDX-License-Identifier: MIT
#include "tied_nodes.h"
#include "../../common/gather.h"
#include "../../operators/nodal_sums.h"
#include <algorithm>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
namespace
{
typedef std::vector<std::int8_t> Marks; ///< of owned and ghost nodes

/// Nodes of a contact's surfaces. Collective.
Marks surfaces(const MortarContact& contact)
{
  const auto map = contact.geometry().map();
  std::vector<double> sums(map->size_local() + map->num_ghosts(), 0.0);
  for (const surface::Facets* side : {&contact.geometry().slave(), contact.geometry().master()})
    if (side)
      for (std::int32_t node : side->nodes)
        sums[node] = 1.0;
  sums = operators::sum_over_ranks(map, std::move(sums), 1);
  Marks out(sums.size());
  std::ranges::transform(sums, out.begin(), [](double s) { return s > 0.0; });
  return out;
}

/// Slave nodes of a contact. Collective.
Marks slaves(const MortarContact& contact)
{
  const auto map = contact.geometry().map();
  std::vector<double> sums(map->size_local() + map->num_ghosts(), 0.0);
  for (std::int32_t node : contact.geometry().slave().nodes)
    sums[node] = 1.0;
  sums = operators::sum_over_ranks(map, std::move(sums), 1);
  Marks out(sums.size());
  std::ranges::transform(sums, out.begin(), [](double s) { return s > 0.0; });
  return out;
}

/// Have two sets of nodes one in common, on any rank? Collective.
bool meet(MPI_Comm comm, const Marks& a, const Marks& b)
{
  bool here = false;
  for (std::size_t k = 0; k < a.size(); ++k)
    here = here || (a[k] && b[k]);
  return common::largest(comm, here) > 0.0;
}
} // namespace

bool connect(std::span<Tie* const> ties, std::span<MortarContact* const> contacts)
{
  if (ties.empty())
    return false;
  const MPI_Comm comm = ties[0]->conditions().comm();
  bool shared = false;
  for (std::size_t a = 0; a < ties.size(); ++a)
    for (std::size_t b = 0; b < ties.size(); ++b)
    {
      if (a == b)
        continue;
      const TieConditions &one = ties[a]->conditions(), &other = ties[b]->conditions();
      const bool same = meet(comm, one.marks(true, false), other.marks(true, false)),
                 chained = meet(comm, one.marks(true, false), other.marks(false, true));
      shared = shared || same || chained;
      const auto facets = [](const surface::Facets& first, const surface::Facets& second)
      {
        return std::ranges::any_of(first.id, [&](std::int64_t id) { return std::ranges::count(second.id, id) > 0; });
      };
      const bool crossed = common::largest(comm, facets(one.slave(), other.master())) > 0.0,
                 back = common::largest(comm, facets(one.master(), other.slave())) > 0.0;
      if (crossed && back)
        throw std::invalid_argument(ties[a]->name() + " and " + ties[b]->name() +
                                    ": the slave of each is the master of the other; one tie holds both: leave one out");
    }
  for (const MortarContact* contact : contacts)
  {
    const Marks all = surfaces(*contact), own = slaves(*contact);
    for (const Tie* tie : ties)
      shared = shared || meet(comm, tie->conditions().marks(true, false), all) ||
               meet(comm, tie->conditions().marks(false, true), own);
  }
  // A node that several ties hold has the conditions of the first; the others' functions go to their neighbours.
  const auto& conditions = ties[0]->conditions();
  const std::size_t g = conditions.gdim();
  Marks taken(std::size_t(conditions.space().dofmap()->index_map->size_local()) * g, 0);
  for (Tie* tie : ties)
  {
    const Constraints& rows = tie->conditions().rows();
    bool here = false;
    for (std::size_t k = 0; k < rows.size(); ++k)
      for (std::size_t c = 0; c < g; ++c)
        here = here || taken[rows.nodes[k] * g + c];
    if (common::largest(comm, here) > 0.0)
      tie->leave_out(taken);
    const Constraints& kept = tie->conditions().rows();
    for (std::size_t k = 0; k < kept.size(); ++k)
      for (std::size_t c = 0; c < g; ++c)
        for (std::size_t d = 0; d < g; ++d)
          taken[kept.nodes[k] * g + c] |=
              kept.constrained[k * g + d] && tie->conditions().directions()[(k * g + c) * g + d] != 0.0;
  }
  return shared;
}
} // namespace dolfinx_impact::enforcement
