// SPDX-License-Identifier: MIT
#pragma once
#include "../../common/columns.h"
#include "../../surface/normals.h"
#include "facet_projection.h"
#include <algorithm>
#include <cmath>
#include <type_traits>

/// Closest points on facets of degree 1, inlined: what node-to-surface contact does for every node near the master in
/// every step. The results are those of project_on_facet. X[i][c] are the positions of a facet's nodes.
namespace dolfinx_impact::search::linear
{
using surface::FacetShape;

/// Number of nodes and dimension of space.
template <FacetShape S>
constexpr int num_nodes = S == FacetShape::interval   ? 2
                          : S == FacetShape::triangle ? 3
                                                      : 4;
template <FacetShape S>
constexpr int dimension = S == FacetShape::interval ? 2 : 3;

constexpr double margin = 1e-9; ///< in reference coordinates: what is outside by less is inside

/// Shape functions.
template <FacetShape S>
inline void values(const double* xi, double* phi)
{
  if constexpr (S == FacetShape::interval)
  {
    phi[0] = 1 - xi[0];
    phi[1] = xi[0];
  }
  else if constexpr (S == FacetShape::triangle)
  {
    phi[0] = 1 - xi[0] - xi[1];
    phi[1] = xi[0];
    phi[2] = xi[1];
  }
  else
  {
    phi[0] = (1 - xi[0]) * (1 - xi[1]);
    phi[1] = xi[0] * (1 - xi[1]);
    phi[2] = (1 - xi[0]) * xi[1];
    phi[3] = xi[0] * xi[1];
  }
}

/// Tangents at a point.
/// @tparam T double, or a vector of doubles: a facet in each lane
template <FacetShape S, typename Nodes, typename T>
inline void tangents(const Nodes& X, const T* xi, T a[2][3])
{
  constexpr int D = dimension<S>;
  for (int c = 0; c < D; ++c)
  {
    a[0][c] = X[1][c] - X[0][c];
    if constexpr (S == FacetShape::triangle)
      a[1][c] = X[2][c] - X[0][c];
    if constexpr (S == FacetShape::quadrilateral)
    {
      const T twist = X[3][c] - X[2][c] - X[1][c] + X[0][c];
      a[1][c] = X[2][c] - X[0][c] + xi[0] * twist;
      a[0][c] += xi[1] * twist;
    }
  }
}

/// Unit normal, out of the body.
template <FacetShape S, typename Nodes, typename T>
inline void normal(const Nodes& X, const T* xi, const std::type_identity_t<T>& orientation, T* n)
{
  T a[2][3];
  tangents<S>(X, xi, a);
  surface::normal_vector(dimension<S>, a, n);
  T size = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  common::take_root(size);
  const T factor = orientation / size;
  for (int c = 0; c < 3; ++c)
    n[c] *= factor;
}

/// Where the distance is stationary on the plane of a triangle or the line of an interval.
template <FacetShape S, typename Nodes>
inline void flat_foot(const Nodes& X, const double* point, double* xi)
{
  constexpr int D = dimension<S>;
  double a[2][3], aa = 0, bb = 0, ab = 0, ra = 0, rb = 0;
  tangents<S>(X, xi, a);
  for (int c = 0; c < D; ++c)
  {
    const double r = point[c] - X[0][c];
    aa += a[0][c] * a[0][c];
    ra += r * a[0][c];
    if constexpr (S == FacetShape::triangle)
    {
      bb += a[1][c] * a[1][c];
      ab += a[0][c] * a[1][c];
      rb += r * a[1][c];
    }
  }
  if constexpr (S == FacetShape::interval)
  {
    xi[0] = ra / aa;
    xi[1] = 0.0;
  }
  else
  {
    const double det = aa * bb - ab * ab;
    xi[0] = (bb * ra - ab * rb) / det;
    xi[1] = (aa * rb - ab * ra) / det;
  }
}

/// A step of Newton's method on a quadrilateral; answers as numbers, so that several lanes can be computed at once.
struct Step
{
  double xi[2]; ///< the step
  double fine;  ///< 1: there is a minimum nearby
  double done;  ///< 1: it is found
};

/// One step of Newton's method for the stationary distance on a quadrilateral, from xi.
template <typename Nodes>
inline Step newton_step(const Nodes& X, const double* point, const double* xi)
{
  double g1 = 0, g2 = 0, h11 = 0, h22 = 0, h12 = 0, m12 = 0, twist_squared = 0;
  for (int c = 0; c < 3; ++c)
  {
    const double e1 = X[1][c] - X[0][c], e2 = X[2][c] - X[0][c], twist = X[3][c] - X[2][c] - e1;
    const double a1 = e1 + xi[1] * twist, a2 = e2 + xi[0] * twist;
    const double rc = point[c] - X[0][c] - xi[0] * a1 - xi[1] * e2;
    g1 += rc * a1;
    g2 += rc * a2;
    h11 += a1 * a1;
    h22 += a2 * a2;
    m12 += a1 * a2;
    h12 -= rc * twist;
    twist_squared += twist * twist;
  }
  h12 += m12;
  const double det = h11 * h22 - h12 * h12;
  const double per_det = 1.0 / det, s1 = (h22 * g1 - h12 * g2) * per_det, s2 = (h11 * g2 - h12 * g1) * per_det;
  // What is left is the square of the step, times how much the facet is twisted.
  const double far1 = std::abs(s1), far2 = std::abs(s2), size = far1 < far2 ? far2 : far1, squared = size * size;
  const double done = 16 * twist_squared * squared * squared < 1e-32 * (h22 < h11 ? h22 : h11) ? 1.0 : 0.0;
  const double near1 = std::abs(xi[0] + s1 - 0.5) < 20.0 ? 1.0 : done;
  const double near2 = std::abs(xi[1] + s2 - 0.5) < 20.0 ? 1.0 : done;
  return {{s1, s2}, det > 1e-3 * h11 * h22 ? near1 * near2 : 0.0, done};
}
constexpr int most_steps = 12; ///< of Newton's method

/// Where the distance is stationary on the facet continued beyond its edges.
/// @param[in,out] xi from where to where
/// @returns false if Newton's method finds no minimum near the facet
template <FacetShape S, typename Nodes>
inline bool foot(const Nodes& X, const double* point, double* xi)
{
  if constexpr (S != FacetShape::quadrilateral)
  {
    flat_foot<S>(X, point, xi);
    return true;
  }
  else
    for (int iteration = 0; iteration < most_steps; ++iteration)
    {
      const Step step = newton_step(X, point, xi);
      if (step.fine == 0.0)
        return false;
      xi[0] += step.xi[0];
      xi[1] += step.xi[1];
      if (step.done > 0.0)
        return true;
    }
  return false;
}

/// Is a foot inside the facet?
template <FacetShape S>
inline bool inside(const double* xi)
{
  bool in = xi[0] >= -margin;
  if constexpr (S == FacetShape::interval)
    in &= xi[0] <= 1 + margin;
  else if constexpr (S == FacetShape::triangle)
    in &= (xi[1] >= -margin) & (xi[0] + xi[1] <= 1 + margin);
  else
    in &= (xi[1] >= -margin) & (xi[0] <= 1 + margin) & (xi[1] <= 1 + margin);
  return in;
}

/// Position of a place on the facet. @returns the square of its distance from the point
template <FacetShape S, typename Nodes>
inline double place(const Nodes& X, const double* point, const double* xi, double* x)
{
  double phi[4], squared = 0.0;
  values<S>(xi, phi);
  for (int c = 0; c < dimension<S>; ++c)
  {
    double sum = 0.0;
    for (int i = 0; i < num_nodes<S>; ++i)
      sum += phi[i] * X[i][c];
    x[c] = sum;
    squared += (point[c] - sum) * (point[c] - sum);
  }
  return squared;
}

/// The nearest point of the facet's edges and vertices. It lies on an edge beyond which the foot is.
/// @param[in] foot reference coordinates, outside the facet
template <FacetShape S>
inline void boundary(const double* const* X, const double* point, const double* foot, FacetProjection& out)
{
  constexpr int D = dimension<S>, edges = S == FacetShape::interval ? 1 : num_nodes<S>;
  constexpr int corners[3][4][2] = {
      {{0, 1}}, {{1, 2}, {0, 2}, {0, 1}}, {{0, 1}, {0, 2}, {1, 3}, {2, 3}}}; // as edge_corners
  constexpr double places[4][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  const double x = foot[0], y = foot[1];
  const bool quadrilateral[4] = {y < 0, x < 0, x > 1, y > 1}, triangle[4] = {x + y > 1, x < 0, y < 0, false};
  double best = 0.0, xi[2] = {};
  bool any = false;
  for (int e = 0; e < edges; ++e)
  {
    if (!(S == FacetShape::interval || (S == FacetShape::triangle ? triangle[e] : quadrilateral[e])))
      continue;
    const int i = corners[int(S)][e][0], j = corners[int(S)][e][1];
    double d[3], b[3], bb = 0.0, db = 0.0, squared = 0.0;
    for (int c = 0; c < D; ++c)
    {
      b[c] = X[j][c] - X[i][c];
      d[c] = point[c] - X[i][c];
      bb += b[c] * b[c];
      db += d[c] * b[c];
    }
    const double t = db <= 0.0 ? 0.0 : db >= bb ? 1.0 : db / bb;
    for (int c = 0; c < D; ++c)
      squared += (d[c] - t * b[c]) * (d[c] - t * b[c]);
    if (any && !(squared < best))
      continue;
    any = true;
    best = squared;
    const bool vertex = t == 0.0 || t == 1.0;
    out.status = vertex ? ProjectionStatus::vertex : ProjectionStatus::edge;
    out.entity = std::int8_t(vertex ? (t == 0.0 ? i : j) : e);
    for (int a = 0; a < 2; ++a)
      xi[a] = (1 - t) * places[i][a] + t * places[j][a];
    for (int c = 0; c < D; ++c)
      out.x[c] = X[i][c] + t * b[c];
  }
  out.xi[0] = xi[0];
  out.xi[1] = xi[1];
  out.distance = std::sqrt(best);
}

/// Square of the distance from the box around a facet: never more than that from the facet.
template <FacetShape S>
inline double box_distance(const double* const* X, const double* point)
{
  double squared = 0.0;
  for (int c = 0; c < dimension<S>; ++c)
  {
    double low = X[0][c], high = X[0][c];
    for (int i = 1; i < num_nodes<S>; ++i)
    {
      low = std::min(low, X[i][c]);
      high = std::max(high, X[i][c]);
    }
    const double d = std::max(std::max(low - point[c], point[c] - high), 0.0);
    squared += d * d;
  }
  return squared;
}

/// Closest point of a facet.
/// @param[in] start reference coordinates near it, or null
/// @returns false if this is a case for project_on_facet
template <FacetShape S>
inline bool project(const double* const* X, const double* point, const double* start, FacetProjection& out)
{
  out.xi[0] = start ? start[0] : S == FacetShape::triangle ? 1.0 / 3 : 0.5;
  out.xi[1] = start ? start[1] : S == FacetShape::interval ? 0.0 : S == FacetShape::triangle ? 1.0 / 3 : 0.5;
  if (!linear::foot<S>(X, point, out.xi))
    return false;
  if (!inside<S>(out.xi))
  {
    const double foot[2] = {out.xi[0], out.xi[1]};
    boundary<S>(X, point, foot, out);
    return true;
  }
  out.distance = std::sqrt(place<S>(X, point, out.xi, out.x));
  out.status = ProjectionStatus::converged;
  out.entity = -1;
  return true;
}
} // namespace dolfinx_impact::search::linear
