// SPDX-License-Identifier: MIT
#include "GeneralContact.h"
#include "contact_springs.h"
#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>

namespace impact_reference
{
namespace
{
// Parts of the height of the cells: a spring begins no deeper without having been in front, and no deeper at all.
constexpr double shallow = 0.05, deepest = 0.5;
// Facets that face each other, and those to which a closed node may slide: cosine of the angle between normals.
constexpr double facing = -0.1, sliding = 0.6;
constexpr double least_sine_of_planes = 0.3;
constexpr double going_on = 0.94;
constexpr double sharp = 0.94, least_sine = 0.1, slack = 0.02, inside_factor = 2, cells_behind = 3, equally_near = 1e-9;

// A node that is between the corners of a triangle or on its rim: weights of the three.
std::array<double, 3> on_segment(const Vec<double>& a, const Vec<double>& b, const Vec<double>& x)
{
  const double s = std::clamp(dot(x - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
  return {1 - s, s, 0};
}

std::array<double, 3> on_triangle(const std::array<Vec<double>, 3>& y, const Vec<double>& x)
{
  const Vec<double> area = cross(y[1] - y[0], y[2] - y[0]);
  std::array<double, 3> best;
  for (int k = 0; k < 3; ++k)
    best[k] = dot(cross(y[(k + 1) % 3] - x, y[(k + 2) % 3] - x), area) / dot(area, area);
  if (*std::min_element(best.begin(), best.end()) > 0)
    return best;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k)
  {
    const auto w = on_segment(y[k], y[(k + 1) % 3], x);
    const double distance = norm(x - w[0] * y[k] - w[1] * y[(k + 1) % 3]);
    if (not(distance < least))
      continue;
    least = distance;
    best[k] = w[0];
    best[(k + 1) % 3] = w[1];
    best[(k + 2) % 3] = 0;
  }
  return best;
}
} // namespace

GeneralContact::GeneralContact(const Model& model, Surface outside, NodalStiffness stiffness, const Vector& mass,
                               double friction)
    : model_(model), outside_(std::move(outside)), stiffness_(std::move(stiffness)), mass_(mass), friction_(friction)
{
  if (outside_.degree != 1 or outside_.geometry_degree != 1)
    throw std::invalid_argument("contact without pairs is for straight facets of degree 1");
  areas_ = nodal_areas(outside_);
  for (int f = 0; f < int(outside_.facets.size()); ++f)
  {
    const Facet& facet = outside_.facets[f];
    const double height = height_behind(model_, outside_, facet);
    for (std::size_t k = 0; k < facet.nodes.size(); ++k)
    {
      const std::int64_t node = facet.nodes[k];
      facets_[node].push_back(f);
      rest_[node] = get(facet.X, std::int64_t(k));
      height_[node] = height_.contains(node) ? std::min(height_[node], height) : height;
    }
  }
  for (const auto& [node, area] : areas_)
    nodes_.push_back(node);
  find_bodies();
  if (model_.gdim() == 3)
    find_edges();
  clear();
}

void GeneralContact::clear()
{
  const double dissipated = answer_.dissipated, absorbed = answer_.absorbed;
  const auto count = std::int64_t(nodes_.size());
  const Vector zero = Vector::Zero(model_.num_dofs());
  const Matrix rows = Matrix::Zero(count, model_.gdim());
  answer_ = {zero,
             zero,
             {},
             {},
             Vector::Constant(count, std::numeric_limits<double>::infinity()),
             rows,
             rows,
             std::vector<ContactStatus>(count, ContactStatus::open)};
  answer_.dissipated = dissipated;
  answer_.absorbed = absorbed;
}

void GeneralContact::find_bodies()
{
  // Cells that share nodes belong to one body; its number is that of its first node.
  body_.resize(model_.field().points.rows());
  std::iota(body_.begin(), body_.end(), 0);
  for (bool changed = true; changed;)
  {
    changed = false;
    for (std::int64_t c = 0; c < model_.num_cells(); ++c)
    {
      const auto all = model_.cell_nodes(c);
      std::int64_t least = body_[all[0]];
      for (auto node : all)
        least = std::min(least, body_[node]);
      for (auto node : all)
      {
        changed |= body_[node] != least;
        body_[node] = least;
      }
    }
  }
}

void GeneralContact::find_edges()
{
  std::map<std::set<std::int64_t>, std::vector<std::pair<int, int>>> sides;
  for (int f = 0; f < int(outside_.facets.size()); ++f)
  {
    const auto& nodes = outside_.facets[f].nodes;
    for (int k = 0; k < int(nodes.size()); ++k)
      sides[{nodes[k], nodes[(k + 1) % nodes.size()]}].push_back({f, k});
  }
  for (const auto& [ends, places] : sides)
    if (places.size() == 2)
    {
      const auto& [f, k] = places[0];
      const auto& nodes = outside_.facets[f].nodes;
      edges_.push_back({{nodes[k], nodes[(k + 1) % nodes.size()]}, {f, places[1].first}, {k, places[1].second}});
    }
  const Vector rest = Vector::Zero(model_.num_dofs());
  // Edges that go on beyond their ends, sharp and straight in the undeformed body.
  const auto is_sharp = [&](const Edge& e)
  { return dot(side_normal(e.facets[0], e.sides[0], rest), side_normal(e.facets[1], e.sides[1], rest)) < sharp; };
  const auto outward = [&](const Edge& e, int end)
  { return unit(rest_.at(e.nodes[end]) - rest_.at(e.nodes[1 - end])); };
  for (Edge& e : edges_)
    for (int end = 0; end < 2 and is_sharp(e); ++end)
    {
      double most = going_on;
      for (std::size_t j = 0; j < edges_.size(); ++j)
        for (int other = 0; other < 2; ++other)
          if (edges_[j].nodes[other] == e.nodes[end] and edges_[j].nodes[1 - other] != e.nodes[1 - end])
            if (const double along = -dot(outward(e, end), outward(edges_[j], other));
                along > most and is_sharp(edges_[j]))
            {
              most = along;
              e.goes_on[end] = int(j);
            }
    }
  for (std::size_t i = 0; i < edges_.size(); ++i)
    for (std::size_t j = i + 1; j < edges_.size(); ++j)
    {
      const Edge &a = edges_[i], &b = edges_[j];
      if (std::set{a.nodes[0], a.nodes[1], b.nodes[0], b.nodes[1]}.size() < 4)
        continue;
      const Crossing found = cross_edges(a, b, rest);
      if (not(body_[a.nodes[0]] == body_[b.nodes[0]] and found.valid and found.gap < 0)) // the far side of a thin body
        edge_springs_[{i, j}] = {};
    }
}

Vec<double> GeneralContact::at(const Vector& field, std::int64_t node) const
{
  Vec<double> out;
  for (int c = 0; c < model_.gdim(); ++c)
    out[c] = field(model_.gdim() * node + c);
  return out;
}

GeneralContact::Corners GeneralContact::corners(int facet, const Vector& u) const
{
  Corners out;
  for (auto node : outside_.facets[facet].nodes)
    out.push_back(rest_.at(node) + at(u, node));
  return out;
}

Vec<double> GeneralContact::side_normal(int facet, int side, const Vector& u) const
{
  const Corners y = corners(facet, u);
  if (y.size() == 2)
    return unit(cross(y[1] - y[0], {0, 0, 1}));
  if (y.size() == 3)
    return unit(cross(y[1] - y[0], y[2] - y[0]));
  const Vec<double> middle = 0.25 * (y[0] + y[1] + y[2] + y[3]);
  return unit(cross(y[(side + 1) % 4] - y[side], middle - y[side]));
}

GeneralContact::Closest GeneralContact::closest(int facet, const Vec<double>& x, const Vector& u) const
{
  const Corners y = corners(facet, u);
  const int n = int(y.size());
  Closest best;
  if (n == 2)
  {
    const auto w = on_segment(y[0], y[1], x);
    best.weights = {w[0], w[1]};
    best.away = x - w[0] * y[0] - w[1] * y[1];
    best.distance = norm(best.away);
    best.n = side_normal(facet, 0, u);
    best.flat = w[0] > 0 and w[1] > 0;
    if (not best.flat)
      best.ends = {w[0] > 0 ? 0 : 1};
    return best;
  }
  for (int j = 0; j < (n == 4 ? 4 : 1); ++j)
  {
    const int of[2] = {j, (j + 1) % n};
    const Vec<double> third = n == 4 ? 0.25 * (y[0] + y[1] + y[2] + y[3]) : y[2];
    const auto w = on_triangle({y[of[0]], y[of[1]], third}, x);
    const Vec<double> away = x - w[0] * y[of[0]] - w[1] * y[of[1]] - w[2] * third;
    if (not(norm(away) < best.distance))
      continue;
    best = {norm(away), away, unit(cross(y[of[1]] - y[of[0]], third - y[of[0]])), std::vector<double>(n, 0.0),
            true,       {}};
    for (int k = 0; k < 2; ++k)
      best.weights[of[k]] += w[k];
    for (int k = 0; k < n; ++k)
      best.weights[k] += n == 4 ? 0.25 * w[2] : k == 2 ? w[2] : 0.0;
    best.flat = w[0] > 0 and w[1] > 0 and w[2] > 0;
    if (n == 3 ? not best.flat : w[2] == 0)
      for (int k = 0; k < n; ++k)
        if (best.weights[k] > 0)
          best.ends.push_back(k);
  }
  return best;
}

// Is a point that is closest to a side or a corner behind all facets there, and no closer to them?
bool GeneralContact::inside(int facet, const Closest& found, const Vec<double>& x, const Vector& u) const
{
  std::vector<std::int64_t> ends;
  for (int k : found.ends)
    ends.push_back(outside_.facets[facet].nodes[k]);
  for (int other : facets_.at(ends[0]))
  {
    const auto& nodes = outside_.facets[other].nodes;
    const int n = int(nodes.size());
    int side = int(std::find(nodes.begin(), nodes.end(), ends[0]) - nodes.begin());
    if (ends.size() == 2)
    {
      if (nodes[(side + n - 1) % n] == ends[1])
        side = (side + n - 1) % n;
      else if (nodes[(side + 1) % n] != ends[1])
        continue;
    }
    if (other == facet)
      continue;
    const double distance = closest(other, x, u).distance;
    if (not(dot(found.away, side_normal(other, side, u)) < 0) or
        distance * distance < (1 - equally_near) * found.distance * found.distance)
      return false;
  }
  return true;
}

bool GeneralContact::faces(std::int64_t node, const Vec<double>& n, const Vector& u) const
{
  for (int own : facets_.at(node))
  {
    const auto& nodes = outside_.facets[own].nodes;
    const int corner = int(std::find(nodes.begin(), nodes.end(), node) - nodes.begin());
    if (dot(side_normal(own, corner, u), n) < facing)
      return true;
  }
  return false;
}

// Is the facet the far side of the node's own body?
bool GeneralContact::far_side(std::int64_t node, int facet) const
{
  const auto& nodes = outside_.facets[facet].nodes;
  if (body_[node] != body_[nodes[0]])
    return false;
  const Closest found = closest(facet, rest_.at(node), Vector::Zero(model_.num_dofs()));
  const double height = height_.at(nodes[0]);
  return dot(found.away, found.n) < -1e-6 * height and found.distance < cells_behind * height;
}

double GeneralContact::compliance(std::int64_t node, double dt) const
{
  const double r = 1 / (0.9 * 0.9) - 1;
  return 1 / std::min(stiffness_.at(node), 4 * r * mass_(model_.gdim() * node) / (dt * dt));
}

// The plane of a facet beyond the side or corner that is closest to a point: the point's foot on it.
void GeneralContact::go_on(Candidate& c, const Closest& found, const Vec<double>& x, const Vector& u) const
{
  const Corners y = corners(c.facet, u);
  const int n = int(y.size());
  const Vec<double> closest_point = x - found.away;
  int j = found.ends[0];
  if (found.ends.size() == 2 and (j + 1) % n != found.ends[1])
    j = found.ends[1];
  c.weights.assign(n, 0.0);
  if (n == 2)
  {
    c.n = side_normal(c.facet, 0, u);
    c.weights[1] = dot(x - y[0], y[1] - y[0]) / dot(y[1] - y[0], y[1] - y[0]);
    c.weights[0] = 1 - c.weights[1];
  }
  else
  {
    // At a corner the plane of the sides that meet there, of a quadrilateral's side that of the mean of its corners.
    const bool mean = n == 4 and found.ends.size() == 2;
    const int next = (j + 1) % n, last = (j + n - 1) % n;
    const Vec<double> third = mean ? 0.25 * (y[0] + y[1] + y[2] + y[3]) : y[last];
    c.n = unit(cross(y[next] - y[j], third - y[j]));
    Eigen::Matrix3d A;
    Eigen::Vector3d rhs;
    for (int k = 0; k < 3; ++k)
    {
      A(k, 0) = y[j][k] - third[k];
      A(k, 1) = y[next][k] - third[k];
      A(k, 2) = c.n[k];
      rhs(k) = x[k] - third[k];
    }
    const Eigen::Vector3d w = A.partialPivLu().solve(rhs);
    const double rest = 1 - w(0) - w(1);
    c.weights[j] += w(0);
    c.weights[next] += w(1);
    for (int k = 0; k < n; ++k)
      c.weights[k] += mean ? 0.25 * rest : k == last ? rest : 0.0;
  }
  c.gap = dot(c.n, x - y[j]);
  c.second = x - c.gap * c.n;
  c.excess = c.second - closest_point;
}

// All facets near a node, whatever its springs.
std::vector<GeneralContact::Candidate> GeneralContact::candidates(std::int64_t node, const ContactStep& step) const
{
  std::vector<Candidate> out;
  const Vec<double> x = rest_.at(node) + at(step.u, node);
  double size = 0;
  for (int c = 0; c < 3; ++c)
    size += std::abs(rest_.at(node)[c]) + std::abs(at(step.u, node)[c]);
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * size;
  for (int f = 0; f < int(outside_.facets.size()); ++f)
  {
    const auto& nodes = outside_.facets[f].nodes;
    Candidate c;
    c.facet = f;
    c.height = std::numeric_limits<double>::infinity();
    for (auto corner : nodes)
      c.height = std::min(c.height, height_.at(corner));
    // Beyond this distance nothing can touch: facets that are not near cost no more than this comparison.
    const double reach = 3 * c.height + 2.1 * fastest_ + rounding;
    if (norm(x - rest_.at(nodes[0]) - at(step.u, nodes[0])) > reach + longest_)
      continue;
    if (std::find(nodes.begin(), nodes.end(), node) != nodes.end())
      continue;
    const Closest found = closest(f, x, step.u);
    if (found.distance > reach or far_side(node, f))
      continue;
    c.facet_n = found.n;
    c.inside = found.ends.empty();
    const bool front = not(dot(found.away, found.n) < 0);
    c.beyond = not c.inside and (front or not inside(f, found, x, step.u));
    if (c.beyond)
      go_on(c, found, x, step.u);
    else
    {
      const double far = found.distance <= rounding ? 0.0 : found.distance;
      c.gap = front ? (found.flat ? dot(found.away, found.n) : far) : -far;
      c.n = found.flat or far == 0 ? found.n : ((front ? 1 : -1) / found.distance) * found.away;
      c.weights = found.weights;
      c.second = x - found.away;
    }
    out.push_back(c);
  }
  return out;
}

bool GeneralContact::may_begin(const Candidate& c, std::int64_t node, const ContactStep& step) const
{
  if (-c.gap <= shallow * c.height)
    return true;
  const Closest last = closest(c.facet, rest_.at(node) + at(step.u, node) - at(step.moved, node), step.u - step.moved);
  const double before = dot(last.away, last.n);
  return -c.gap <= deepest * c.height and before > -shallow * c.height and (last.ends.empty() or before > 0);
}

// Two facets of a corner that is open: each one has a corner before the other one's plane.
bool GeneralContact::in_corner(const Candidate& a, const Candidate& b, const Vec<double>& x, const Vector& u) const
{
  for (const auto& [one, other] : {std::pair(&a, &b), std::pair(&b, &a)})
  {
    double most = 0;
    for (const Vec<double>& y : corners(one->facet, u))
      most = std::max(most, other->gap + dot(y - x, other->n));
    if (most <= shallow * one->height)
      return false;
  }
  return true;
}

// Add the facet for a spring that is closed, or without a slot for one that may begin, to those that were chosen.
bool GeneralContact::pick(int slot, bool beyond, std::int64_t node, const NodeSprings& springs,
                          const std::vector<Candidate>& all, const ContactStep& step,
                          std::vector<Candidate>& chosen) const
{
  const Vec<double> x = rest_.at(node) + at(step.u, node);
  const bool closed = slot >= 0;
  const auto fits = [&](const Candidate& c)
  {
    if (c.beyond != beyond)
      return false;
    for (const Candidate& other : chosen)
      if (other.facet == c.facet or (not closed and dot(c.facet_n, other.n) >= sliding))
        return false;
    for (int s = 0; s < springs_per_node; ++s)
    {
      if (not springs[s].closed or s == slot)
        continue;
      const double other = dot(c.facet_n, springs[s].n);
      if (not closed and other >= sliding)
        return false;
      if (closed and
          (other > dot(c.facet_n, springs[slot].n) or (other == dot(c.facet_n, springs[slot].n) and s < slot)))
        return false;
    }
    if (not closed)
    {
      if (not(c.gap < fastest_) or not faces(node, c.facet_n, step.u))
        return false;
      for (const Candidate& other : chosen)
        if (not in_corner(c, other, x, step.u))
          return false;
      return not(beyond and -c.gap > deepest * c.height) and (c.gap >= 0 or may_begin(c, node, step));
    }
    const double rounding = 1e-15 * (1 + norm(x));
    return dot(c.facet_n, springs[slot].n) >= sliding and - c.gap <= c.height and
           std::abs(c.gap - springs[slot].gap) <= 2.1 * fastest_ + rounding;
  };
  // As a facet ends where the plane of another one begins.
  const auto ends_at = [&](const Candidate& c, const Vec<double>& n, double gap)
  {
    const double cosine = dot(c.n, n), sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    if (cosine >= sliding or sine < least_sine_of_planes)
      return false;
    const double along = dot(c.excess, cosine * c.n - n) / sine, size = norm(c.excess);
    return along >= size / 2 and size <= std::max(0.0, cosine * c.gap - gap) / sine + shallow * c.height;
  };
  std::vector<Candidate> left;
  for (const Candidate& c : all)
    if (fits(c))
      left.push_back(c);
  const Candidate* best = nullptr;
  for (const Candidate& c : left)
  {
    bool counts = not beyond;
    for (int s = 0; beyond and closed and s < springs_per_node; ++s)
      counts = counts or (s != slot and springs[s].closed and ends_at(c, springs[s].n, springs[s].gap));
    for (const Candidate& other : chosen)
      if (beyond and (not closed or not springs[other.slot].closed))
        counts = counts or ends_at(c, other.n, other.gap);
    for (const Candidate& other : left)
      if (beyond and not closed and chosen.empty() and other.facet != c.facet)
        counts = counts or
                 (ends_at(c, other.n, other.gap) and ends_at(other, c.n, c.gap) and in_corner(c, other, x, step.u));
    if (not counts)
      continue;
    // The nearest counts, of equally near ones the first; of an open node what is behind before what is in front.
    const bool nearer = best == nullptr or std::abs(c.gap) < (1 - equally_near) * std::abs(best->gap);
    if (best == nullptr or closed or (c.gap < 0) == (best->gap < 0) ? nearer : c.gap < 0)
      best = &c;
  }
  if (best == nullptr)
    return false;
  chosen.push_back(*best);
  chosen.back().slot = slot;
  return true;
}

// Facets that a node's springs act on in a step.
std::vector<GeneralContact::Candidate> GeneralContact::choose(std::int64_t node, const NodeSprings& springs,
                                                              const ContactStep& step) const
{
  std::vector<Candidate> chosen;
  const std::vector<Candidate> all = candidates(node, step);
  const auto begin = [&](bool beyond)
  {
    for (int s = 0; s < springs_per_node; ++s)
    {
      const auto is_there = [s](const Candidate& c) { return c.slot == s; };
      if (springs[s].closed or std::any_of(chosen.begin(), chosen.end(), is_there))
        continue;
      if (not pick(-1, beyond, node, springs, all, step, chosen))
        return;
      chosen.back().slot = s;
    }
  };
  std::vector<int> lost;
  for (int s = 0; s < springs_per_node; ++s)
    if (springs[s].closed and not pick(s, false, node, springs, all, step, chosen))
      lost.push_back(s);
  begin(false);
  for (int s : lost)
    pick(s, true, node, springs, all, step, chosen);
  begin(true);
  return chosen;
}

GeneralContact::Meeting GeneralContact::meet(std::int64_t node, const Candidate& c, const ContactStep& step) const
{
  Meeting m;
  m.gap = c.gap;
  m.n = c.n;
  m.first = rest_.at(node) + at(step.u, node);
  m.second = c.second;
  m.shares = {{node, 1.0}};
  double others = 0;
  const auto& nodes = outside_.facets[c.facet].nodes;
  for (std::size_t k = 0; k < nodes.size(); ++k)
  {
    m.shares.push_back({nodes[k], -c.weights[k]});
    m.turning.push_back(nodes[k]);
    others +=
        std::abs(c.weights[k]) * std::max(1.0, areas_.at(nodes[k]) / areas_.at(node)) * compliance(nodes[k], step.dt);
  }
  m.stiffness = 0.5 / (compliance(node, step.dt) + others);
  return m;
}

// Springs of a node: what they are together is no stiffer than one of them.
void GeneralContact::advance(std::int64_t node, std::int64_t place, const ContactStep& step)
{
  NodeSprings& springs = springs_[node];
  std::array<Meeting, springs_per_node> all;
  std::array<bool, springs_per_node> presses{};
  for (const Candidate& c : choose(node, springs, step))
  {
    Meeting& m = all[c.slot] = meet(node, c, step);
    double r = 0;
    for (const auto& [one, w] : m.shares)
      r += w * dot(m.n, at(step.moved, one));
    const double offset = springs[c.slot].closed ? springs[c.slot].offset
                          : step.n == 0          ? 0.0
                                                 : std::max(0.0, r - m.gap);
    presses[c.slot] = overlap(m.gap + offset, r) > 0;
  }
  int strongest = 0;
  std::array<ContactStatus, springs_per_node> status;
  for (int s = 0; s < springs_per_node; ++s)
  {
    double along = 1;
    for (int other = 0; other < springs_per_node; ++other)
      if (other != s and presses[s] and presses[other])
        along += std::abs(dot(all[s].n, all[other].n));
    all[s].stiffness /= along;
    status[s] = advance(springs[s], all[s], step);
    const Spring& best = springs[strongest];
    if (springs[s].closed and (not best.closed or springs[s].normal > best.normal))
      strongest = s;
  }
  const Spring& shown = springs[strongest];
  answer_.status[place] = status[strongest];
  if (shown.closed)
    answer_.gap(place) = all[strongest].gap;
  put(answer_.traction, place, shown.t);
  put(answer_.slip, place, shown.slip);
}

GeneralContact::Crossing GeneralContact::cross_edges(const Edge& a, const Edge& b, const Vector& u, bool lines) const
{
  Crossing out;
  const Edge* edges[2] = {&a, &b};
  Vec<double> start[2], along[2];
  for (int k = 0; k < 2; ++k)
  {
    const auto& nodes = edges[k]->nodes;
    start[k] = rest_.at(nodes[0]) + at(u, nodes[0]);
    along[k] = rest_.at(nodes[1]) + at(u, nodes[1]) - start[k];
  }
  const Vec<double> common = cross(along[0], along[1]);
  if (norm(common) <= least_sine * norm(along[0]) * norm(along[1]))
    return out;
  out.n = unit(common);
  // start[0] + at[0] along[0] - start[1] - at[1] along[1] is along n.
  Eigen::Matrix3d A;
  Eigen::Vector3d rhs;
  for (int c = 0; c < 3; ++c)
  {
    A(c, 0) = along[0][c];
    A(c, 1) = -along[1][c];
    A(c, 2) = -out.n[c];
    rhs(c) = start[1][c] - start[0][c];
  }
  const Eigen::Vector3d solution = A.partialPivLu().solve(rhs);
  out.gap = solution(2);
  for (int k = 0; k < 2; ++k)
  {
    out.at[k] = solution(k);
    out.points[k] = start[k] + out.at[k] * along[k];
  }
  if (not lines and std::min({out.at[0], out.at[1], 1 - out.at[0], 1 - out.at[1]}) <= 0)
    return out;
  const Vec<double> outward = side_normal(b.facets[0], b.sides[0], u) + side_normal(b.facets[1], b.sides[1], u);
  if (dot(out.n, outward) < 0)
  {
    out.n = -1.0 * out.n;
    out.gap = -out.gap;
  }
  for (int k = 0; k < 2; ++k)
  {
    Vec<double> n[2], into[2];
    for (int side = 0; side < 2; ++side)
    {
      n[side] = side_normal(edges[k]->facets[side], edges[k]->sides[side], u);
      into[side] = unit(cross(n[side], (side == 0 ? 1.0 : -1.0) * along[k]));
    }
    if (dot(n[0], n[1]) >= sharp or dot(into[0], n[1]) > 0)
      return out;
    for (const Vec<double>& way : into)
      if ((k == 0 ? -1 : 1) * dot(out.n, way) > slack)
        return out;
  }
  out.valid = true;
  return out;
}

// As cross_edges; where an edge goes on as another one it may be left by as much as both are behind each other.
GeneralContact::Crossing GeneralContact::cross_beyond(const Edge& a, const Edge& b, const Vector& u) const
{
  Crossing out = cross_edges(a, b, u, true);
  for (int k = 0; k < 2; ++k)
  {
    const Edge& edge = k == 0 ? a : b;
    const double length =
        norm(rest_.at(edge.nodes[1]) + at(u, edge.nodes[1]) - rest_.at(edge.nodes[0]) - at(u, edge.nodes[0]));
    for (int end = 0; end < 2; ++end)
    {
      const double beyond = length * (end == 0 ? -out.at[k] : out.at[k] - 1);
      if (beyond >= 0 and (edge.goes_on[end] < 0 or beyond > -out.gap))
        out.valid = false;
    }
  }
  return out;
}

// Pairs of edges as which these go on at the nearer ends.
std::vector<std::pair<const GeneralContact::Edge*, const GeneralContact::Edge*>>
GeneralContact::beside(const Edge& a, const Edge& b, const Crossing& now) const
{
  const int on[2] = {a.goes_on[now.at[0] < 0.5 ? 0 : 1], b.goes_on[now.at[1] < 0.5 ? 0 : 1]};
  std::vector<std::pair<const Edge*, const Edge*>> out;
  if (on[0] >= 0)
    out.push_back({&edges_[on[0]], &b});
  if (on[1] >= 0)
    out.push_back({&a, &edges_[on[1]]});
  if (on[0] >= 0 and on[1] >= 0)
    out.push_back({&edges_[on[0]], &edges_[on[1]]});
  return out;
}

GeneralContact::Meeting GeneralContact::meet(const Edge& a, const Edge& b, const Spring& spring,
                                             const ContactStep& step) const
{
  Crossing now = spring.closed ? cross_beyond(a, b, step.u) : cross_edges(a, b, step.u);
  Meeting m;
  if (not now.valid)
    return m;
  if (std::min({now.at[0], now.at[1], 1 - now.at[0], 1 - now.at[1]}) <= 0)
    for (const auto& [first, second] : beside(a, b, now))
      if (cross_edges(*first, *second, step.u).valid)
        return m;
  const std::int64_t nodes[4] = {a.nodes[0], a.nodes[1], b.nodes[0], b.nodes[1]};
  if (now.gap < 0)
  {
    double height = std::numeric_limits<double>::infinity(), size = 0;
    for (int k = 0; k < 4; ++k)
    {
      height = std::min(height, height_.at(nodes[k]));
      const Vec<double> x = rest_.at(nodes[k]) + at(step.u, nodes[k]);
      if (k < 2)
        size += std::abs(x[0]) + std::abs(x[1]) + std::abs(x[2]);
    }
    for (int k = 0; k < 2 and not(spring.closed and spring.offset == 0); ++k)
    {
      const Vec<double> along =
          rest_.at(nodes[2 * k + 1]) + at(step.u, nodes[2 * k + 1]) - rest_.at(nodes[2 * k]) - at(step.u, nodes[2 * k]);
      const auto& goes_on = (k == 0 ? a : b).goes_on;
      const double from = now.at[k] * norm(along), to = (1 - now.at[k]) * norm(along);
      if ((goes_on[0] < 0 and from <= -inside_factor * now.gap) or (goes_on[1] < 0 and to <= -inside_factor * now.gap))
        return m;
    }
    if (now.gap > -4 * std::numeric_limits<double>::epsilon() * size)
      now.gap = 0;
    for (const auto& [first, second] : beside(a, b, now))
      if (not spring.closed and -now.gap < height)
      {
        const Crossing last = cross_beyond(*first, *second, step.u - step.moved);
        if (not last.valid or last.gap >= 0 or std::abs(now.gap - last.gap) > 2.1 * fastest_ or
            dot(now.n, last.n) < sliding)
          continue;
        if (cross_edges(*first, *second, step.u).valid)
          return {};
        m.follows = true;
      }
    if (not spring.closed and not m.follows and -now.gap > shallow * height)
    {
      const Crossing before = cross_edges(a, b, step.u - step.moved);
      if (-now.gap >= deepest * height or not before.valid or before.gap <= -shallow * height)
        return m;
    }
  }
  if (spring.closed and dot(now.n, spring.n) < sliding)
    return m;
  double sum = 0;
  for (int k = 0; k < 4; ++k)
  {
    const double w = k % 2 == 0 ? 1 - now.at[k / 2] : now.at[k / 2];
    m.shares.push_back({nodes[k], k < 2 ? w : -w});
    m.turning.push_back(nodes[k]);
    sum += std::abs(w) * compliance(nodes[k], step.dt);
  }
  m.gap = now.gap;
  m.n = now.n;
  m.first = now.points[0];
  m.second = now.points[1];
  m.stiffness = 0.5 / sum;
  return m;
}

// Force of a spring in a step, its energies, and what it keeps.
ContactStatus GeneralContact::advance(Spring& spring, const Meeting& m, const ContactStep& step)
{
  const Spring last = spring;
  const bool met = std::isfinite(m.gap);
  const auto sum_of = [&](const std::vector<Share>& shares)
  {
    Vec<double> sum;
    for (const auto& [node, w] : shares)
      sum = sum + w * at(step.moved, node);
    return sum;
  };
  // Rotation and moments are those of the nodes about their mean.
  const Vec<double> lever = m.second - m.first;
  std::vector<Vec<double>> y;
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  Vec<double> moved = met ? sum_of(m.shares) : Vec<double>{};
  const auto turn_of = [&](const Vec<double>& moment)
  {
    if (model_.gdim() == 2)
      return Vec<double>{0, 0, moment[2] / J(2, 2)};
    const Eigen::Vector3d w = J.partialPivLu().solve(Eigen::Vector3d(moment[0], moment[1], moment[2]));
    return Vec<double>{w(0), w(1), w(2)};
  };
  if (met and friction_ > 0 and not outside_.axisymmetric)
  {
    Vec<double> middle, moment;
    const double part = 1 / double(m.turning.size());
    for (auto node : m.turning)
      middle = middle + part * (rest_.at(node) + at(step.u, node));
    for (auto node : m.turning)
    {
      y.push_back(rest_.at(node) + at(step.u, node) - middle);
      moment = moment + cross(y.back(), at(step.moved, node));
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          J(i, j) += (i == j ? dot(y.back(), y.back()) : 0.0) - y.back()[i] * y.back()[j];
    }
    moved = moved + cross(turn_of(moment), lever);
  }
  const double r = met ? dot(m.n, moved) : 0;
  if (met and not last.closed)
    spring.offset = step.n == 0 or m.follows ? 0.0 : std::max(0.0, r - m.gap);
  const double gap = m.gap + spring.offset, delta = met ? overlap(gap, r) : 0;
  spring.closed = delta > 0;
  spring.gap = m.gap;

  // What the last force has done in this step, at its points and along its normal.
  Vec<double> there = last.closed ? sum_of(last.shares) : Vec<double>{};
  double turned = 0;
  for (const auto& [node, f] : last.turning)
    turned += dot(f, at(step.moved, node));
  const double k = spring.closed ? m.stiffness : last.stiffness;
  double stored = 0;
  if (last.closed)
    stored = last.normal * last.normal / (2 * last.stiffness);
  else if (spring.closed)
  {
    stored = k * std::pow(std::max(0.0, r - gap), 2) / 2;
    answer_.absorbed -= m.follows ? stored : 0.0; // what the pair before it has given up
  }
  const double a = last.e + stored - last.normal * dot(last.n, there) / 2;
  const double b = dot(last.t, last.t) / (2 * last.stiffness) - (dot(last.t, there) + turned) / 2;
  spring.shares.clear();
  spring.turning.clear();
  spring.normal = 0;
  spring.t = {};
  if (not spring.closed)
  {
    spring.slip = {};
    if (last.closed)
    {
      answer_.absorbed += a - last.e;
      spring.e = std::min(0.0, a);
      answer_.dissipated += b;
      spring.q = std::min(0.0, last.q + b);
    }
    return ContactStatus::open;
  }
  spring.stiffness = k;
  spring.n = m.n;
  spring.shares = m.shares;
  spring.normal = normal_force(k, delta, gap, r, a, stored);
  spring.e = a - spring.normal * (r + spring.normal / k) / 2;
  answer_.absorbed += spring.e - last.e;
  answer_.stored += spring.normal * spring.normal / (2 * k);
  ContactStatus status = ContactStatus::slip;
  if (friction_ > 0)
  {
    const double bound = friction_ * spring.normal;
    const Vec<double> t_rotated = rotated(last.t, m.n), across = moved - r * m.n;
    const Vec<double> along = part_below(gap, r) * across, trial = t_rotated - k * along;
    spring.t = cut_to(trial, bound);
    bool slips = norm(trial) > bound;
    const double round_off = 1e-12 * (dot(last.t, last.t) / (2 * last.stiffness) + dot(spring.t, spring.t) / k);
    if (last.q + tangential_change(spring.t, k, across, b) < -round_off)
    {
      slips = true;
      const Vec<double> centre = (-k / 2) * across;
      const double radius = std::sqrt(std::max(0.0, dot(centre, centre) + 2 * k * (last.q + b)));
      spring.t = cut_to(centre + cut_to(spring.t - centre, radius), bound);
    }
    if (slips)
      spring.slip = spring.slip + along + (1 / k) * (spring.t - t_rotated);
    else
      status = ContactStatus::stick;
    const double more = tangential_change(spring.t, k, across, b);
    spring.q = std::min(0.0, last.q + more);
    answer_.dissipated += more;
    answer_.stored += dot(spring.t, spring.t) / (2 * k);
  }
  const auto add = [&](Vector& to, std::int64_t node, const Vec<double>& f)
  {
    for (int c = 0; c < model_.gdim(); ++c)
      to(model_.gdim() * node + c) += f[c];
  };
  const Vec<double> f = spring.normal * m.n + spring.t;
  for (const auto& [node, w] : m.shares)
  {
    add(answer_.force, node, w * f);
    add(answer_.tangential, node, w * spring.t);
  }
  if (dot(spring.t, spring.t) > 0 and not outside_.axisymmetric)
  {
    const Vec<double> omega = turn_of(cross(lever, f));
    for (std::size_t j = 0; j < y.size(); ++j)
    {
      spring.turning.push_back({m.turning[j], cross(omega, y[j])});
      add(answer_.force, m.turning[j], spring.turning.back().second);
    }
  }
  return status;
}

void GeneralContact::before(const ContactStep& step)
{
  clear();
  Vec<double> mean;
  for (auto node : nodes_)
    mean = mean + (1 / double(nodes_.size())) * at(step.moved, node);
  fastest_ = longest_ = 0;
  for (auto node : nodes_)
    fastest_ = std::max(fastest_, norm(at(step.moved, node) - mean));
  for (int f = 0; f < int(outside_.facets.size()); ++f)
    for (const Corners y = corners(f, step.u); const Vec<double>& one : y)
      longest_ = std::max(longest_, norm(one - y[0]));
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    advance(nodes_[i], std::int64_t(i), step);
  std::vector<bool> is_sharp;
  for (const Edge& edge : edges_)
    is_sharp.push_back(dot(side_normal(edge.facets[0], edge.sides[0], step.u),
                           side_normal(edge.facets[1], edge.sides[1], step.u)) < sharp);
  for (auto& [pair, spring] : edge_springs_)
    if (const auto& [i, j] = pair; (is_sharp[i] and is_sharp[j]) or spring.closed)
      advance(spring, meet(edges_[i], edges_[j], spring, step), step);
}
} // namespace impact_reference
