#include "facet_projection.h"
#include "curve_projection.h"
#include <algorithm>
#include <cmath>
#include <limits>

namespace impact::search
{
namespace
{
using surface::FacetElement;
using surface::FacetShape;

constexpr int interval[1][2] = {{0, 1}};
constexpr int triangle[3][2] = {{1, 2}, {0, 2}, {0, 1}};
constexpr int quadrilateral[4][2] = {{0, 1}, {0, 2}, {1, 3}, {2, 3}};

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

const int* edge_corners(FacetShape shape, int edge)
{
  return shape == FacetShape::interval   ? interval[0]
         : shape == FacetShape::triangle ? triangle[edge]
                                         : quadrilateral[edge];
}

FacetProjection project_on_facet(const FacetElement& element, int gdim, const double* nodes, const double* point,
                                 bool one_start, double margin)
{
  FacetProjection best;
  const int n = element.num_nodes(), corners = element.num_corners();
  if (element.tdim() == 1)
    try_edge(element, gdim, nodes, point, 0, margin, best);
  else
  {
    // Start at the node nearest to the point or at the centre; or at all of them.
    const auto centre = element.centre();
    double x[3];
    position(element, 3, nodes, centre.data(), x);
    double nearest = squared_distance(3, x, point);
    auto start = centre;
    if (!one_start)
      try_interior(element, nodes, point, centre.data(), margin, best);
    for (int i = 0; i < n; ++i)
      if (!one_start)
        try_interior(element, nodes, point, element.node(i).data(), margin, best);
      else if (const double d = squared_distance(3, nodes + 3 * i, point); d < nearest)
      {
        nearest = d;
        start = element.node(i);
      }
    if (one_start)
      try_interior(element, nodes, point, start.data(), margin, best);
    if (one_start && best.status == ProjectionStatus::converged)
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

double convex_distance(const FacetElement& element, int gdim, const double* nodes)
{
  if (element.tdim() == 1) // all roots are found anyway
    return std::numeric_limits<double>::infinity();
  const int n = element.num_nodes();
  double diameter = 0.0, least = std::numeric_limits<double>::infinity(), largest = 0.0, bend = 0.0;
  for (int i = 0; i < n; ++i)
  {
    for (int j = 0; j < i; ++j)
      diameter = std::max(diameter, squared_distance(gdim, nodes + gdim * i, nodes + gdim * j));
    double g[2], m[3], h[3], squares = 0.0;
    for (int c = 0; c < 3; ++c)
    {
      const double unit[3] = {c == 0 ? 1.0 : 0.0, c == 1 ? 1.0 : 0.0, c == 2 ? 1.0 : 0.0};
      derivatives(element, nodes, element.node(i).data(), unit, g, m, h);
      for (int k = 0; k < 3; ++k)
        squares += (k == 2 ? 2 : 1) * (m[k] - h[k]) * (m[k] - h[k]);
    }
    bend = std::max(bend, std::sqrt(squares));
    const double mean = 0.5 * (m[0] + m[1]), radius = std::hypot(0.5 * (m[0] - m[1]), m[2]);
    least = std::min(least, mean - radius);
    largest = std::max(largest, mean + radius);
  }
  if (bend <= 1e-12 * std::sqrt(largest))
    return std::numeric_limits<double>::infinity();
  // |r . x,ab| < the metric's lowest eigenvalue; a half of it for what lies between the nodes.
  return 0.5 * least / bend - std::sqrt(diameter);
}
} // namespace impact::search
