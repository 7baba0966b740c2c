// SPDX-License-Identifier: MIT
#include "contact_projection.h"
#include "SymmetricEigen.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace impact_reference
{
namespace
{
constexpr double inside_tolerance = 1e-9; // in reference coordinates

bool inside(CellType type, const Local& xi)
{
  if (type == CellType::triangle)
    return std::min({xi[0], xi[1], 1 - xi[0] - xi[1]}) >= -inside_tolerance;
  return std::max(std::abs(xi[0]), std::abs(xi[1])) <= 1 + inside_tolerance;
}

// Edges of facets of space, as local vertices.
std::vector<std::vector<int>> facet_edges(const Surface& s)
{
  std::vector<std::vector<int>> edges;
  if (s.tdim() == 2)
    for (const auto& entity : node_vertices(s.type, 2))
      if (entity.size() == 2)
        edges.push_back(entity);
  return edges;
}

bool has(const Facet& facet, const std::vector<std::int64_t>& vertices)
{
  return std::all_of(vertices.begin(), vertices.end(), [&](auto v)
                     { return std::find(facet.vertices.begin(), facet.vertices.end(), v) != facet.vertices.end(); });
}
} // namespace

Projector::Projector(const Surface& master, const Vector& u, double search_distance)
    : master_(master), search_distance_(search_distance)
{
  for (const Facet& facet : master.facets)
  {
    u_.push_back(gather(master, facet, u));
    std::vector<Vec<Dual<2>>>& constants = constant_u_.emplace_back();
    for (const auto& v : u_.back())
      constants.push_back(constant<Dual<2>>(v));
    const Vec<double> c = spot<double>(master, facet, u_.back(), facet_centre(master.type)).x;
    // |x - c| <= Lebesgue constant (at most 5/3) x distance of the nodes of geometry and displacement to the centre.
    const Spot<double> rest = reference_spot<double>(master, facet, facet_centre(master.type));
    double radius = 0, moved = 0;
    for (int i = 0; i < facet.X.rows(); ++i)
    {
      Vec<double> x;
      for (int k = 0; k < master.gdim; ++k)
        x[k] = facet.X(i, k);
      radius = std::max(radius, norm(x - rest.x));
    }
    for (const auto& v : u_.back())
      moved = std::max(moved, norm(v - (c - rest.x)));
    centres_.push_back(c);
    radii_.push_back(5.0 / 3 * (radius + moved));
  }
}

// First and second derivatives of half the squared distance along the foot's directions: r0 r1, then h00 h01 h10 h11.
std::array<double, 6> Projector::derivatives(std::int64_t facet, const Foot& foot, const Vec<double>& x) const
{
  using T = Dual<2>;
  const auto s = spot<T>(master_, master_.facets[facet], constant_u_[facet],
                         {T::variable(foot.xi[0], 0), T::variable(foot.xi[1], 1)});
  std::array<double, 6> result{};
  for (int k = 0; k < foot.dim; ++k)
  {
    const T r = dot(foot.direction[k][0] * s.a[0] + foot.direction[k][1] * s.a[1], s.x - constant<T>(x));
    result[k] = r.v;
    for (int m = 0; m < foot.dim; ++m)
      result[2 + 2 * k + m] = r.d(0) * foot.direction[m][0] + (master_.tdim() == 2 ? r.d(1) : 0) * foot.direction[m][1];
  }
  return result;
}

// Newton's method from foot.xi along foot.direction. True if it ends on the facet.
bool Projector::converge(std::int64_t facet, const Vec<double>& x, Foot& foot) const
{
  const auto distance = [&](const Local& xi)
  { return norm(spot<double>(master_, master_.facets[facet], u_[facet], xi).x - x); };
  double current = distance(foot.xi);
  for (int iteration = 0; iteration < 60 and foot.dim > 0; ++iteration)
  {
    auto h = derivatives(facet, foot, x);
    Eigen::MatrixXd H(foot.dim, foot.dim);
    Vector r(foot.dim);
    for (int k = 0; k < foot.dim; ++k)
    {
      r(k) = h[k];
      for (int m = 0; m < foot.dim; ++m)
        H(k, m) = h[2 + 2 * k + m];
    }
    // Where the distance is not convex the lowest eigenvalue is raised: the step still leads downwards.
    const SymmetricEigen eigen(H);
    const double largest = eigen.eigenvalues().cwiseAbs().maxCoeff();
    const Vector e = eigen.eigenvalues().cwiseAbs().cwiseMax(1e-3 * largest);
    const Vector along = eigen.eigenvectors().transpose().lazyProduct(r);
    Vector step = -eigen.eigenvectors().lazyProduct(along.cwiseQuotient(e));
    if (step.norm() > 0.5)
      step *= 0.5 / step.norm();
    Local next = foot.xi;
    for (int halving = 0; halving < 30; ++halving, step /= 2)
    {
      next = foot.xi;
      for (int k = 0; k < foot.dim; ++k)
        for (int c = 0; c < 2; ++c)
          next[c] += step(k) * foot.direction[k][c];
      if (step.norm() < 1e-6 or distance(next) <= current)
        break;
    }
    foot.xi = next;
    current = distance(next);
    if (step.norm() < 1e-11 or std::abs(next[0]) + std::abs(next[1]) > 5)
      break;
  }
  foot.facet = facet;
  foot.distance = current;
  return inside(master_.type, foot.xi);
}

// No point of the edge from a to b is closer than this, but for round-off of positions. An edge is a parabola, its
// chord and (1 - s^2) times its height in the middle, s from -1 to 1: it is nowhere further from the chord than there.
double Projector::distance_to_edge(std::int64_t facet, const Local& a, const Local& b, const Vec<double>& x) const
{
  const auto at = [&](const Local& xi) { return spot<double>(master_, master_.facets[facet], u_[facet], xi).x; };
  const Vec<double> first = at(a), last = at(b), middle = at({0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])});
  const Vec<double> chord = last - first;
  const double along = std::clamp(dot(x - first, chord) / dot(chord, chord), 0.0, 1.0);
  return norm(x - first - along * chord) - norm(middle - 0.5 * (first + last)) - 1e-12 * norm(chord);
}

