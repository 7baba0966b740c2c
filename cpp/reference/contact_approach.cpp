// SPDX-License-Identifier: MIT
#include "contact_explicit.h"
#include <algorithm>
#include <sstream>
#include <stdexcept>

// What a slave node meets in a step: docs/explicit/penalty.md, "Closest points" to "Through the surface".
namespace impact_reference
{
namespace
{
// The mean of the unit normals of a node's facets, not normalised.
std::map<std::int64_t, Vec<double>> nodal_normals(const Surface& surface, const Vector& u)
{
  std::map<std::int64_t, Vec<double>> normals;
  const Matrix places = reference_nodes(surface.type, surface.degree);
  for (const Facet& facet : surface.facets)
  {
    const auto us = gather(surface, facet, u);
    for (int k = 0; k < surface.num_nodes(); ++k)
    {
      Vec<double>& sum = normals[facet.nodes[k]];
      const Local xi{places(k, 0), surface.tdim() == 2 ? places(k, 1) : 0};
      sum = sum + spot<double>(surface, facet, us, xi).normal();
    }
  }
  return normals;
}
} // namespace

double diameter(const Facet& facet)
{
  double longest = 0;
  for (Eigen::Index a = 0; a < Eigen::Index(facet.vertices.size()); ++a)
    for (Eigen::Index b = 0; b < a; ++b)
      longest = std::max(longest, (facet.X.row(a) - facet.X.row(b)).norm());
  return longest;
}

Configuration::Configuration(const NodePairs& pairs, const Vector& u, const RigidPlace& obstacle)
    : pairs_(pairs), u_(u), obstacle_(obstacle)
{
  if (pairs.rigid_)
    return;
  normals_ = nodal_normals(pairs.slave_, u_);
  projector_.emplace(pairs.master_, u_, std::numeric_limits<double>::infinity());
}

Meeting Configuration::meet(std::size_t i, const Vector& moved, bool closed) const
{
  Meeting m = meet_surface(i, moved, closed);
  if (not pairs_.shift_.empty() and not m.beside)
    m.gap += pairs_.shift_[i];
  return m;
}

void NodePairs::adjust_gaps(double layers, std::optional<double> clearance, std::optional<double> adjust,
                            bool default_distance)
{
  if (layers > 0 and default_distance)
    search_distance_ = layers + 2 * search_distance_;
  const Vector rest = Vector::Zero(num_dofs());
  const Configuration undeformed(*this, rest, {});
  std::vector<double> shift;
  for (std::size_t i = 0; i < nodes_.size(); ++i)
  {
    const Meeting met = undeformed.meet(i, rest, false);
    const double meshed = met.gap, gap = meshed - layers;
    const bool chosen = std::isfinite(meshed) and not met.beside and (adjust ? gap <= *adjust : clearance.has_value());
    shift.push_back(chosen ? clearance.value_or(0) - meshed : -layers);
  }
  shift_ = std::move(shift);
}

Meeting Configuration::meet_surface(std::size_t i, const Vector& moved, bool closed) const
{
  Meeting m;
  const std::int64_t node = pairs_.nodes_[i];
  m.x = pairs_.position(u_, node);
  if (pairs_.rigid_)
  {
    const auto g = gap_and_normal<double>(*pairs_.rigid_, obstacle_, m.x);
    m.gap = g.gap;
    m.normal = g.normal;
    return m;
  }
  if (not projector_)
    throw std::logic_error("a deformable master without a projector");
  const Surface& master = pairs_.master_;
  const auto meets = [&](std::int64_t number, const Local& xi, double gap, const Vec<double>& normal, const auto& f)
  {
    const Facet& facet = master.facets[number];
    m.facet = number;
    m.xi = xi;
    m.width = diameter(facet);
    m.gap = gap;
    m.normal = normal;
    m.masters = facet.nodes;
    m.phi.assign(f.N.begin(), f.N.begin() + std::ptrdiff_t(facet.nodes.size()));
  };
  Foot foot = projector_->nearest(m.x, normals_.at(node));
  if (foot.facet < 0)
    return m;
  if (not closed)
  {
    const Facet& facet = master.facets[foot.facet];
    Vec<double> relative = pairs_.at(moved, node);
    const auto f = facet_functions<double>(master.type, master.degree, foot.xi);
    for (std::size_t j = 0; j < facet.nodes.size(); ++j)
      relative = relative - f.N[j] * pairs_.at(moved, facet.nodes[j]);
    if (foot.distance > std::max(pairs_.search_distance_, 2 * norm(relative)))
      return m;
  }
  if (foot.dim < master.tdim() and projector_->on_rim(foot))
  {
    const Facet& facet = master.facets[foot.facet];
    const auto s = spot<double>(master, facet, gather(master, facet, u_), foot.xi);
    const Vec<double> d = m.x - s.x, n = s.normal();
    const double depth = dot(d, n), far = 0.05 * diameter(facet);
    if (norm(d - depth * n) < far)
    {
      meets(foot.facet, foot.xi, depth, n, s.f);
      m.on_facet = true;
      return m;
    }
    m.beside = true;
    m.below = depth < 0;
  }
  foot = projector_->closest(m.x, normals_.at(node));
  if (foot.facet < 0)
    return m;
  const Facet& facet = master.facets[foot.facet];
  const auto projection = projector_->follow<double>(foot, gather(master, facet, u_), m.x);
  meets(foot.facet, foot.xi, projection.gap, projection.normal, projection.f);
  m.on_facet = foot.dim == master.tdim() or foot.distance <= 1e-10 * diameter(facet);
  return m;
}

Approach::Approach(const NodePairs& pairs, const Vector& end, const Vector& moved, int level, double dt)
    : pairs_(pairs), end_(end), moved_(moved), level_(level), dt_(dt), smallest_(pairs.smallest_diameter()),
      last_(at(1)), farthest_(0)
{
  for (Eigen::Index k = 0; k < moved.size(); k += pairs.gdim())
    farthest_ = std::max(farthest_, moved.segment(k, pairs.gdim()).norm());
}

Configuration Approach::at(double theta) const
{
  return {pairs_, end_ - (1 - theta) * moved_, pairs_.obstacle_before(level_, 1 - theta)};
}

Meeting Approach::departure(std::size_t i, bool closed) const
{
  if (not first_)
    first_.emplace(pairs_, end_ - moved_, pairs_.obstacle_before(level_, 1));
  return first_->meet(i, moved_, closed);
}

Meeting Approach::arrival(std::size_t i, bool closed, bool marked) const
{
  Meeting now = last_.meet(i, moved_, closed);
  const std::int64_t node = pairs_.nodes()[i];
  const Vec<double> obstacle = pairs_.master_moved(level_);
  // No node moves by more than this against a point of the master (shape functions of degree 2 add up to 5 / 3).
  if (marked or norm(pairs_.at(moved_, node)) + 2 * farthest_ + norm(obstacle) <= smallest_ / 2)
    return now;
  const Meeting before = departure(i, closed);
  if (not std::isfinite(before.gap))
    return now;
  const Vec<double> way = pairs_.relative(moved_, obstacle, node, before);
  if (norm(way) <= smallest_ / 2 or not(before.gap > 0 or closed))
    return now;

  const auto through = [](const Meeting& m) { return m.gap < 0 and not m.beside; };
  const int parts = int(std::min(1000.0, std::ceil(2 * norm(way) / smallest_)));
  for (int part = 1; part <= parts; ++part)
  {
    const double theta = double(part) / parts;
    const Meeting met = part == parts ? now : at(theta).meet(i, moved_, closed);
    if (not through(met))
      continue;
    const double come = dot(met.normal, way);
    const double width = std::isfinite(met.width) ? met.width : smallest_;
    if (-come > width and not closed)
      refuse(node, before.x, -come / width);
    const double gap = met.gap + (1 - theta) * come;
    if ((through(now) and now.gap < gap + width / 2) or not(gap < 0))
      return now;
    Meeting held = met;
    held.x = now.x;
    held.gap = gap;
    return held;
  }
  return now;
}

void Approach::refuse(std::int64_t node, const Vec<double>& x, double facets) const
{
  std::ostringstream message;
  message << "node " << node << " at (" << x[0] << ", " << x[1] << ", " << x[2] << ") goes through the master by "
          << facets << " facets in one step: take steps of " << 0.9 / facets * dt_ << " or less";
  throw std::runtime_error(message.str());
}
} // namespace impact_reference
