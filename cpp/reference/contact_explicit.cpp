#include "contact_explicit.h"
#include <set>
#include <stdexcept>

namespace impact::reference
{
namespace
{
void put(Matrix& rows, std::int64_t row, const Vec<double>& v)
{
  for (int c = 0; c < rows.cols(); ++c)
    rows(row, c) = v[c];
}

Vec<double> get(const Matrix& rows, std::int64_t row)
{
  Vec<double> v;
  for (int c = 0; c < rows.cols(); ++c)
    v[c] = rows(row, c);
  return v;
}
} // namespace

std::map<std::int64_t, double> nodal_areas(const Surface& s)
{
  const Rule rule = quadrature(s.type, default_rule(Purpose::facet, s.type, 2, 2, s.axisymmetric));
  std::map<std::int64_t, double> areas;
  for (const Facet& facet : s.facets)
  {
    double area = 0;
    Vector share = Vector::Zero(s.num_nodes());
    for (int q = 0; q < rule.weights.size(); ++q)
    {
      const Local xi{rule.points(q, 0), s.tdim() == 2 ? rule.points(q, 1) : 0};
      const double w = rule.weights(q) * reference_area<double>(s, facet, xi);
      const auto f = facet_functions<double>(s.type, s.degree, xi);
      area += w;
      for (int j = 0; j < s.num_nodes(); ++j)
        share(j) += w * (s.degree == 1 ? f.N[j] : f.N[j] * f.N[j]);
    }
    share *= area / share.sum();
    for (int j = 0; j < s.num_nodes(); ++j)
      areas[facet.nodes[j]] += share(j);
  }
  return areas;
}

NodePairs::NodePairs(const Model& model, Surface slave, Surface master, std::optional<Rigid> rigid,
                     double search_distance, const Vector& mass, const Matrix& displacement)
    : model_(model), slave_(std::move(slave)), master_(std::move(master)), rigid_(std::move(rigid)),
      search_distance_(search_distance), mass_(mass), displacement_(displacement), areas_(nodal_areas(slave_))
{
  if (not rigid_)
    master_areas_ = nodal_areas(master_);
  for (const auto& [node, area] : areas_)
    nodes_.push_back(node);
  if (mass.size() != model.num_dofs() or not(mass.minCoeff() > 0))
    throw std::invalid_argument("contact needs a positive lumped mass on every node");
}

Vec<double> NodePairs::at(const Vector& field, std::int64_t node) const
{
  Vec<double> v;
  for (int c = 0; c < gdim(); ++c)
    v[c] = field(gdim() * node + c);
  return v;
}

Vec<double> NodePairs::position(const Vector& u, std::int64_t node) const
{
  return get(model_.field().points, node) + at(u, node);
}

Vec<double> NodePairs::master_moved(int n) const
{
  return rigid_ and n > 0 ? get(displacement_, n) - get(displacement_, n - 1) : Vec<double>{};
}

namespace
{
/// The longest way between two vertices of a facet in the reference configuration.
double width(const Facet& facet)
{
  double longest = 0;
  for (Eigen::Index a = 0; a < facet.X.rows(); ++a)
    for (Eigen::Index b = 0; b < a; ++b)
      longest = std::max(longest, (facet.X.row(a) - facet.X.row(b)).norm());
  return longest;
}
} // namespace

std::vector<Meeting> NodePairs::meet(const Vector& u, int level) const
{
  std::vector<Meeting> result(nodes_.size());
  if (rigid_)
  {
    for (std::size_t i = 0; i < nodes_.size(); ++i)
    {
      result[i].x = position(u, nodes_[i]);
      const auto g = gap_and_normal<double>(*rigid_, get(displacement_, level), result[i].x);
      result[i].gap = g.gap;
      result[i].normal = g.normal;
    }
    return result;
  }
  std::map<std::int64_t, Vec<double>> normals;
  const Matrix places = reference_nodes(slave_.type, slave_.degree);
  for (const Facet& facet : slave_.facets)
  {
    const auto us = gather(slave_, facet, u);
    for (int k = 0; k < slave_.num_nodes(); ++k)
    {
      Vec<double>& sum = normals[facet.nodes[k]];
      const Local xi{places(k, 0), slave_.tdim() == 2 ? places(k, 1) : 0};
      sum = sum + spot<double>(slave_, facet, us, xi).normal();
    }
  }
  const Projector projector(master_, u, search_distance_);
  for (std::size_t i = 0; i < nodes_.size(); ++i)
  {
    Meeting& m = result[i];
    m.x = position(u, nodes_[i]);
    const auto meets = [&](const Facet& facet, double gap, const Vec<double>& normal, const auto& f)
    {
      m.gap = gap;
      m.normal = normal;
      m.masters = facet.nodes;
      m.phi.assign(f.N.begin(), f.N.begin() + std::ptrdiff_t(facet.nodes.size()));
    };
    Foot foot = projector.nearest(m.x, normals.at(nodes_[i]));
    if (foot.facet < 0)
      continue;
    if (foot.dim < master_.tdim() and projector.on_rim(foot))
    {
      const Facet& facet = master_.facets[foot.facet];
      const auto s = spot<double>(master_, facet, gather(master_, facet, u), foot.xi);
      const Vec<double> d = m.x - s.x, n = s.normal();
      const double depth = dot(d, n), far = 0.05 * width(facet);
      if (depth < 0 and dot(d, d) - depth * depth < far * far)
      {
        meets(facet, depth, n, s.f);
        continue;
      }
    }
    foot = projector.closest(m.x, normals.at(nodes_[i]));
    if (foot.facet < 0)
      continue;
    const Facet& facet = master_.facets[foot.facet];
    const auto projection = projector.follow<double>(foot, gather(master_, facet, u), m.x);
    meets(facet, projection.gap, projection.normal, projection.f);
  }
  return result;
}

double NodePairs::compliance(std::int64_t node, const Meeting& m) const
{
  double sum = 1 / mass(node);
  for (std::size_t j = 0; j < m.masters.size(); ++j)
    sum += std::abs(m.phi[j]) * (1 + master_areas_.at(m.masters[j]) / area(node)) / mass(m.masters[j]);
  return sum;
}

Vec<double> NodePairs::relative(const Vector& motion, const Vec<double>& rigid, std::int64_t node,
                                const Meeting& m) const
{
  Vec<double> result = at(motion, node) - rigid;
  for (std::size_t j = 0; j < m.masters.size(); ++j)
    result = result - m.phi[j] * at(motion, m.masters[j]);
  return result;
}

void NodePairs::add(Vector& force, const Vec<double>& f, std::int64_t node, const Meeting& m) const
{
  for (int c = 0; c < gdim(); ++c)
  {
    force(gdim() * node + c) += f[c];
    for (std::size_t j = 0; j < m.masters.size(); ++j)
      force(gdim() * m.masters[j] + c) -= m.phi[j] * f[c];
  }
}

Vec<double> turned(const Vec<double>& t, const Vec<double>& n)
{
  const Vec<double> flat = t - dot(t, n) * n;
  const double length = norm(flat);
  return length > 0 ? (norm(t) / length) * flat : Vec<double>{};
}

ContactAnswer no_contact(const NodePairs& pairs)
{
  const auto count = std::int64_t(pairs.nodes().size());
  const Vector zero = Vector::Zero(pairs.num_dofs());
  const Matrix rows = Matrix::Zero(count, pairs.gdim());
  return {zero,
          zero,
          {},
          {},
          Vector::Constant(count, std::numeric_limits<double>::infinity()),
          rows,
          rows,
          std::vector<ContactStatus>(count, ContactStatus::open)};
}

NodalPenalty::NodalPenalty(std::vector<NodePairs> directions, double friction, double penalty)
    : friction_(friction), penalty_(penalty), part_(1.0 / double(directions.size()))
{
  answer_ = no_contact(directions[0]);
  for (NodePairs& pairs : directions)
  {
    const ContactAnswer none = no_contact(pairs);
    directions_.push_back(
        {std::move(pairs), std::vector<double>(none.status.size(), none.gap(0)), none.traction, none.slip});
  }
}

double NodalPenalty::stiffness(const NodePairs& pairs, std::int64_t node, const Meeting& m, double dt) const
{
  if (penalty_ > 0)
    return part_ * penalty_ * pairs.area(node);
  return part_ * 0.5 / (dt * dt * pairs.compliance(node, m));
}

void NodalPenalty::before(const ContactStep& step)
{
  const double dissipated = answer_.dissipated;
  answer_ = no_contact(directions_[0].pairs);
  answer_.dissipated = dissipated;
  for (std::size_t k = 0; k < directions_.size(); ++k)
    evaluate(directions_[k], step, k == 0);
}

namespace
{
// The forces +t at x and -t at the master's point are gap apart: forces along n on the facet's nodes, without
// resultant, carry the couple.
void add_couple(Vector& force, const NodePairs& pairs, const Vector& u, const Meeting& m, const Vec<double>& t)
{
  const int d = pairs.gdim();
  std::vector<Vec<double>> y;
  Vec<double> centre;
  for (auto node : m.masters)
  {
    y.push_back(pairs.position(u, node));
    centre = centre + (1.0 / double(m.masters.size())) * y.back();
  }
  // sum_j w_j y_j = gap t, w_j = c . y_j, in the tangent plane.
  Eigen::Matrix3d G = Eigen::Matrix3d::Zero();
  const Eigen::Vector3d n(m.normal[0], m.normal[1], m.normal[2]);
  for (auto& v : y)
  {
    v = v - centre;
    v = v - dot(v, m.normal) * m.normal;
    const Eigen::Vector3d e(v[0], v[1], v[2]);
    G += e * e.transpose();
  }
  const double size = G.trace();
  G += size * n * n.transpose();
  if (d == 2)
    G(2, 2) += size;
  const Eigen::Vector3d c = G.partialPivLu().solve(m.gap * Eigen::Vector3d(t[0], t[1], t[2]));
  for (std::size_t j = 0; j < y.size(); ++j)
  {
    const double w = c(0) * y[j][0] + c(1) * y[j][1] + c(2) * y[j][2];
    for (int k = 0; k < d; ++k)
      force(d * m.masters[j] + k) += w * m.normal[k];
  }
}
} // namespace

void NodalPenalty::evaluate(Direction& direction, const ContactStep& step, bool first)
{
  const NodePairs& pairs = direction.pairs;
  const auto meetings = pairs.meet(step.u, step.n);
  // A balanced pair's total is that on the slave of the first direction.
  const double sign = first ? 1 : -1;
  for (std::size_t i = 0; i < meetings.size(); ++i)
  {
    const Meeting& m = meetings[i];
    const std::int64_t node = pairs.nodes()[i];
    const double gap_before = direction.gap_before[i];
    direction.gap_before[i] = m.gap;
    Vec<double> t, slip;
    ContactStatus status = ContactStatus::open;
    if (m.gap < 0)
    {
      const double k = stiffness(pairs, node, m, step.dt);
      const Vec<double> normal = (-k * m.gap) * m.normal;
      status = ContactStatus::slip;
      answer_.stored += k * m.gap * m.gap / 2;
      if (friction_ > 0)
      {
        const Vec<double> moved = pairs.relative(step.moved, pairs.master_moved(step.n), node, m);
        const double part = gap_before > 0 ? (std::isinf(gap_before) ? 0 : -m.gap / (gap_before - m.gap)) : 1;
        const Vec<double> s = part * (moved - dot(moved, m.normal) * m.normal);
        const Vec<double> before = turned(get(direction.traction, i), m.normal);
        t = before - k * s;
        const double bound = friction_ * -k * m.gap, size = norm(t);
        status = ContactStatus::stick;
        slip = get(direction.slip, i);
        if (size > bound)
        {
          status = ContactStatus::slip;
          t = (bound / size) * t;
          const Vec<double> more = s + (1 / k) * (t - before);
          slip = slip + more;
          answer_.dissipated += norm(t) * norm(more);
        }
        answer_.stored += dot(t, t) / (2 * k);
        pairs.add(answer_.tangential, t, node, m);
        if (not m.masters.empty() and not pairs.axisymmetric())
          add_couple(answer_.tangential, pairs, step.u, m, t);
        answer_.friction = answer_.friction + sign * t;
      }
      pairs.add(answer_.force, normal, node, m);
      answer_.total = answer_.total + sign * (normal + t);
    }
    put(direction.traction, i, t);
    put(direction.slip, i, slip);
    if (first)
    {
      answer_.gap(i) = m.gap;
      answer_.status[i] = status;
      put(answer_.traction, i, t);
      put(answer_.slip, i, slip);
    }
  }
  if (&direction == &directions_.back())
    answer_.force += answer_.tangential;
}

double NodalPenalty::added_frequency(const Vector& u) const
{
  double sum = 0;
  if (penalty_ > 0)
    for (const Direction& direction : directions_)
    {
      const NodePairs& pairs = direction.pairs;
      const auto meetings = pairs.meet(u, 0);
      double highest = 0;
      for (std::size_t i = 0; i < meetings.size(); ++i)
        if (const std::int64_t node = pairs.nodes()[i]; std::isfinite(meetings[i].gap))
          highest = std::max(highest, stiffness(pairs, node, meetings[i], 1) * pairs.compliance(node, meetings[i]));
      sum += highest;
    }
  return sum;
}

Entries NodalPenalty::springs(const Vector& u) const
{
  Entries entries;
  if (not(penalty_ > 0))
    return entries;
  for (const Direction& direction : directions_)
  {
    const NodePairs& pairs = direction.pairs;
    const int d = pairs.gdim();
    const auto meetings = pairs.meet(u, 0);
    for (std::size_t i = 0; i < meetings.size(); ++i)
    {
      const Meeting& m = meetings[i];
      if (not std::isfinite(m.gap))
        continue;
      const double k = stiffness(pairs, pairs.nodes()[i], m, 1);
      std::vector<std::pair<std::int64_t, double>> parts{{pairs.nodes()[i], 1.0}};
      for (std::size_t j = 0; j < m.masters.size(); ++j)
        parts.emplace_back(m.masters[j], -m.phi[j]);
      for (const auto& [a, wa] : parts)
        for (const auto& [b, wb] : parts)
          for (int r = 0; r < d; ++r)
            for (int c = 0; c < d; ++c)
            {
              const double direction_part = friction_ > 0 ? double(r == c) : m.normal[r] * m.normal[c];
              entries.emplace_back(int(d * a + r), int(d * b + c), k * wa * wb * direction_part);
            }
    }
  }
  return entries;
}
} // namespace impact::reference
