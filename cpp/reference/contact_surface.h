// SPDX-License-Identifier: MIT
#pragma once
#include "Dual.h"
#include "Model.h"
#include <numbers>

/// Surfaces made of facets of a model, on a scalar type T. In the plane a facet is an interval and its second tangent
/// is e_z, so that area vectors, normals and projections are those of space.
namespace impact_reference
{
constexpr int max_facet_nodes = 9;

struct Facet
{
  std::int64_t cell;
  std::vector<std::int64_t> nodes;    ///< field nodes, in the order of the facet's own element
  std::vector<std::int64_t> vertices; ///< geometry nodes
  Matrix X;                           ///< geometry nodes (num_geometry_nodes, gdim) [L]
  /// Of a smooth facet, by geometry node: what it has beyond the flat facet, along the `axes` at rest.
  std::vector<Eigen::Vector3d> beyond = {};
};

struct Surface
{
  CellType type; ///< of the facets
  int degree, geometry_degree, gdim;
  bool axisymmetric;
  std::vector<Facet> facets;
  bool smooth = false; ///< curved facets (`smooth`) that turn with their corners

  int tdim() const { return gdim - 1; }
  int num_nodes() const { return int(node_vertices(type, degree).size()); }
  int num_vertices() const { return impact_reference::num_vertices(type); }
  bool affine() const { return type != CellType::quadrilateral and degree == 1 and geometry_degree == 1; }
};

/// @param facets geometry nodes, one facet per row; vertices suffice
/// @throws std::invalid_argument if there is none, one is repeated, inside the body or belongs to no cell
Surface surface(const Model& model, const Cells& facets, const std::string& name);

/// Curve the facets of degree 1 of a surface through their vertices (docs/contact.md, "Smooth surfaces"): every edge is
/// a parabola as high as the arc of a circle whose slopes at the ends are the mean of what the normals there ask for.
/// @param facets as in `surface`; normals out of the body at their nodes, a row per node, facet after facet; not a
/// number: that of the flat facet
/// @throws std::invalid_argument for facets of degree 2, facets with more nodes than vertices, other numbers of normals
void smooth(Surface& s, const Cells& facets, const Matrix& normals);

using Local = std::array<double, 2>;
/// Reference coordinates of a facet's centre and vertices.
Local facet_centre(CellType type);
Local facet_vertex(CellType type, int vertex);

/// Displacements of a facet's nodes [L].
std::vector<Vec<double>> gather(const Surface& surface, const Facet& facet, const Vector& u);

/// The same with derivatives: variable first + gdim * node + component is a component of a node's displacement.
template <int N>
std::vector<Vec<Dual<N>>> seeded(const Surface& surface, const Facet& facet, const Vector& u, int first)
{
  const auto values = gather(surface, facet, u);
  std::vector<Vec<Dual<N>>> result(values.size());
  for (std::size_t k = 0; k < values.size(); ++k)
    for (int c = 0; c < surface.gdim; ++c)
      result[k][c] = Dual<N>::variable(values[k][c], first + surface.gdim * int(k) + c);
  return result;
}

namespace detail
{
// One-dimensional Lagrange polynomial of the node at s = -1, 0, 1 and its derivative.
template <typename T>
std::array<T, 2> line_polynomial(int degree, double s, const T& x)
{
  if (degree == 1)
    return {0.5 * (1.0 + s * x), T(0.5 * s)};
  if (s == 0)
    return {1.0 - x * x, -2.0 * x};
  return {0.5 * x * (x + s), x + 0.5 * s};
}
} // namespace detail

/// Lagrange functions of a facet at a point and their derivatives; order of node_vertices.
template <typename T>
struct FacetFunctions
{
  std::array<T, max_facet_nodes> N;
  std::array<std::array<T, max_facet_nodes>, 2> dN;
};

template <typename T>
FacetFunctions<T> facet_functions(CellType type, int degree, const std::array<T, 2>& xi)
{
  FacetFunctions<T> f;
  const auto& nodes = node_vertices(type, degree);
  if (type == CellType::triangle)
  {
    const std::array<T, 3> L{1.0 - xi[0] - xi[1], xi[0], xi[1]};
    constexpr double dL[3][2]{{-1, -1}, {1, 0}, {0, 1}};
    for (std::size_t i = 0; i < nodes.size(); ++i)
    {
      const int a = nodes[i][0], b = nodes[i].back();
      const bool corner = a == b;
      f.N[i] = degree == 1 ? L[a] : corner ? L[a] * (2.0 * L[a] - 1.0) : 4.0 * L[a] * L[b];
      for (int k = 0; k < 2; ++k)
        f.dN[k][i] = degree == 1 ? T(dL[a][k])
                     : corner    ? (4.0 * L[a] - 1.0) * dL[a][k]
                                 : 4.0 * (L[a] * dL[b][k] + L[b] * dL[a][k]);
    }
    return f;
  }
  const bool line = type == CellType::interval;
  for (std::size_t i = 0; i < nodes.size(); ++i)
  {
    Local s{0, 0};
    for (int v : nodes[i])
      for (int k = 0; k < (line ? 1 : 2); ++k)
        s[k] += facet_vertex(type, v)[k] / double(nodes[i].size());
    const auto p = detail::line_polynomial(degree, s[0], xi[0]);
    if (line)
    {
      f.N[i] = p[0];
      f.dN[0][i] = p[1];
      continue;
    }
    const auto q = detail::line_polynomial(degree, s[1], xi[1]);
    f.N[i] = p[0] * q[0];
    f.dN[0][i] = p[1] * q[0];
    f.dN[1][i] = p[0] * q[1];
  }
  return f;
}

/// A point of a facet in the current configuration.
template <typename T>
struct Spot
{
  FacetFunctions<T> f;     ///< of the displacement
  Vec<T> x;                ///< position [L]
  std::array<Vec<T>, 2> a; ///< tangents; the second is e_z in the plane [L]

