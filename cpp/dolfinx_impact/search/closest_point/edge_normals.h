// SPDX-License-Identifier: MIT
#pragma once
#include "../../common/vectors.h"
#include "../../surface/Facets.h"
#include "VertexRing.h"
#include "facet_projection.h"
#include <algorithm>

namespace dolfinx_impact::search
{
/// Position of a node among the corners of a facet, or -1.
inline int corner(const surface::Facets& facets, std::size_t f, std::int32_t node)
{
  for (int i = 0; i < facets.displacement.num_corners(); ++i)
    if (facets.nodes_of(f)[i] == node)
      return i;
  return -1;
}

/// Whether d, from a surface's rim to a point, leads beside the surface. Else the point is right over or under the rim;
/// or it is less than a twentieth of the facet deep and under the rim to within 5 degrees of the normal, as the nodes
/// of a plane of symmetry are when the last facet is tilted against it. `mean` need not be of length one.
inline bool beside(int gdim, const double* d, const double* mean, double size)
{
  constexpr double tangent = 0.08748866, deepest = 0.05; // of 5 degrees; of the facet
  const double squared = dot(mean, mean, gdim), along = dot(d, mean, gdim);
  const double normal = squared > 0.0 ? along * along / squared : 0.0, round_off = 1e-9 * size;
  const double tilted = normal < deepest * deepest * size * size ? tangent * tangent * normal : 0.0;
  return dot(d, d, gdim) - normal > tilted + round_off * round_off;
}

/// Mean normal of the facets that meet at an edge or vertex, not of length one.
/// @param[in] at closest point on `facet`: an edge or a vertex
/// @param[in] each_near each_near(visit) calls visit(f) for facets, those among them that meet there
/// @param[in] normal_at normal_at(f, xi, n): normal of facet f
/// @returns whether the surface ends there
bool mean_normal(const surface::Facets& m, const FacetProjection& at, std::int32_t facet, auto&& each_near,
                 auto&& normal_at, double* normal)
{
  const surface::FacetElement& element = m.geometry;
  const bool edge = at.status == ProjectionStatus::edge;
  const int* ends = edge ? edge_corners(element.shape, at.entity) : nullptr;
  const std::int32_t* own = m.nodes_of(facet);
  double t = 0.0; // position along the edge
  if (edge)
  {
    const auto a = element.node(ends[0]), b = element.node(ends[1]);
    const int c = a[0] != b[0] ? 0 : 1;
    t = (at.xi[c] - a[c]) / (b[c] - a[c]);
  }
  std::fill_n(normal, 3, 0.0);
  int meeting = 0;
  VertexRing ring;
  each_near(
      [&](std::int32_t f)
      {
        const int i = corner(m, f, own[edge ? ends[0] : at.entity]), j = edge ? corner(m, f, own[ends[1]]) : i;
        if (i < 0 || j < 0)
          return;
        ++meeting;
        const auto a = element.node(i), b = element.node(j);
        const double xi[2] = {(1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1]};
        double n[3];
        normal_at(f, xi, n);
        for (int c = 0; c < m.gdim; ++c)
          normal[c] += n[c];
        if (!edge && element.tdim() == 2)
          for (int e = 0; e < element.num_corners(); ++e)
            if (const int* k = edge_corners(element.shape, e); k[0] == i || k[1] == i)
              ring.add(m.nodes_of(f)[k[0] == i ? k[1] : k[0]]);
      });
  return edge || element.tdim() == 1 ? meeting < 2 : ring.open();
}
} // namespace dolfinx_impact::search
