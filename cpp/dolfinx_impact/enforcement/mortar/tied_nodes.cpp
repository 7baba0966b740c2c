// SPDX-License-Identifier: MIT
#include "tied_nodes.h"
#include "../../common/gather.h"
#include "../../operators/nodal_sums.h"
#include <algorithm>
#include <stdexcept>
#include <unordered_set>

namespace dolfinx_impact::enforcement
{
namespace
{
typedef std::vector<std::int8_t> Marks; ///< of owned and ghost nodes

/// Nodes of a contact's surfaces, or of its slave alone. Collective.
Marks nodes_of(const MortarContact& contact, bool master)
{
  const auto map = contact.geometry().map();
  std::vector<double> sums(map->size_local() + map->num_ghosts(), 0.0);
  for (const surface::Facets* side : {&contact.geometry().slave(), contact.geometry().master()})
    if (side && (master || side == &contact.geometry().slave()))
      for (std::int32_t node : side->nodes)
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
/// Have two surfaces a facet in common, on any rank? Collective.
bool overlap(MPI_Comm comm, const surface::Facets& a, const surface::Facets& b)
{
  const std::unordered_set<std::int64_t> ids(b.id.begin(), b.id.end());
  return common::largest(comm, std::ranges::any_of(a.id, [&](std::int64_t id) { return ids.contains(id); })) > 0.0;
}

/// Refuse ties that hold each other's surfaces, and leave out of each what an earlier one holds. Collective.
/// @returns whether slave nodes of one belong to another
template <typename T>
bool separate(std::span<T* const> ties)
{
  const MPI_Comm comm = ties[0]->conditions().comm();
  bool shared = false;
  for (std::size_t a = 0; a < ties.size(); ++a)
    for (std::size_t b = 0; b < ties.size(); ++b)
    {
      if (a == b)
        continue;
      const TieConditions &one = ties[a]->conditions(), &other = ties[b]->conditions();
      shared = meet(comm, one.marks(true, false), other.marks(true, true)) || shared;
      const bool crossed = overlap(comm, one.slave(), other.master()),
                 back = overlap(comm, one.master(), other.slave()),
                 twice = overlap(comm, one.slave(), other.slave()) && overlap(comm, one.master(), other.master());
      const std::string names = one.options().name + " and " + other.options().name;
      if (crossed && back)
        throw std::invalid_argument(names + ": the slave of each is the master of the other; one tie holds both: leave "
                                            "one out");
      if (twice)
        throw std::invalid_argument(names + " tie the same surfaces twice: leave one out");
    }
  // A node that several ties hold has the conditions of the first; the others' functions go to their neighbours.
  const std::size_t g = ties[0]->conditions().gdim();
  Marks taken(std::size_t(ties[0]->conditions().space().dofmap()->index_map->size_local()) * g, 0);
  for (T* tie : ties)
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
} // namespace

bool connect(std::span<Tie* const> ties, std::span<MortarContact* const> contacts)
{
  if (ties.empty())
    return false;
  const MPI_Comm comm = ties[0]->conditions().comm();
  bool shared = separate(ties);
  for (const MortarContact* contact : contacts)
  {
    const Marks all = nodes_of(*contact, true), own = nodes_of(*contact, false);
    for (const Tie* tie : ties)
    {
      shared = meet(comm, tie->conditions().marks(true, false), all) || shared;
      shared = meet(comm, tie->conditions().marks(false, true), own) || shared;
    }
  }
  return shared;
}

void connect(std::span<ExplicitTie* const> ties)
{
  if (!ties.empty())
    separate(ties);
}
} // namespace dolfinx_impact::enforcement