  Vec<T> area() const { return cross(a[0], a[1]); }
  Vec<T> normal() const { return unit(area()); } ///< out of the facet's own body
};

/// Reference position and tangents.
template <typename T>
Spot<T> reference_spot(const Surface& s, const Facet& facet, const std::array<T, 2>& xi)
{
  const auto g = facet_functions(s.type, s.geometry_degree, xi);
  Spot<T> spot;
  for (int i = 0; i < facet.X.rows(); ++i)
    for (int c = 0; c < s.gdim; ++c)
    {
      spot.x[c] += facet.X(i, c) * g.N[i];
      for (int k = 0; k < s.tdim(); ++k)
        spot.a[k][c] += facet.X(i, c) * g.dN[k][i];
    }
  if (s.gdim == 2)
    spot.a[1][2] = T(1);
  return spot;
}

/// Reference area per area of the reference facet, with 2 pi R if axisymmetric.
template <typename T>
T reference_area(const Surface& s, const Facet& facet, const std::array<T, 2>& xi)
{
  const Spot<T> spot = reference_spot(s, facet, xi);
  const T area = norm(spot.area());
  return s.axisymmetric ? 2 * std::numbers::pi * spot.x[0] * area : area;
}

/// Tangents and unit normal at the centre of the flat facet between vertices at y.
template <typename T>
std::array<Vec<T>, 3> axes(const Surface& s, const std::vector<Vec<T>>& y)
{
  const Local centre = facet_centre(s.type);
  const auto f = facet_functions<double>(s.type, 1, centre);
  std::array<Vec<T>, 3> result;
  for (std::size_t j = 0; j < y.size(); ++j)
    for (int k = 0; k < s.tdim(); ++k)
      result[k] = result[k] + f.dN[k][j] * y[j];
  if (s.gdim == 2)
    result[1][2] = T(1);
  result[2] = unit(cross(result[0], result[1]));
  return result;
}

/// Point of a smooth facet: what it has beyond the flat facet keeps its components along the `axes`.
template <typename T>
Spot<T> smooth_spot(const Surface& s, const Facet& facet, const std::vector<Vec<T>>& u, const std::array<T, 2>& xi)
{
  const int n = s.num_vertices();
  std::vector<Vec<T>> y(n);
  for (int j = 0; j < n; ++j)
    for (int c = 0; c < s.gdim; ++c)
      y[j][c] = facet.X(j, c) + u[j][c];
  Spot<T> result;
  result.f = facet_functions(s.type, 1, xi);
  for (int j = 0; j < n; ++j)
  {
    result.x = result.x + result.f.N[j] * y[j];
    for (int k = 0; k < s.tdim(); ++k)
      result.a[k] = result.a[k] + result.f.dN[k][j] * y[j];
  }
  const auto frame = axes(s, y);
  const auto curved = facet_functions(s.type, 2, xi);
  for (std::size_t i = n; i < facet.beyond.size(); ++i)
  {
    Vec<T> d;
    for (int k = 0; k < 3; ++k)
      d = d + facet.beyond[i](k) * frame[k];
    if (s.gdim == 2)
      d[2] = T(0);
    result.x = result.x + curved.N[i] * d;
    for (int k = 0; k < s.tdim(); ++k)
      result.a[k] = result.a[k] + curved.dN[k][i] * d;
  }
  if (s.gdim == 2)
    result.a[1][2] = T(1);
  return result;
}

/// Current position, x = X + u.
template <typename T>
Spot<T> spot(const Surface& s, const Facet& facet, const std::vector<Vec<T>>& u, const std::array<T, 2>& xi)
{
  if (s.smooth)
    return smooth_spot(s, facet, u, xi);
  Spot<T> result = reference_spot(s, facet, xi);
  result.f = facet_functions(s.type, s.degree, xi);
  for (std::size_t i = 0; i < u.size(); ++i)
    for (int c = 0; c < s.gdim; ++c)
    {
      result.x[c] += result.f.N[i] * u[i][c];
      for (int k = 0; k < s.tdim(); ++k)
        result.a[k][c] += result.f.dN[k][i] * u[i][c];
    }
  return result;
}

/// Number of variables of a slave and a master facet, as a constant: f(std::integral_constant<int, N>).
template <typename F>
auto with_variables(const Surface& s, F&& f)
{
  switch (2 * s.gdim * s.num_nodes())
  {
  case 8:
    return f(std::integral_constant<int, 8>{});
  case 12:
    return f(std::integral_constant<int, 12>{});
  case 18:
    return f(std::integral_constant<int, 18>{});
  case 24:
    return f(std::integral_constant<int, 24>{});
  case 36:
    return f(std::integral_constant<int, 36>{});
  default:
    return f(std::integral_constant<int, 54>{});
  }
}
} // namespace impact_reference