Foot Projector::closest_on(std::int64_t facet, const Vec<double>& x) const
{
  const CellType type = master_.type;
  const auto at = [&](const Local& xi)
  { return norm(spot<double>(master_, master_.facets[facet], u_[facet], xi).x - x); };
  Foot best;
  best.distance = std::numeric_limits<double>::infinity();
  const auto consider = [&](Foot foot)
  {
    if (converge(facet, x, foot) and foot.distance < best.distance)
      best = foot;
  };
  Foot start;
  start.dim = master_.tdim();
  start.direction = {Local{1, 0}, Local{0, 1}};
  start.xi = facet_centre(type);
  double least = at(start.xi);
  if (not master_.affine())
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < (master_.tdim() == 2 ? 5 : 1); ++j)
      {
        Local xi{0.5 * i - 1, master_.tdim() == 2 ? 0.5 * j - 1 : 0};
        if (type == CellType::triangle)
          xi = {0.25 * i, 0.25 * j};
        if (not inside(type, xi))
          continue;
        if (const double distance = at(xi); distance < least)
        {
          start.xi = xi;
          least = distance;
        }
      }
  consider(start);
  const auto better_than_best = [&](double distance) { return distance < best.distance * (1 - 1e-14); };
  for (const auto& edge : facet_edges(master_))
  {
    const Local a = facet_vertex(type, edge[0]), b = facet_vertex(type, edge[1]);
    if (not better_than_best(distance_to_edge(facet, a, b, x)))
      continue;
    Foot foot;
    foot.dim = 1;
    foot.direction[0] = {(b[0] - a[0]) / 2, (b[1] - a[1]) / 2};
    foot.corners = {master_.facets[facet].vertices[edge[0]], master_.facets[facet].vertices[edge[1]]};
    double nearest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 5; ++i)
    {
      const Local xi{a[0] + 0.25 * i * (b[0] - a[0]), a[1] + 0.25 * i * (b[1] - a[1])};
      if (const double distance = at(xi); distance < nearest)
      {
        nearest = distance;
        foot.xi = xi;
      }
    }
    if (converge(facet, x, foot) and better_than_best(foot.distance))
      best = foot;
  }
  for (int v = 0; v < master_.num_vertices(); ++v)
    if (better_than_best(at(facet_vertex(type, v))))
    {
      best = Foot{};
      best.facet = facet;
      best.xi = facet_vertex(type, v);
      best.corners = {master_.facets[facet].vertices[v]};
      best.distance = at(best.xi);
    }
  return best;
}

