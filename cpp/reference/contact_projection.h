// SPDX-License-Identifier: MIT
#pragma once
#include "contact_surface.h"

namespace impact_reference
{
/// Where a point is nearest to a facet: in its interior, on an edge or at a vertex.
struct Foot
{
  std::int64_t facet = -1;           ///< -1: none
  Local xi{0, 0};                    ///< reference coordinates
  int dim = 0;                       ///< directions in which it is free to move: tdim, then 1 on edges, 0 at vertices
  std::array<Local, 2> direction{};  ///< these directions, in reference coordinates
  std::vector<std::int64_t> corners; ///< geometry vertices of the edge, or the vertex; empty in the interior
  double distance = 0;               ///< not negative [L]
  double sign = 1;                   ///< of the gap
  bool beside = false;               ///< the point lies beside the rim, where the master ends
};

/// Gap, normal and place on the master, with derivatives.
template <typename T>
struct Projection
{
  T gap;
  Vec<T> normal;
  FacetFunctions<T> f; ///< of the master's displacement, at the closest point
};

/// Searches all facets of the master in its current configuration for the closest one.
class Projector
{
public:
  /// @param search_distance how far a master point may be [L]
  Projector(const Surface& master, const Vector& u, double search_distance);

  /// @param x slave point, normal that of its facet. A foot without facet if nothing faces it within the search
  /// distance, or if the point has slipped off: it is behind the surface and beside its rim.
  Foot closest(const Vec<double>& x, const Vec<double>& normal) const;
  /// The same wherever it lies, without sign.
  Foot nearest(const Vec<double>& x, const Vec<double>& normal) const;
  /// Whether a foot lies where the master ends.
  bool on_rim(const Foot& foot) const;

  /// Gap and normal at a foot when slave point and master move.
  /// @param u the facet's displacements
  template <typename T>
  Projection<T> follow(const Foot& foot, const std::vector<Vec<T>>& u, const Vec<T>& x) const;

private:
  Foot closest_on(std::int64_t facet, const Vec<double>& x) const;
  double distance_to_edge(std::int64_t facet, const Local& a, const Local& b, const Vec<double>& x) const;
  bool converge(std::int64_t facet, const Vec<double>& x, Foot& foot) const;
  Vec<double> normal_at(const Foot& foot) const;
  std::array<double, 6> derivatives(std::int64_t facet, const Foot& foot, const Vec<double>& x) const;

  const Surface& master_;
  double search_distance_;
  std::vector<std::vector<Vec<double>>> u_;
  std::vector<std::vector<Vec<Dual<2>>>> constant_u_; // the same, whose derivatives are zero
  std::vector<Vec<double>> centres_;                  // of spheres around the facets
  std::vector<double> radii_;
};

template <typename T>
Projection<T> Projector::follow(const Foot& foot, const std::vector<Vec<T>>& u, const Vec<T>& x) const
{
  const Facet& facet = master_.facets[foot.facet];
  std::array<T, 2> xi{T(foot.xi[0]), T(foot.xi[1])};
  Spot<T> s = spot(master_, facet, u, xi);
  if (foot.dim > 0)
  {
    // One Newton step on T: the value stays, the derivative is that of the implicit function.
    const auto h = derivatives(foot.facet, foot, values(x));
    const Vec<T> d = s.x - x;
    std::array<T, 2> r;
    for (int k = 0; k < foot.dim; ++k)
      r[k] = dot(foot.direction[k][0] * s.a[0] + foot.direction[k][1] * s.a[1], d);
    std::array<T, 2> step;
    if (foot.dim == 1)
      step[0] = r[0] / -h[2];
    else
    {
      const double det = h[2] * h[5] - h[3] * h[4];
      step[0] = (h[3] * r[1] - h[5] * r[0]) / det;
      step[1] = (h[4] * r[0] - h[2] * r[1]) / det;
    }
    for (int k = 0; k < foot.dim; ++k)
      for (int c = 0; c < 2; ++c)
        xi[c] += foot.direction[k][c] * step[k];
    s = spot(master_, facet, u, xi);
  }
  const Vec<T> d = x - s.x;
  if (foot.dim == master_.tdim() or foot.distance <= 1e-14 * radii_[foot.facet])
  {
    const Vec<T> n = s.normal();
    return {dot(d, n), n, s.f};
  }
  const T distance = norm(d);
  return {foot.sign * distance, (foot.sign / distance) * d, s.f};
}
} // namespace impact_reference
