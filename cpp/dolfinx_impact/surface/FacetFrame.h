// SPDX-License-Identifier: MIT
#pragma once
#include "normals.h"
#include <cmath>

namespace dolfinx_impact::surface
{
/// Axes that turn with a facet: the tangents at its centre and its unit normal there (in the plane the tangent and the
/// normal, the tangent turned clockwise). A vector with fixed components in these axes turns with the facet whatever
/// the angle (docs/contact.md, "Smooth surfaces").
template <int gdim>
struct FacetFrame
{
  static_assert(gdim == 2 || gdim == 3);
  double axes[gdim][3] = {}; ///< components beyond gdim are zero

  /// @param[in] num corners of the facet
  /// @param[in] dphi derivatives of their shape functions at the centre, dphi[alpha*num + j]
  /// @param[in] at at(j, c): position of corner j
  void set(int num, const double* dphi, auto&& at)
  {
    for (int a = 0; a < gdim - 1; ++a)
      for (int c = 0; c < gdim; ++c)
      {
        axes[a][c] = 0.0;
        for (int j = 0; j < num; ++j)
          axes[a][c] += dphi[a * num + j] * at(j, c);
      }
    double* n = axes[gdim - 1];
    normal_vector(gdim, axes, n);
    const double length = std::sqrt(dolfinx_impact::dot(n, n, gdim));
    for (int c = 0; c < gdim; ++c)
      n[c] /= length;
  }

  /// Vector from its components.
  void vector(const double* components, double* out) const
  {
    for (int c = 0; c < gdim; ++c)
    {
      out[c] = 0.0;
      for (int k = 0; k < gdim; ++k)
        out[c] += components[k] * axes[k][c];
    }
  }

  /// Components of a vector.
  void components(const double* vector, double* out) const
  {
    const double along = inner(vector, axes[0]), first = inner(axes[0], axes[0]);
    out[gdim - 1] = inner(vector, axes[gdim - 1]);
    if constexpr (gdim == 2)
      out[0] = along / first;
    else
    {
      const double across = inner(vector, axes[1]), second = inner(axes[1], axes[1]), mixed = inner(axes[0], axes[1]);
      const double determinant = first * second - mixed * mixed;
      out[0] = (along * second - across * mixed) / determinant;
      out[1] = (across * first - along * mixed) / determinant;
    }
  }

private:
  static double inner(const double* a, const double* b) { return dolfinx_impact::dot(a, b, gdim); }
};
} // namespace dolfinx_impact::surface
