// SPDX-License-Identifier: MIT
#include "segments.h"
#include "../search/closest_point/facet_projection.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace dolfinx_impact::gap
{
using surface::FacetElement;
using surface::FacetPoint;
using surface::Facets;

namespace
{
typedef std::array<double, 2> Point;

/// Plane (in 2D: line) through the centre of a slave facet.
struct Plane
{
  double origin[3], normal[3], axes[2][3];
  int gdim;

  Point project(const double* x) const
  {
    Point y{0.0, 0.0};
    for (int a = 0; a < gdim - 1; ++a)
      for (int c = 0; c < gdim; ++c)
        y[a] += (x[c] - origin[c]) * axes[a][c];
    return y;
  }
  double height(const double* x) const
  {
    double h = 0.0;
    for (int c = 0; c < gdim; ++c)
      h += (x[c] - origin[c]) * normal[c];
    return h;
  }
};

Plane make_plane(const FacetPoint& centre, int gdim)
{
  Plane p{};
  p.gdim = gdim;
  double length = 0.0;
  for (int c = 0; c < 3; ++c)
  {
    p.origin[c] = centre.x[c];
    p.normal[c] = centre.normal[c];
    length += centre.tangents[0][c] * centre.tangents[0][c];
  }
  for (int c = 0; c < 3; ++c)
    p.axes[0][c] = centre.tangents[0][c] / std::sqrt(length);
  const double *n = p.normal, *t = p.axes[0];
  if (gdim == 3)
    for (int c = 0; c < 3; ++c)
      p.axes[1][c] = n[(c + 1) % 3] * t[(c + 2) % 3] - n[(c + 2) % 3] * t[(c + 1) % 3];
  return p;
}

/// Polygon of at most 8 corners, counter-clockwise; two corners in the plane (an interval).
struct Polygon
{
  std::array<Point, 16> corners;
  int size = 0;
  void add(const Point& p) { corners[size++] = p; }
};

double area(const Polygon& p)
{
  double twice = 0.0;
  for (int i = 0; i < p.size; ++i)
  {
    const Point &a = p.corners[i], &b = p.corners[(i + 1) % p.size];
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return twice / 2;
}

/// Centroid of a polygon with an area.
Point centroid(const Polygon& p)
{
  double sum = 0.0;
  Point first{0.0, 0.0};
  const Point& o = p.corners[0];
  for (int i = 2; i < p.size; ++i)
  {
    const Point &a = p.corners[i - 1], &b = p.corners[i];
    const double twice = (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    sum += twice;
    for (int c = 0; c < 2; ++c)
      first[c] += twice * (a[c] + b[c] - 2 * o[c]) / 3;
  }
  return {o[0] + first[0] / sum, o[1] + first[1] / sum};
}

/// Corners of a facet on the plane, counter-clockwise (in 2D: increasing).
Polygon outline(const Facets& facets, std::size_t f, const Plane& plane)
{
  constexpr int order[4] = {0, 1, 3, 2}; // round the quadrilateral
  const int n = facets.geometry.num_corners();
  Polygon p;
  for (int i = 0; i < n; ++i)
    p.add(plane.project(facets.x_of(f) + (n == 4 ? order[i] : i) * facets.gdim));
  const bool reverse = n == 2 ? p.corners[0][0] > p.corners[1][0] : area(p) < 0.0;
  if (reverse)
    std::reverse(p.corners.begin(), p.corners.begin() + n);
  return p;
}

/// What of `subject` lies inside the convex polygon `clip` (Sutherland and Hodgman 1974).
Polygon intersect(const Polygon& clip, const Polygon& subject)
{
  Polygon in = subject;
  for (int e = 0; e < clip.size && in.size > 0; ++e)
  {
    const Point &a = clip.corners[e], &b = clip.corners[(e + 1) % clip.size];
    auto side = [&](const Point& p) { return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]); };
    Polygon out;
    for (int i = 0; i < in.size; ++i)
    {
      const Point &p = in.corners[i], &q = in.corners[(i + 1) % in.size];
      const double sp = side(p), sq = side(q);
      if (sp >= 0.0)
        out.add(p);
      if ((sp > 0.0 && sq < 0.0) || (sp < 0.0 && sq > 0.0))
      {
        const double t = sp / (sp - sq);
        out.add({p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])});
      }
    }
    in = out;
  }
  return in;
}

/// A facet projected on a plane: its nodes carry over, so that places and derivatives are sums over a plane's vectors.
class ProjectedFacet
{
public:
  ProjectedFacet(const Facets& facets, std::size_t f, const Plane& plane)
      : _element(facets.geometry), _dim(facets.gdim - 1), _num_nodes(_element.num_nodes())
  {
    for (int i = 0; i < _num_nodes; ++i)
      _nodes[i] = plane.project(facets.x_of(f) + i * facets.gdim);
  }

