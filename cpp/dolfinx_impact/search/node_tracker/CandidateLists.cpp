// SPDX-License-Identifier: MIT
#include "CandidateLists.h"

namespace dolfinx_impact::search
{
void CandidateLists::fill(std::size_t i, NearFacets& near, std::int32_t winner, double path, double budget)
{
  List& list = _lists[i];
  list.size = std::min(near.size(), max_facets);
  std::sort(near.begin(), near.begin() + list.size,
            [](const NearFacets::Facet& a, const NearFacets::Facet& b) { return a.facet < b.facet; });
  for (int k = 0; k < list.size; ++k)
  {
    Entry& entry = _entries[i].facets[k];
    entry.facet = near.begin()[k].facet;
    set_distance(entry, near.begin()[k].distance, path);
  }
  list.complete = near.complete() + path;
  list.expiry = path + budget;
  set_winner(i, winner);
}
} // namespace dolfinx_impact::search
