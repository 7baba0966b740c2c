// SPDX-License-Identifier: MIT
#pragma once
#include <cmath>

namespace dolfinx_impact::surface
{
/// Axes that turn with a facet: the tangents at its centre and its unit normal there (in the plane the tangent and the
/// normal, the tangent turned clockwise). A vector with fixed components in these axes turns with the facet whatever
/// the angle (docs/contact.md, "Smooth surfaces").
struct FacetFrame
{
  int gdim;
  double axes[3][3]; ///< those beyond gdim are not set
  double size;       ///< area (length) of the facet per reference area (length) at the centre

  /// @param[in] num corners of the facet
  /// @param[in] dphi derivatives of their shape functions at the centre, dphi[alpha*num + j]
  /// @param[in] at at(j, c): position of corner j
  void set(int dimension, int num, const double* dphi, auto&& at)
  {
    gdim = dimension;
    for (int a = 0; a < gdim - 1; ++a)
      for (int c = 0; c < gdim; ++c)
      {
        axes[a][c] = 0.0;
        for (int j = 0; j < num; ++j)
          axes[a][c] += dphi[a * num + j] * at(j, c);
      }
    double* n = axes[gdim - 1];
    if (gdim == 2)
    {
      n[0] = axes[0][1];
      n[1] = -axes[0][0];
    }
    else
      cross(axes[0], axes[1], n);
    double squared = 0.0;
    for (int c = 0; c < gdim; ++c)
      squared += n[c] * n[c];
    size = std::sqrt(squared);
    for (int c = 0; c < gdim; ++c)
      n[c] /= size;
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
    if (gdim == 2)
    {
      out[0] = along / first;
      return;
    }
    const double across = inner(vector, axes[1]), second = inner(axes[1], axes[1]), mixed = inner(axes[0], axes[1]);
    const double determinant = first * second - mixed * mixed;
    out[0] = (along * second - across * mixed) / determinant;
    out[1] = (across * first - along * mixed) / determinant;
  }

  /// Change of a vector of fixed components when the facet's corners move.
  /// @param[in] tangents changes of the tangents, [alpha][c]
  void change(const double* components, const double tangents[2][3], double* out) const
  {
    double w[3];
    const double* n = axes[gdim - 1];
    if (gdim == 2)
    {
      w[0] = tangents[0][1];
      w[1] = -tangents[0][0];
    }
    else
    {
      double other[3];
      cross(tangents[0], axes[1], w);
      cross(axes[0], tangents[1], other);
      for (int c = 0; c < 3; ++c)
        w[c] += other[c];
    }
    const double along = inner(w, n);
    for (int c = 0; c < gdim; ++c)
    {
      out[c] = components[gdim - 1] * (w[c] - along * n[c]) / size;
      for (int a = 0; a < gdim - 1; ++a)
        out[c] += components[a] * tangents[a][c];
    }
  }

  /// The transpose of `change`: what a force at the end of the vector is to the tangents.
  /// @param[out] out force times length for each tangent, [alpha][c]
  void transpose(const double* components, const double* force, double out[2][3]) const
  {
    const double* n = axes[gdim - 1];
    const double along = inner(force, n), height = components[gdim - 1];
    double g[3];
    for (int c = 0; c < gdim; ++c)
      g[c] = height * (force[c] - along * n[c]) / size;
    if (gdim == 2)
    {
      out[0][0] = components[0] * force[0] - g[1];
      out[0][1] = components[0] * force[1] + g[0];
      return;
    }
    cross(axes[1], g, out[0]);
    cross(g, axes[0], out[1]);
    for (int a = 0; a < 2; ++a)
      for (int c = 0; c < 3; ++c)
        out[a][c] += components[a] * force[c];
  }

private:
  static void cross(const double* a, const double* b, double* out)
  {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
  }
  double inner(const double* a, const double* b) const
  {
    double sum = 0.0;
    for (int c = 0; c < gdim; ++c)
      sum += a[c] * b[c];
    return sum;
  }
};
} // namespace dolfinx_impact::surface