  /// Reference coordinates whose point projects on y, by Newton's method (one step on affine facets). They may lie a
  /// little outside where an edge is curved: polygons are those of the corners, so that neighbours leave no slit
  /// between them.
  bool invert(const Point& y, double* xi) const
  {
    const auto centre = _element.centre();
    xi[0] = centre[0];
    xi[1] = centre[1];
    double step = 1.0, before = 2.0;
    // Steps that become no smaller are round-off of the places over the size of the facet.
    for (int iteration = 0; iteration < 30 && !(step < 1e-14) && !(step < 1e-9 && step > 0.5 * before); ++iteration)
    {
      before = step;
      Point at;
      double J[2][2];
      evaluate(xi, at, J);
      const double r[2] = {y[0] - at[0], y[1] - at[1]};
      double d[2] = {0.0, 0.0};
      if (_dim == 1)
        d[0] = r[0] / J[0][0];
      else
      {
        const double det = J[0][0] * J[1][1] - J[0][1] * J[1][0];
        d[0] = (r[0] * J[1][1] - r[1] * J[0][1]) / det;
        d[1] = (r[1] * J[0][0] - r[0] * J[1][0]) / det;
      }
      xi[0] += d[0];
      xi[1] += d[1];
      step = std::abs(d[0]) + std::abs(d[1]);
      if (!(step < 10.0)) // far outside, or not a number
        return false;
    }
    return step < 1e-9 && _element.inside(xi, 1.0);
  }

private:
  /// Place of reference coordinates, and its derivatives J[a][b] of component a by coordinate b.
  void evaluate(const double* xi, Point& at, double J[2][2]) const
  {
    if (_num_nodes == 4)
    {
      // Bilinear facets are frequent enough for a polynomial without tables of shape functions.
      for (int a = 0; a < 2; ++a)
      {
        const double along = _nodes[1][a] - _nodes[0][a], across = _nodes[2][a] - _nodes[0][a];
        const double twist = _nodes[3][a] - _nodes[2][a] - along;
        J[a][0] = along + twist * xi[1];
        J[a][1] = across + twist * xi[0];
        at[a] = _nodes[0][a] + J[a][0] * xi[0] + across * xi[1];
      }
      return;
    }
    double phi[FacetElement::max_nodes], dphi[2 * FacetElement::max_nodes];
    _element.values(xi, phi);
    _element.derivatives(xi, dphi);
    at = {0.0, 0.0};
    for (int a = 0; a < _dim; ++a)
      J[a][0] = J[a][1] = 0.0;
    for (int i = 0; i < _num_nodes; ++i)
      for (int a = 0; a < _dim; ++a)
      {
        at[a] += phi[i] * _nodes[i][a];
        for (int b = 0; b < _dim; ++b)
          J[a][b] += dphi[b * _num_nodes + i] * _nodes[i][a];
      }
  }

  FacetElement _element;
  int _dim, _num_nodes;
  std::array<Point, FacetElement::max_nodes> _nodes{};
};

/// Area projected on the plane per reference area: the facet's own times the cosine between the normals.
double projected(const FacetPoint& p, const Plane& plane)
{
  double cosine = 0.0;
  for (int c = 0; c < 3; ++c)
    cosine += p.normal[c] * plane.normal[c];
  return p.jacobian * std::abs(cosine);
}

double reference_weight(const Facets& facets, std::size_t f, const double* xi, bool axisymmetric)
{
  const FacetPoint p = surface::evaluate(facets, f, facets.X_of(f), xi);
  return p.jacobian * (axisymmetric ? 2 * std::numbers::pi * p.x[0] : 1.0);
}

/// Adds points on one segment: an interval, or a triangle given by corners.
class Collector
{
public:
  Collector(const Facets& slave, const SegmentRule& rule, bool axisymmetric, Segments& out)
      : _slave(slave), _rule(rule), _axisymmetric(axisymmetric), _out(out)
  {
  }

