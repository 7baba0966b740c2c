// SPDX-License-Identifier: MIT
#include "boxes.h"
#include <algorithm>

namespace dolfinx_impact::search
{
using surface::FacetElement;
using surface::FacetShape;

void control_points(const FacetElement& element, int gdim, const double* x, double* control)
{
  std::copy_n(x, element.num_nodes() * gdim, control);
  if (element.degree == 1)
    return;
  const int corners = element.num_corners();
  const int edges = element.shape == FacetShape::interval ? 1 : corners;
  for (int e = 0; e < edges; ++e)
  {
    const int* ends = surface::edge_corners(element.shape, e);
    for (int c = 0; c < gdim; ++c)
      control[(corners + e) * gdim + c] =
          2 * x[(corners + e) * gdim + c] - (x[ends[0] * gdim + c] + x[ends[1] * gdim + c]) / 2;
  }
  if (element.shape == FacetShape::quadrilateral)
    for (int c = 0; c < gdim; ++c)
    {
      // 1/16 of the corners, 1/8 of the edges and 1/4 of the centre of the control net make the facet's centre.
      double rest = x[8 * gdim + c];
      for (int i = 0; i < 4; ++i)
        rest -= control[i * gdim + c] / 16 + control[(4 + i) * gdim + c] / 8;
      control[8 * gdim + c] = 4 * rest;
    }
}

void bounding_boxes(const surface::Facets& facets, std::vector<double>& boxes)
{
  const int gdim = facets.gdim, n = facets.geometry.num_nodes();
  boxes.resize(2 * gdim * facets.size());
  double control[3 * FacetElement::max_nodes];
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    control_points(facets.geometry, gdim, facets.x_of(f), control);
    for (int c = 0; c < gdim; ++c)
    {
      double low = control[c], high = control[c];
      for (int i = 1; i < n; ++i)
      {
        low = std::min(low, control[i * gdim + c]);
        high = std::max(high, control[i * gdim + c]);
      }
      boxes[2 * gdim * f + c] = low;
      boxes[2 * gdim * f + gdim + c] = high;
    }
  }
}
} // namespace dolfinx_impact::search
