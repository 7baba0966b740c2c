// SPDX-License-Identifier: MIT
#include "contact_explicit.h"
#include <set>
#include <stdexcept>

namespace impact_reference
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
      // At degree 2 the shares are those of the reference facet, without radius and stretch.
      for (int j = 0; j < s.num_nodes(); ++j)
        share(j) += s.degree == 1 ? w * f.N[j] : rule.weights(q) * f.N[j] * f.N[j];
    }
    share *= area / share.sum();
    for (int j = 0; j < s.num_nodes(); ++j)
      areas[facet.nodes[j]] += share(j);
  }
  return areas;
}

NodePairs::NodePairs(const Model& model, Surface slave, Surface master, std::optional<Rigid> rigid,
                     std::optional<double> search_distance, const Vector& mass, const Matrix& displacement)
    : model_(model), slave_(std::move(slave)), master_(std::move(master)), rigid_(rigid), mass_(mass),
      displacement_(displacement), areas_(nodal_areas(slave_))
{
  if (search_distance)
    search_distance_ = *search_distance;
  else
    for (const Surface* surface : {&slave_, &master_})
      for (const Facet& facet : surface->facets)
        search_distance_ = std::max(search_distance_, diameter(facet));
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
  if (ball_)
    return ball_->moved();
  return rigid_ and n > 0 ? get(displacement_, n) - get(displacement_, n - 1) : Vec<double>{};
}

Vec<double> NodePairs::master_moved(int n, const Vec<double>& x) const
{
  if (ball_ or not turns() or n == 0)
    return ball_ ? ball_->moved_at(x) : master_moved(n);
  return motion_of_point(rigid_->pivot, obstacle(n - 1), obstacle(n), x);
}

double NodePairs::slave_area() const
{
  double sum = 0;
  for (const auto& [node, area] : areas_)
    sum += area;
  return sum;
}

RigidPlace NodePairs::obstacle(int n) const
{
  if (ball_)
    return {ball_->displacement(), {}};
  if (not rigid_)
    return {};
  return {get(displacement_, n), turns() ? get(angles_, n) : Vec<double>{}};
}

RigidPlace NodePairs::obstacle_before(int n, double part) const
{
  const RigidPlace now = obstacle(n);
  const RigidPlace place{now.displacement - part * master_moved(n), now.angle};
  return turns() and n > 0 ? RigidPlace{place.displacement, (1 - part) * now.angle + part * get(angles_, n - 1)}
                           : place;
}

Eigen::Matrix3d NodePairs::master_turned(int n) const
{
  Eigen::Matrix3d out = Eigen::Matrix3d::Identity();
  for (int c = 0; turns() and n > 0 and c < 3; ++c)
  {
    Vec<double> e;
    e[c] = 1;
    const Vec<double> column = turned(get(angles_, n), turned(-1.0 * get(angles_, n - 1), e));
    out.col(c) << column[0], column[1], column[2];
  }
  return out;
}

Vec<double> NodePairs::arm(int n, const Vec<double>& x) const
{
  return rigid_ ? x - rigid_->pivot - obstacle(n).displacement : Vec<double>{};
}

double NodePairs::smallest_diameter() const
{
  double least = std::numeric_limits<double>::infinity(), largest = 0;
  for (const Facet& facet : master_.facets)
    least = std::min(least, diameter(facet));
  for (const Facet& facet : slave_.facets)
    largest = std::max(largest, diameter(facet));
  return rigid_ ? largest : least;
}

bool Gate::lets(std::size_t i, const std::function<Meeting()>& before, const Meeting& now, bool closed)
{
  // Who meets no facet keeps its mark: nothing says on which side it is.
  const bool met = std::isfinite(now.gap);
  const auto sideways = [&](const Meeting& m)
  {
    const bool over = std::isfinite(m.gap) and not m.below;
    return not over or (-now.gap > now.width / 2 and m.gap <= -now.width / 2);
  };
  if (not now.below and (now.beside or (met and now.gap >= 0)))
    marked_[i] = false;
  else if (now.below or (met and not closed and -now.gap > now.width / 20 and sideways(before())))
    marked_[i] = true;
  return not marked_[i];
}

