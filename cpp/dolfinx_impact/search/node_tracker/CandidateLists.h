// SPDX-License-Identifier: MIT
#pragma once
#include "../../common/prefetch.h"
#include "NearFacets.h"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// For each slave node, the facets that can become its nearest one: far from edges this is a single facet. The class
/// owns, for each of these facets, a lower bound on its distance plus the node's path (RelativeMotion::path) when that
/// distance was found, so that bound - path is a lower bound on the distance at any later time; and the path at which
/// the list expires.
class CandidateLists
{
public:
  static constexpr int max_facets = 24; ///< of one list
  struct Entry
  {
    std::int32_t facet = -1;
    float bound = 0.0; ///< lower bound on distance plus path [L]
  };

  CandidateLists() = default;
  explicit CandidateLists(std::size_t num_nodes) : _lists(num_nodes), _entries(num_nodes) {}

  /// Can a facet that is not in the list of node i be the nearest one?
  bool expired(std::size_t i, double path) const { return !(path < _lists[i].expiry); }
  /// Path plus the distance up to which all facets are listed [L].
  double complete(std::size_t i) const { return _lists[i].complete; }
  /// The nearest facet when it was last determined, or -1.
  std::int32_t winner(std::size_t i) const { return _lists[i].winner; }
  /// Lower bound on distance plus path of all facets but the winner, listed or not [L].
  double others(std::size_t i) const { return _lists[i].others; }
  /// Listed facets, ascending.
  std::span<Entry> entries(std::size_t i) { return {_entries[i].facets, std::size_t(_lists[i].size)}; }
  std::span<const Entry> entries(std::size_t i) const { return {_entries[i].facets, std::size_t(_lists[i].size)}; }

  /// All lists are empty and expired.
  void clear() { std::fill(_lists.begin(), _lists.end(), List{}); }
  /// List the nearest facets.
  /// @param[in] near facets at the present path, after NearFacets::select(max_facets, ...); they are sorted
  /// @param[in] winner the nearest one, or -1
  /// @param[in] path of the node now [L]
  /// @param[in] budget path from now on for which the list is good [L]
  void fill(std::size_t i, NearFacets& near, std::int32_t winner, double path, double budget);
  /// The distance of a listed facet has been found at this path, or a lower bound on it [L].
  static void set_distance(Entry& entry, double distance, double path) { entry.bound = below(distance + path); }
  /// A facet is the nearest one; all distances that could tell otherwise have been found.
  void set_winner(std::size_t i, std::int32_t facet)
  {
    List& list = _lists[i];
    list.winner = facet;
    // Without branches, and not in memory, where each entry would wait for the last one's store.
    float nearest = std::numeric_limits<float>::infinity();
    for (const Entry& entry : entries(i))
      nearest = std::min(nearest, entry.facet == facet ? std::numeric_limits<float>::infinity() : entry.bound);
    list.others = std::min(list.complete, double(nearest));
  }
  /// Ask the memory for the entries of node i.
  void prefetch(std::size_t i) const
  {
    constexpr int line = 64 / sizeof(Entry);
    for (int k = 0; k < _lists[i].size; k += line)
      common::prefetch(_entries[i].facets + k);
  }

private:
  /// What every step reads; the entries are apart from it.
  struct List
  {
    double expiry = -std::numeric_limits<double>::infinity();
    double complete = -std::numeric_limits<double>::infinity();
    double others = 0.0;
    std::int32_t size = 0, winner = -1;
  };
  struct alignas(64) Entries
  {
    Entry facets[max_facets];
  };
  /// A number no greater than x.
  static float below(double x)
  {
    const float near = float(x);
    return near > x ? std::nextafter(near, -std::numeric_limits<float>::infinity()) : near;
  }

  std::vector<List> _lists;
  std::vector<Entries> _entries;
};
} // namespace dolfinx_impact::search
