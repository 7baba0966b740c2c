// SPDX-License-Identifier: MIT
#include "facet_projection.h"
#include "curve_projection.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace dolfinx_impact::search
{
namespace
{
using surface::FacetElement;
using surface::FacetShape;

double squared_distance(int gdim, const double* a, const double* b)
{
  double sum = 0.0;
  for (int c = 0; c < gdim; ++c)
    sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

void position(const FacetElement& element, int gdim, const double* nodes, const double* xi, double* x)
{
  double phi[FacetElement::max_nodes];
  element.values(xi, phi);
  std::fill_n(x, gdim, 0.0);
  for (int i = 0; i < element.num_nodes(); ++i)
    for (int c = 0; c < gdim; ++c)
      x[c] += phi[i] * nodes[i * gdim + c];
}

/// Gradient and second derivatives (11, 22, 12) of half the squared distance; without `exact` only their first part.
void derivatives(const FacetElement& element, const double* nodes, const double* xi, const double* r, double* gradient,
                 double* metric, double* hessian)
{
  double dphi[2 * FacetElement::max_nodes], ddphi[3 * FacetElement::max_nodes];
  element.derivatives(xi, dphi);
  element.second_derivatives(xi, ddphi);
  const int n = element.num_nodes();
  double a[2][3] = {}, curvature[3] = {0.0, 0.0, 0.0};
  for (int i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c)
    {
      const double x = nodes[3 * i + c];
      a[0][c] += dphi[i] * x;
      a[1][c] += dphi[n + i] * x;
      for (int k = 0; k < 3; ++k)
        curvature[k] += ddphi[k * n + i] * x * r[c];
    }
  std::fill_n(gradient, 2, 0.0);
  std::fill_n(metric, 3, 0.0);
  for (int c = 0; c < 3; ++c)
  {
    gradient[0] -= r[c] * a[0][c];
    gradient[1] -= r[c] * a[1][c];
    metric[0] += a[0][c] * a[0][c];
    metric[1] += a[1][c] * a[1][c];
    metric[2] += a[0][c] * a[1][c];
  }
  for (int k = 0; k < 3; ++k)
    hessian[k] = metric[k] - curvature[k];
}

/// Newton's method with backtracking for a stationary point of the distance, from xi; facets of dimension 2.
/// @returns false when it leaves the facet's surroundings or does not converge
bool newton(const FacetElement& element, const double* nodes, const double* point, double* xi)
{
  double x[3], r[3];
  position(element, 3, nodes, xi, x);
  double value = 0.5 * squared_distance(3, x, point);
  for (int iteration = 0; iteration < 60; ++iteration)
  {
    double g[2], metric[3], h[3];
    for (int c = 0; c < 3; ++c)
      r[c] = point[c] - x[c];
    derivatives(element, nodes, xi, r, g, metric, h);
    if (!(h[0] > 0.0 && h[0] * h[1] - h[2] * h[2] > 1e-6 * metric[0] * metric[1]))
      std::copy_n(metric, 3, h); // not near a minimum: the metric descends
    const double det = h[0] * h[1] - h[2] * h[2];
    double step[2] = {-(h[1] * g[0] - h[2] * g[1]) / det, -(h[0] * g[1] - h[2] * g[0]) / det};
    const double size = std::max(std::abs(step[0]), std::abs(step[1]));
    if (!std::isfinite(size))
      return false;
    double factor = std::min(1.0, 0.5 / size);
    const double slope = g[0] * step[0] + g[1] * step[1];
    double trial[2], trial_value = value;
    for (int halving = 0; halving < 30; ++halving, factor *= 0.5)
    {
      for (int a = 0; a < 2; ++a)
        trial[a] = xi[a] + factor * step[a];
      position(element, 3, nodes, trial, x);
      trial_value = 0.5 * squared_distance(3, x, point);
      // Close to the minimum the decrease drowns in rounding.
      if (trial_value <= value + 1e-4 * factor * slope || size < 1e-6)
        break;
    }
    std::copy_n(trial, 2, xi);
    value = trial_value;
    if (size < 1e-13)
      return true;
    if (!element.inside(xi, 1.0))
      return false;
  }
  return false;
}

void compare(FacetProjection& best, ProjectionStatus status, int entity, const double* xi, const double* x,
             double distance, double size)
{
  // What comes first stays unless it is clearly farther: the interior before edges, edges before vertices.
  if (best.status != ProjectionStatus::outside && distance >= best.distance - 1e-13 * (best.distance + size))
    return;
  best.status = status;
  best.entity = std::int8_t(entity);
  std::copy_n(xi, 2, best.xi);
  std::copy_n(x, 3, best.x);
  best.distance = distance;
}

void try_interior(const FacetElement& element, const double* nodes, const double* point, const double* start,
                  double margin, FacetProjection& best)
{
  double xi[2] = {start[0], start[1]}, x[3];
  if (!newton(element, nodes, point, xi) || !element.inside(xi, margin))
    return;
  position(element, 3, nodes, xi, x);
  compare(best, ProjectionStatus::converged, -1, xi, x, std::sqrt(squared_distance(3, x, point)),
          std::sqrt(squared_distance(3, nodes, nodes + 3)));
}

/// Newton's method from nodes and centre, or some of them.
void try_inside(const FacetElement& element, const double* nodes, const double* point, Starts starts, double margin,
                FacetProjection& best)
{
  const int n = element.num_nodes();
  std::array<double, 2> at[FacetElement::max_nodes + 1];
  double squared[FacetElement::max_nodes + 1], x[3];
  for (int i = 0; i < n; ++i)
  {
    at[i] = element.node(i);
    squared[i] = squared_distance(3, nodes + 3 * i, point);
  }
  at[n] = element.centre();
  position(element, 3, nodes, at[n].data(), x);
  squared[n] = squared_distance(3, x, point);
  const int nearest = int(std::min_element(squared, squared + n + 1) - squared);
  if (starts == Starts::nearest)
    return try_interior(element, nodes, point, at[nearest].data(), margin, best);
  for (int i = 0; i <= n; ++i)
  {
    bool lowest = true;
    for (int j = 0; j <= n && lowest; ++j)
      lowest = starts == Starts::all || squared[i] <= squared[j] ||
               std::hypot(at[i][0] - at[j][0], at[i][1] - at[j][1]) > 0.75;
    if (lowest)
      try_interior(element, nodes, point, at[i].data(), margin, best);
  }
}

void try_edge(const FacetElement& element, int gdim, const double* nodes, const double* point, int edge, double margin,
              FacetProjection& best)
{
  const int* ends = edge_corners(element.shape, edge);
  const double* middle = element.degree == 2 ? nodes + (element.num_corners() + edge) * gdim : nullptr;
  double t;
  if (!project_on_curve(gdim, nodes + ends[0] * gdim, nodes + ends[1] * gdim, middle, point, margin, t))
    return;
  const auto a = element.node(ends[0]), b = element.node(ends[1]);
  const double xi[2] = {(1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1]};
  double x[3] = {0.0, 0.0, 0.0};
  position(element, gdim, nodes, xi, x);
  const bool whole = element.shape == FacetShape::interval;
  compare(best, whole ? ProjectionStatus::converged : ProjectionStatus::edge, whole ? -1 : edge, xi, x,
          std::sqrt(squared_distance(gdim, x, point)), std::sqrt(squared_distance(gdim, nodes, nodes + gdim)));
}
} // namespace

FacetProjection project_on_facet(const FacetElement& element, int gdim, const double* nodes, const double* point,
                                 Starts starts, double margin, const double* start)
{
  FacetProjection best;
  const int corners = element.num_corners();
  if (element.tdim() == 1)
    try_edge(element, gdim, nodes, point, 0, margin, best);
  else
  {
    if (start && starts == Starts::nearest)
      try_interior(element, nodes, point, start, margin, best);
    if (best.status != ProjectionStatus::converged)
      try_inside(element, nodes, point, starts, margin, best);
    if (starts == Starts::nearest && best.status == ProjectionStatus::converged)
      return best;
    for (int e = 0; e < corners; ++e)
      try_edge(element, gdim, nodes, point, e, 0.0, best);
  }
  for (int i = 0; i < corners; ++i)
  {
    double x[3] = {0.0, 0.0, 0.0};
    std::copy_n(nodes + gdim * i, gdim, x);
    compare(best, ProjectionStatus::vertex, i, element.node(i).data(), x, std::sqrt(squared_distance(gdim, x, point)),
            std::sqrt(squared_distance(gdim, nodes, nodes + gdim)));
  }
  return best;
}

Bend bend(const FacetElement& element, int gdim, const double* nodes)
{
  if (element.tdim() == 1) // all roots are found anyway
    return {0.0, std::numeric_limits<double>::infinity()};
  // Reference coordinates are scaled so that long facets are judged like square ones.
  constexpr double origin[3] = {0.0, 0.0, 0.0};
  double centre[3], g[2], m[3], h[3];
  position(element, 3, nodes, element.centre().data(), centre);
  derivatives(element, nodes, element.centre().data(), origin, g, m, h);
  const double scale[3] = {1.0 / m[0], 1.0 / m[1], 1.0 / std::sqrt(m[0] * m[1])};
  double radius = 0.0, least = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (int i = 0; i < element.num_nodes(); ++i)
  {
    radius = std::max(radius, squared_distance(gdim, nodes + gdim * i, centre));
    double squares[3] = {0.0, 0.0, 0.0};
    for (int c = 0; c < 3; ++c)
    {
      const double unit[3] = {c == 0 ? 1.0 : 0.0, c == 1 ? 1.0 : 0.0, c == 2 ? 1.0 : 0.0};
      derivatives(element, nodes, element.node(i).data(), unit, g, m, h);
      for (int k = 0; k < 3; ++k)
        squares[k] += std::pow(scale[k] * (m[k] - h[k]), 2);
    }
    largest = std::max(largest, std::sqrt(std::max(squares[0], squares[1])) + std::sqrt(squares[2]));
    const double mean = 0.5 * (m[0] * scale[0] + m[1] * scale[1]);
    least = std::min(least, mean - std::hypot(0.5 * (m[0] * scale[0] - m[1] * scale[1]), m[2] * scale[2]));
  }
  return {std::sqrt(radius), largest > 0.0 ? least / largest : std::numeric_limits<double>::infinity()};
}
} // namespace dolfinx_impact::search