  /// @param[in] mine, theirs the slave facet s and the master facet m on the plane
  void add(std::size_t s, std::size_t m, const Plane& plane, const ProjectedFacet& mine, const ProjectedFacet& theirs,
           const Point& a, const Point& b, const Point& c)
  {
    const int dim = _slave.gdim - 1;
    const double scale =
        dim == 1 ? std::abs(b[0] - a[0]) : std::abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
    for (std::size_t q = 0; q < _rule.weights.size(); ++q)
    {
      const double u = _rule.points[q * dim], v = dim == 1 ? 0.0 : _rule.points[q * dim + 1];
      const Point y{a[0] + u * (b[0] - a[0]) + v * (c[0] - a[0]), a[1] + u * (b[1] - a[1]) + v * (c[1] - a[1])};
      double xs[2], xm[2];
      if (!mine.invert(y, xs) || !theirs.invert(y, xm))
        continue;
      const FacetPoint point = surface::evaluate(_slave, s, _slave.x_of(s), xs);
      const double weight = _rule.weights[q] * scale / projected(point, plane);
      _out.slave.push_back(std::int32_t(s));
      _out.master.push_back(std::int32_t(m));
      _out.xi_slave.insert(_out.xi_slave.end(), xs, xs + 2);
      _out.xi_master.insert(_out.xi_master.end(), xm, xm + 2);
      _out.weight.push_back(weight * reference_weight(_slave, s, xs, _axisymmetric));
      _out.direction.insert(_out.direction.end(), plane.normal, plane.normal + 3);
      _out.covered[s] += weight / _slave.geometry.reference_area();
    }
  }

private:
  const Facets& _slave;
  const SegmentRule& _rule;
  bool _axisymmetric;
  Segments& _out;
};

bool facing(const FacetPoint& a, const FacetPoint& b)
{
  double product = 0.0;
  for (int c = 0; c < 3; ++c)
    product += a.normal[c] * b.normal[c];
  return product < -search::right_angle;
}
} // namespace

Segments segment(const Facets& slave, const Facets& master, std::span<const std::int32_t> pairs,
                 std::span<const std::int32_t> offsets, const SegmentRule& rule, double reach, bool axisymmetric)
{
  Segments out;
  out.covered.assign(slave.size(), 0.0);
  Collector collector(slave, rule, axisymmetric, out);
  const auto centre = slave.geometry.centre();
  for (std::size_t s = 0; s < slave.size(); ++s)
  {
    const FacetPoint at = surface::evaluate(slave, s, slave.x_of(s), centre.data());
    const Plane plane = make_plane(at, slave.gdim);
    const Polygon mine = outline(slave, s, plane);
    const ProjectedFacet slave_facet(slave, s, plane);
    for (std::int32_t k = offsets[s]; k < offsets[s + 1]; ++k)
    {
      const std::size_t m = pairs[k];
      // Facets count as wholes: of one covered at a single point nothing could be integrated.
      const FacetPoint other = surface::evaluate(master, m, master.x_of(m), master.geometry.centre().data());
      if (!facing(at, other) || std::abs(plane.height(other.x)) > reach)
        continue;
      const Polygon theirs = outline(master, m, plane);
      if (slave.gdim == 2)
      {
        const double low = std::max(mine.corners[0][0], theirs.corners[0][0]);
        const double high = std::min(mine.corners[1][0], theirs.corners[1][0]);
        if (high - low > 1e-12 * (mine.corners[1][0] - mine.corners[0][0]))
          collector.add(s, m, plane, slave_facet, {master, m, plane}, {low, 0.0}, {high, 0.0}, {low, 0.0});
        continue;
      }
      const Polygon common = intersect(mine, theirs);
      if (common.size < 3 || area(common) < 1e-12 * area(mine))
        continue;
      const Point middle = centroid(common);
      const ProjectedFacet master_facet(master, m, plane);
      for (int i = 0; i < common.size; ++i)
        collector.add(s, m, plane, slave_facet, master_facet, middle, common.corners[i],
                      common.corners[(i + 1) % common.size]);
    }
  }
  return out;
}

Segments whole_facets(const Facets& slave, const SegmentRule& rule, bool axisymmetric)
{
  Segments out;
  out.covered.assign(slave.size(), 1.0);
  const int dim = slave.gdim - 1;
  for (std::size_t s = 0; s < slave.size(); ++s)
    for (std::size_t q = 0; q < rule.weights.size(); ++q)
    {
      const double xi[2] = {rule.points[q * dim], dim == 1 ? 0.0 : rule.points[q * dim + 1]};
      out.slave.push_back(std::int32_t(s));
      out.master.push_back(-1);
      out.xi_slave.insert(out.xi_slave.end(), xi, xi + 2);
      out.xi_master.insert(out.xi_master.end(), {0.0, 0.0});
      out.weight.push_back(rule.weights[q] * reference_weight(slave, s, xi, axisymmetric));
      out.direction.insert(out.direction.end(), {0.0, 0.0, 0.0});
    }
  return out;
}
} // namespace dolfinx_impact::gap