// The facet's normal inside, on edges and vertices the mean over the facets that meet there.
Vec<double> Projector::normal_at(const Foot& foot) const
{
  if (foot.corners.empty())
    return spot<double>(master_, master_.facets[foot.facet], u_[foot.facet], foot.xi).normal();
  // Place on the edge between its corners.
  double t = 0;
  const auto place = [&](const Facet& facet, std::int64_t vertex)
  {
    return facet_vertex(master_.type,
                        int(std::find(facet.vertices.begin(), facet.vertices.end(), vertex) - facet.vertices.begin()));
  };
  const Facet& own = master_.facets[foot.facet];
  if (foot.corners.size() == 2)
  {
    const Local a = place(own, foot.corners[0]), b = place(own, foot.corners[1]);
    const double e[2]{b[0] - a[0], b[1] - a[1]};
    t = ((foot.xi[0] - a[0]) * e[0] + (foot.xi[1] - a[1]) * e[1]) / (e[0] * e[0] + e[1] * e[1]);
  }
  Vec<double> sum;
  for (std::size_t f = 0; f < master_.facets.size(); ++f)
    if (const Facet& facet = master_.facets[f]; has(facet, foot.corners))
    {
      const Local a = place(facet, foot.corners.front()), b = place(facet, foot.corners.back());
      const Local xi{(1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1]};
      sum = sum + spot<double>(master_, facet, u_[f], xi).normal();
    }
  return unit(sum);
}

// True if the edge, or an edge at the vertex, belongs to one facet only: the master ends there.
bool Projector::on_rim(const Foot& foot) const
{
  const auto count = [&](const std::vector<std::int64_t>& v)
  { return std::count_if(master_.facets.begin(), master_.facets.end(), [&](const Facet& f) { return has(f, v); }); };
  if (foot.corners.empty())
    return false;
  if (foot.corners.size() == 2 or master_.tdim() == 1)
    return count(foot.corners) == 1;
  for (const Facet& facet : master_.facets)
    if (has(facet, foot.corners))
      for (const auto& edge : facet_edges(master_))
      {
        const std::vector<std::int64_t> v{facet.vertices[edge[0]], facet.vertices[edge[1]]};
        if ((v[0] == foot.corners[0] or v[1] == foot.corners[0]) and count(v) == 1)
          return true;
      }
  return false;
}

Foot Projector::nearest(const Vec<double>& x, const Vec<double>& normal) const
{
  std::vector<std::pair<double, std::int64_t>> order;
  order.reserve(master_.facets.size());
  for (std::size_t f = 0; f < master_.facets.size(); ++f)
    order.emplace_back(norm(x - centres_[f]) - radii_[f], f);
  std::sort(order.begin(), order.end());
  Foot best;
  best.distance = search_distance_;
  // Facets that meet at the closest point are at one distance: the point inside a facet first, then the first facet.
  const auto preferred = [&](const Foot& foot)
  {
    const double round_off = 1e-12 * (best.distance + radii_[best.facet]);
    if (std::abs(foot.distance - best.distance) > round_off)
      return foot.distance < best.distance;
    const bool inside = foot.dim == master_.tdim(), other = best.dim == master_.tdim();
    return inside != other ? inside : foot.facet < best.facet;
  };
  for (const auto& [bound, f] : order)
  {
    if (bound > best.distance * (1 + 1e-9))
      break;
    const Foot foot = closest_on(f, x);
    if (best.facet < 0 ? foot.distance > best.distance : not preferred(foot))
      continue;
    if (dot(spot<double>(master_, master_.facets[f], u_[f], foot.xi).normal(), normal) <
        -1e-9) // docs: right angles do not face
      best = foot;
  }
  return best;
}

Foot Projector::closest(const Vec<double>& x, const Vec<double>& normal) const
{
  Foot best = nearest(x, normal);
  if (best.facet < 0)
    return best;
  const Vec<double> d = x - spot<double>(master_, master_.facets[best.facet], u_[best.facet], best.xi).x;
  const Vec<double> n = normal_at(best);
  best.sign = dot(d, n) < 0 ? -1 : 1;
  // Nodes of a plane of symmetry are under the rim; under a facet tilted against the plane, not quite.
  const double size = 1.2 * radii_[best.facet], depth = std::abs(dot(d, n));
  const double under = 1e-9 * size + (depth < 0.05 * size ? std::tan(5.0 * std::numbers::pi / 180.0) * depth : 0.0);
  best.beside = norm(d - dot(d, n) * n) > under and on_rim(best);
  if (best.sign < 0 and best.beside)
    return {};
  return best;
}
} // namespace impact_reference
