// SPDX-License-Identifier: MIT
#include "nearest_facet.h"
#include "../../common/vectors.h"
#include <algorithm>
#include <array>

namespace dolfinx_impact::search
{
Projection nearest_facet(const TrackedSurface& surface, const NodeQuery& query, int most, NearFacets& near,
                         double& distance)
{
  const surface::Facets& facets = surface.facets();
  const int gdim = facets.gdim;
  const double room = 1e-9 * surface.largest_diameter(), *x = query.x;
  double there[3] = {}, nodes[3 * surface::FacetElement::max_nodes], normal[3], best_normal[3];
  for (int c = 0; c < gdim; ++c)
    there[c] = x[c] - query.shift[c];
  std::int32_t nearest = -1;
  FacetProjection best;
  // So far the list has to be complete.
  const auto farthest = [&]
  {
    return nearest < 0 ? query.range.radius() + 2 * list_path * surface.largest_diameter()
                       : best.distance + 2 * list_path * surface.diameter(nearest);
  };
  const auto visit = [&](std::int32_t f)
  {
    // Most facets are farther than the best one even by the distance of their box; the list takes that distance, too.
    double bound = nearest >= 0 && query.configuration.stored ? surface.box_distance(f, x) : 0.0;
    if (nearest < 0 || bound <= best.distance + room)
    {
      surface.positions(f, query.configuration, nodes);
      const FacetProjection at = surface.project(f, nodes, x, f == query.tracked_facet ? query.tracked_xi : nullptr);
      bound = at.distance;
      if (query.range.contains(surface, f, at) &&
          (nearest < 0 || closer(at, facets.id[f], best, facets.id[nearest], surface.diameter(nearest))))
      {
        surface.normal(f, nodes, at.xi, normal);
        if (dot(normal, query.normal, gdim) < -right_angle)
        {
          best = at;
          nearest = f;
          std::copy_n(normal, 3, best_normal);
        }
      }
    }
    near.add(f, bound);
    const double limit = farthest();
    return (limit + query.slack) * (limit + query.slack);
  };
  const double first = farthest() + query.slack;
  surface.nearest(there, first * first, visit);
  near.select(most, farthest(), room);
  distance = best.distance;
  if (nearest < 0)
    return {};
  std::array<std::int32_t, NearFacets::max_facets> around;
  std::transform(near.begin(), near.end(), around.begin(), [](const NearFacets::Facet& f) { return f.facet; });
  return surface.closest_point(x, nearest, best_normal, best, query.configuration,
                               {around.data(), std::size_t(near.size())});
}
} // namespace dolfinx_impact::search
