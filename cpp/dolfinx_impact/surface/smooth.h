// SPDX-License-Identifier: MIT
#pragma once
#include "Surface.h"
#include <span>

namespace dolfinx_impact::surface
{
/// How a smooth surface is laid through the corners of facets.
struct SmoothOptions
{
  double crease = 0.0; ///< facets that meet at a larger angle keep their edge sharp [rad]
  /// Unit normals out of the body at the corners of this rank's facets, normals[(facet*num_corners + i)*gdim + c]:
  /// where they are not a number, or off the facet by more than `crease`, the normals of the facets are used. Empty:
  /// everywhere.
  std::span<const double> normals;
};

/// Curved facets of degree 2 through the corners of facets of degree 1 (docs/contact.md, "Smooth surfaces"): edges of
/// Nagata's patches (Computer Aided Geometric Design 22, 2005, 327), the symmetric part of their curvature. Collective.
/// Every rank sees the whole surface once, so that the result depends on the ranks by round-off alone.
/// @param[in] V displacement space
/// @param[in] facets made by make_surface(V, ...), of degree 1
/// @returns the same facets with `smooth` set, geometry of degree 2
/// @throws std::invalid_argument on all ranks for facets of degree 2, another number of normals, normals that point
/// into the body, or a crease that is no angle between 0 and pi
Facets make_smooth(const FunctionSpace& V, const Facets& facets, const SmoothOptions& options);

/// The facets of degree 1 between the corners of smooth facets; other facets as they are.
Facets flat(const Facets& facets);
} // namespace dolfinx_impact::surface
