// SPDX-License-Identifier: MIT
#pragma once
#include "../common/vectors.h"
#include "Facets.h"

/// The one owner of the sign of normals.
namespace dolfinx_impact::surface
{
/// Normal vector of a facet, not normalised: its tangent turned clockwise in the plane, their product in space.
/// @tparam T double, or a vector of doubles: a facet in each lane
/// @param[in] a tangents. @param[out] n three components
template <typename T>
inline void normal_vector(int gdim, const T (*a)[3], T* n)
{
  if (gdim == 2)
  {
    n[0] = a[0][1];
    n[1] = -a[0][0];
    n[2] = T{};
  }
  else
    dolfinx_impact::cross(a[0], a[1], n);
}

/// A point of a facet with everything that follows from its position.
struct FacetPoint
{
  double x[3];           ///< position [L]
  double tangents[2][3]; ///< dx/dxi_alpha; in the plane only the first
  double normal[3];      ///< unit normal, out of the body
  double jacobian;       ///< length or area per reference length or area
};

/// Position, tangents, normal and Jacobian at a point of a facet.
/// @param[in] f facet. @param[in] xi reference coordinates
/// @param[in] x positions of the facet's geometry nodes: facets.x_of(f) or facets.X_of(f)
FacetPoint evaluate(const Facets& facets, std::size_t f, const double* x, const double* xi);

/// Sign that makes the facet's own normal point out of a body whose cell has this centre.
std::int8_t orientation(const FacetElement& element, int gdim, const double* X, const double* cell_centre);
} // namespace dolfinx_impact::surface
