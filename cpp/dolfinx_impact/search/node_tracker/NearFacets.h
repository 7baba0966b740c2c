// SPDX-License-Identifier: MIT
#pragma once
#include <array>
#include <cstdint>
#include <limits>

namespace dolfinx_impact::search
{
/// Facets near a node in one configuration, as many as there is room for, with lower bounds on their distances. It
/// knows up to which distance no facet is missing.
class NearFacets
{
public:
  static constexpr int max_facets = 96;
  struct Facet
  {
    std::int32_t facet;
    double distance; ///< lower bound on the distance of the facet [L]
  };

  /// Add a facet; if there is no room, the farthest one is dropped.
  void add(std::int32_t facet, double distance);
  /// Drop facets beyond `complete`, and bring the nearest `most` of the others to the front: `complete()` is then that
  /// of these alone.
  /// @param[in] complete all facets up to this distance have been added [L]
  /// @param[in] room for rounding of distances [L]
  void select(int most, double complete, double room);

  int size() const { return _num; }
  const Facet* begin() const { return _facets.data(); }
  const Facet* end() const { return _facets.data() + _num; }
  Facet* begin() { return _facets.data(); }
  Facet* end() { return _facets.data() + _num; }
  /// After `select`: no facet nearer than this is missing [L].
  double complete() const { return _complete; }

private:
  std::array<Facet, max_facets> _facets;
  int _num = 0;
  double _complete = 0.0, _dropped = std::numeric_limits<double>::infinity();
};
} // namespace dolfinx_impact::search
