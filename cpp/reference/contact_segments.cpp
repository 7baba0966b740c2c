// SPDX-License-Identifier: MIT
#include "contact_segments.h"

namespace impact_reference
{
std::array<std::array<double, 2>, 2> inverse_slope(const Spot<double>& spot, const Plane<double>& plane)
{
  const double a = dot(spot.a[0], plane.e[0]), b = dot(spot.a[1], plane.e[0]);
  const double c = dot(spot.a[0], plane.e[1]), d = dot(spot.a[1], plane.e[1]);
  // In 2D the second tangent and the second direction are along z, and b = c = 0.
  const double det = a * d - b * c;
  return {{{d / det, -b / det}, {-c / det, a / det}}};
}

Local carry_back(const Surface& s, const Facet& facet, const std::vector<Vec<double>>& u, const Plane<double>& plane,
                 const Flat<double>& y)
{
  Local xi = facet_centre(s.type);
  for (int iteration = 0; iteration < 50; ++iteration)
  {
    const Spot<double> p = spot<double>(s, facet, u, xi);
    const Flat<double> now = plane.flat(p.x);
    const auto inverse = inverse_slope(p, plane);
    double length = 0;
    Local step{0, 0};
    for (int a = 0; a < s.tdim(); ++a)
    {
      for (int b = 0; b < s.tdim(); ++b)
        step[a] -= inverse[a][b] * (now[b] - y[b]);
      length += std::abs(step[a]);
    }
    const double shorten = length > 1 ? 1 / length : 1;
    for (int a = 0; a < 2; ++a)
      xi[a] += shorten * step[a];
    if (not std::isfinite(length))
      break;
    if (length < 1e-11)
      return xi;
  }
  throw std::domain_error("a point of a contact segment has no place on its facet: the facet stands upright on the "
                          "slave facet's plane or is folded");
}
} // namespace impact_reference