double NodePairs::compliance(std::int64_t node, const Meeting& m) const
{
  double sum = 1 / mass(node);
  for (std::size_t j = 0; j < m.masters.size(); ++j)
    sum += std::abs(m.phi[j]) * (1 + master_areas_.at(m.masters[j]) / area(node)) / mass(m.masters[j]);
  return sum;
}

void NodePairs::set_stiffness(NodalStiffness slave, NodalStiffness master)
{
  stiffness_ = std::move(slave);
  master_stiffness_ = std::move(master);
}

double NodePairs::spring_compliance(std::int64_t node, const Meeting& m, double dt) const
{
  const auto one = [&](const NodalStiffness& stiffness, std::int64_t k)
  { return 1 / std::min(stiffness.at(k), 4 * (1 / (0.9 * 0.9) - 1) * mass(k) / (dt * dt)); };
  double sum = one(stiffness_, node);
  for (std::size_t j = 0; j < m.masters.size(); ++j)
    sum +=
        std::abs(m.phi[j]) * (1 + master_areas_.at(m.masters[j]) / area(node)) * one(master_stiffness_, m.masters[j]);
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

Vec<double> NodePairs::facet_normal(const Meeting& m, const Vector& u) const
{
  const Facet& facet = master_.facets[m.facet];
  return spot<double>(master_, facet, gather(master_, facet, u), m.xi).normal();
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

NodePairs::Lever NodePairs::lever(const Vector& u, std::int64_t node, const Meeting& m) const
{
  const double share = 1 / double(m.masters.size());
  Lever out{-1.0 * position(u, node), {}, Eigen::Matrix3d::Zero()};
  Vec<double> centre;
  for (std::size_t j = 0; j < m.masters.size(); ++j)
  {
    out.y.push_back(position(u, m.masters[j]));
    out.arm = out.arm + m.phi[j] * out.y[j];
    centre = centre + share * out.y[j];
  }
  // sum_j y_j x (omega x y_j) = sum_j (|y_j|^2 omega - (y_j . omega) y_j) from the nodes' mean.
  for (Vec<double>& v : out.y)
  {
    v = v - centre;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        out.J(a, b) += (a == b ? dot(v, v) : 0.0) - v[a] * v[b];
  }
  return out;
}

Vec<double> NodePairs::spin(const Lever& lever, const Vec<double>& moment) const
{
  Vec<double> omega;
  if (gdim() == 2)
    omega[2] = moment[2] / lever.J(2, 2); // the other two components vanish: two nodes lie on a line
  else
  {
    const Eigen::Vector3d w = lever.J.partialPivLu().solve(Eigen::Vector3d(moment[0], moment[1], moment[2]));
    omega = {w(0), w(1), w(2)};
  }
  return omega;
}

std::vector<Vec<double>> NodePairs::moment_forces(const Vec<double>& f, const Vector& u, std::int64_t node,
                                                  const Meeting& m) const
{
  std::vector<Vec<double>> forces(m.masters.size());
  if (rigid_ or slave_.axisymmetric)
    return forces;
  const Lever at = lever(u, node, m);
  const Vec<double> omega = spin(at, cross(at.arm, f)); // f and -f leave the opposite
  for (std::size_t j = 0; j < at.y.size(); ++j)
    forces[j] = cross(omega, at.y[j]);
  return forces;
}

Vec<double> NodePairs::carried(const Vector& motion, const Vector& u, std::int64_t node, const Meeting& m) const
{
  if (rigid_ or slave_.axisymmetric)
    return {};
  const Lever lever_now = lever(u, node, m);
  Vec<double> sum;
  for (std::size_t j = 0; j < lever_now.y.size(); ++j)
    sum = sum + cross(lever_now.y[j], at(motion, m.masters[j]));
  return cross(lever_now.arm, spin(lever_now, sum)); // the slave node is at -arm from the master's point
}

void NodePairs::add_moment(Vector& force, const Vec<double>& f, const Vector& u, std::int64_t node,
                           const Meeting& m) const
{
  const auto c = moment_forces(f, u, node, m);
  for (std::size_t j = 0; j < c.size(); ++j)
    for (int k = 0; k < gdim(); ++k)
      force(gdim() * m.masters[j] + k) += c[j][k];
}

Vec<double> rotated(const Vec<double>& t, const Vec<double>& n)
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
} // namespace impact_reference
