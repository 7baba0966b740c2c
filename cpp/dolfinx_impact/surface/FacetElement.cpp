// SPDX-License-Identifier: MIT
#include "FacetElement.h"

namespace dolfinx_impact::surface
{
namespace
{
/// One-dimensional functions (vertices 0 and 1, midpoint), or their derivatives of order 1 or 2.
void line(int degree, double x, int order, double f[3])
{
  if (degree == 1)
  {
    f[0] = order == 0 ? 1 - x : order == 1 ? -1.0 : 0.0;
    f[1] = order == 0 ? x : order == 1 ? 1.0 : 0.0;
  }
  else if (order == 0)
  {
    f[0] = (1 - x) * (1 - 2 * x);
    f[1] = x * (2 * x - 1);
    f[2] = 4 * x * (1 - x);
  }
  else
  {
    f[0] = order == 1 ? 4 * x - 3 : 4.0;
    f[1] = order == 1 ? 4 * x - 1 : 4.0;
    f[2] = order == 1 ? 4 - 8 * x : -8.0;
  }
}

/// The same, written to an array of the element's own length.
void interval(int degree, double x, int order, double* out)
{
  double f[3];
  line(degree, x, order, f);
  const int num_nodes = degree == 1 ? 2 : 3;
  for (int i = 0; i < num_nodes; ++i)
    out[i] = f[i];
}

/// Node i of the quadrilateral as a pair of one-dimensional nodes.
constexpr int quad_nodes[9][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {2, 0}, {0, 2}, {1, 2}, {2, 1}, {2, 2}};
constexpr int interval_ends[2] = {0, 1};
constexpr int triangle_edges[3][2] = {{1, 2}, {0, 2}, {0, 1}};
constexpr int quadrilateral_edges[4][2] = {{0, 1}, {0, 2}, {1, 3}, {2, 3}};

/// Tensor product of derivatives of order dx and dy.
void quadrilateral(int degree, int num_nodes, const double* xi, int dx, int dy, double* out)
{
  double fx[3], fy[3];
  line(degree, xi[0], dx, fx);
  line(degree, xi[1], dy, fy);
  for (int i = 0; i < num_nodes; ++i)
    out[i] = fx[quad_nodes[i][0]] * fy[quad_nodes[i][1]];
}

/// Barycentric coordinates of the triangle and their (constant) derivatives.
constexpr double bary[2][3] = {{-1, 1, 0}, {-1, 0, 1}};
} // namespace

std::array<double, 2> FacetElement::node(int i) const
{
  constexpr double position[3] = {0.0, 1.0, 0.5};
  if (shape == FacetShape::interval)
    return {position[i], 0.0};
  if (shape == FacetShape::quadrilateral)
    return {position[quad_nodes[i][0]], position[quad_nodes[i][1]]};
  constexpr std::array<double, 2> vertices[3] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
  if (i < 3)
    return vertices[i];
  const auto& a = vertices[triangle_edges[i - 3][0]];
  const auto& b = vertices[triangle_edges[i - 3][1]];
  return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
}

std::array<double, 2> FacetElement::centre() const
{
  if (shape == FacetShape::interval)
    return {0.5, 0.0};
  if (shape == FacetShape::triangle)
    return {1.0 / 3, 1.0 / 3};
  return {0.5, 0.5};
}

void FacetElement::values(const double* xi, double* phi) const
{
  if (shape == FacetShape::interval)
    interval(degree, xi[0], 0, phi);
  else if (shape == FacetShape::quadrilateral)
    quadrilateral(degree, num_nodes(), xi, 0, 0, phi);
  else
  {
    const double l[3] = {1 - xi[0] - xi[1], xi[0], xi[1]};
    for (int i = 0; i < 3; ++i)
      phi[i] = degree == 1 ? l[i] : l[i] * (2 * l[i] - 1);
    if (degree == 2)
      for (int e = 0; e < 3; ++e)
        phi[3 + e] = 4 * l[triangle_edges[e][0]] * l[triangle_edges[e][1]];
  }
}

void FacetElement::derivatives(const double* xi, double* dphi) const
{
  const int n = num_nodes();
  if (shape == FacetShape::interval)
    interval(degree, xi[0], 1, dphi);
  else if (shape == FacetShape::quadrilateral)
  {
    quadrilateral(degree, n, xi, 1, 0, dphi);
    quadrilateral(degree, n, xi, 0, 1, dphi + n);
  }
  else
  {
    const double l[3] = {1 - xi[0] - xi[1], xi[0], xi[1]};
    for (int a = 0; a < 2; ++a)
    {
      for (int i = 0; i < 3; ++i)
        dphi[a * n + i] = degree == 1 ? bary[a][i] : bary[a][i] * (4 * l[i] - 1);
      if (degree == 2)
        for (int e = 0; e < 3; ++e)
        {
          const int i = triangle_edges[e][0], j = triangle_edges[e][1];
          dphi[a * n + 3 + e] = 4 * (bary[a][i] * l[j] + l[i] * bary[a][j]);
        }
    }
  }
}

void FacetElement::second_derivatives(const double* xi, double* ddphi) const
{
  const int n = num_nodes();
  if (shape == FacetShape::interval)
    interval(degree, xi[0], 2, ddphi);
  else if (shape == FacetShape::quadrilateral)
  {
    quadrilateral(degree, n, xi, 2, 0, ddphi);
    quadrilateral(degree, n, xi, 0, 2, ddphi + n);
    quadrilateral(degree, n, xi, 1, 1, ddphi + 2 * n);
  }
  else
  {
    constexpr int pairs[3][2] = {{0, 0}, {1, 1}, {0, 1}};
    for (int k = 0; k < 3; ++k)
    {
      const int a = pairs[k][0], b = pairs[k][1];
      for (int i = 0; i < 3; ++i)
        ddphi[k * n + i] = degree == 1 ? 0.0 : 4 * bary[a][i] * bary[b][i];
      if (degree == 2)
        for (int e = 0; e < 3; ++e)
        {
          const int i = triangle_edges[e][0], j = triangle_edges[e][1];
          ddphi[k * n + 3 + e] = 4 * (bary[a][i] * bary[b][j] + bary[b][i] * bary[a][j]);
        }
    }
  }
}

bool FacetElement::inside(const double* xi, double margin) const
{
  if (shape == FacetShape::interval)
    return xi[0] >= -margin && xi[0] <= 1 + margin;
  if (xi[0] < -margin || xi[1] < -margin)
    return false;
  if (shape == FacetShape::triangle)
    return xi[0] + xi[1] <= 1 + margin;
  return xi[0] <= 1 + margin && xi[1] <= 1 + margin;
}

const int* edge_corners(FacetShape shape, int edge)
{
  return shape == FacetShape::interval   ? interval_ends
         : shape == FacetShape::triangle ? triangle_edges[edge]
                                         : quadrilateral_edges[edge];
}
} // namespace dolfinx_impact::surface
