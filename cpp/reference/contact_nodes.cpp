// SPDX-License-Identifier: MIT
#include "contact_mortar.h"
#include <numbers>

namespace impact_reference
{
namespace
{
// Adds minus the facets' normals to every node.
template <int N>
void facet_normals(const ContactPair& pair, const Vector& u, Mortar& out)
{
  const Surface& s = pair.slave;
  const Matrix places = reference_nodes(s.type, s.degree);
  for (const Facet& facet : s.facets)
  {
    const auto us = seeded<N>(s, facet, u, 0);
    const auto dofs = facet_dofs(s, facet);
    for (int k = 0; k < s.num_nodes(); ++k)
    {
      const Vec<Dual<N>> nu =
          spot(s, facet, us, {Dual<N>(places(k, 0)), Dual<N>(s.tdim() == 2 ? places(k, 1) : 0)}).normal();
      NodalVector& sum = out.nodes.at(facet.nodes[k]).normal;
      sum.value = sum.value - values(nu);
      for (std::size_t v = 0; v < dofs.size(); ++v)
        sum.slope.emplace_back(dofs[v], Vec<double>{-nu[0].d(v), -nu[1].d(v), -nu[2].d(v)});
    }
  }
}
} // namespace

namespace detail
{
void normals(const ContactPair& pair, const Vector& u, Mortar& out)
{
  const Surface& s = pair.slave;
  with_variables(s, [&](auto n) { facet_normals<n>(pair, u, out); });
  for (auto& [number, node] : out.nodes)
  {
    // A prescribed component takes its part out of a normal that is nearly orthogonal to it, and of no other.
    Vec<double> kept = node.normal.value;
    const double small = std::sin(5 * std::numbers::pi / 180) * norm(kept);
    std::array<bool, 3> hold{};
    for (int c = 0; c < s.gdim; ++c)
      if (not pair.prescribed.empty() and pair.prescribed[s.gdim * number + c] and std::abs(kept[c]) < small)
        hold[c] = true;
    for (int c = 0; c < 3; ++c)
      if (hold[c])
        kept[c] = 0;
    const double length = norm(kept);
    const Vec<double> n = (1 / length) * kept;
    for (auto& [dof, slope] : node.normal.slope)
    {
      for (int c = 0; c < 3; ++c)
        if (hold[c])
          slope[c] = 0;
      slope = (1 / length) * (slope - dot(slope, n) * n);
    }
    node.normal.value = n;
  }
}

Eigen::MatrixXd corner_functions(const Surface& s)
{
  const Matrix places = reference_nodes(s.type, s.degree);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(s.num_nodes(), s.num_nodes());
  for (int k = 0; k < s.num_nodes(); ++k)
  {
    const auto f = facet_functions<double>(s.type, 1, {places(k, 0), s.tdim() == 2 ? places(k, 1) : 0});
    for (int v = 0; v < s.num_vertices(); ++v)
      A(v, k) = f.N[v];
  }
  return A;
}

Eigen::MatrixXd handed_over(const Facet& facet, const Mortar& mortar)
{
  const int n = int(facet.nodes.size());
  Eigen::VectorXd part(n);
  for (int j = 0; j < n; ++j)
    part(j) = mortar.nodes.at(facet.nodes[j]).part;
  Eigen::MatrixXd B = part.asDiagonal();
  if (part.sum() > 0)
    B += part * (Eigen::VectorXd::Ones(n) - part).transpose() / part.sum();
  return B;
}

void areas(const ContactPair& pair, Basis basis, Mortar& out)
{
  const Surface& s = pair.slave;
  const Rule rule = quadrature(s.type, default_rule(Purpose::facet, s.type, 2, 2, s.axisymmetric));
  const auto linear = corner_functions(s);
  for (const Facet& facet : s.facets)
  {
    double area = 0;
    Eigen::VectorXd share = Eigen::VectorXd::Zero(s.num_nodes());
    for (int q = 0; q < rule.weights.size(); ++q)
    {
      const Local xi{rule.points(q, 0), s.tdim() == 2 ? rule.points(q, 1) : 0};
      const double w = rule.weights(q) * reference_area<double>(s, facet, xi);
      const auto f = facet_functions<double>(s.type, s.degree, xi);
      area += w;
      for (int j = 0; j < s.num_nodes(); ++j)
        share(j) += w * f.N[j];
    }
    if (basis == Basis::linear)
      share = Vector(linear.lazyProduct(share));
    for (int j = 0; j < s.num_nodes(); ++j)
    {
      out.nodes[facet.nodes[j]].area += area;
      out.nodes[facet.nodes[j]].share += share(j);
    }
  }
}

void against_obstacle(const ContactPair& pair, const Rigid& rigid, const Rule& rule, Basis basis, const Vector& u,
                      const ContactHistory& history, const Matrix& z, Mortar& out)
{
  const Surface& s = pair.slave;
  const int d = s.gdim, n = s.num_nodes();
  const auto at = [&](const Vector& values, std::int64_t node)
  {
    Vec<double> v;
    for (int c = 0; c < d; ++c)
      v[c] = values(d * node + c);
    return v;
  };
  for (auto& [number, node] : out.nodes)
    node.part = node.is_enough(node.share);
  for (const Facet& facet : s.facets)
  {
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(n, n);
    for (int q = 0; q < rule.weights.size(); ++q)
    {
      const Local xi{rule.points(q, 0), s.tdim() == 2 ? rule.points(q, 1) : 0};
      const double w = rule.weights(q) * reference_area<double>(s, facet, xi);
      const auto f = facet_functions<double>(s.type, s.degree, xi);
      for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k)
          m(j, k) += w * f.N[j] * f.N[k];
    }
    Eigen::MatrixXd D = m.rowwise().sum().asDiagonal();
    if (basis != Basis::dual)
    {
      const Eigen::MatrixXd A = basis == Basis::linear ? Eigen::MatrixXd(corner_functions(s).lazyProduct(m)) : m;
      D = handed_over(facet, out).lazyProduct(A);
    }
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        if (D(j, k) != 0)
        {
          out.nodes.at(facet.nodes[j]).cover += D(j, k);
          out.D.emplace_back(facet.nodes[j], facet.nodes[k], D(j, k));
        }
  }
  for (const auto& D : out.D)
  {
    out.force.segment(d * D.col(), d) += D.value() * z.row(D.row()).transpose();
    NodalVector& moved = out.nodes.at(D.row()).moved;
    moved.value = moved.value + D.value() * (at(u, D.col()) - at(history.u, D.col()));
    for (int c = 0; c < d; ++c)
    {
      Vec<double> slope;
      slope[c] = D.value();
      moved.slope.emplace_back(d * D.col() + c, slope);
    }
  }
  using T = Dual<3>;
  for (auto& [number, node] : out.nodes)
  {
    Vec<T> x;
    for (int c = 0; c < d; ++c)
      x[c] = T::variable(pair.model.field().points(number, c) + u(d * number + c), c);
    const auto g = gap_and_normal<T>(rigid, rigid.place, x);
    const Vec<T> gamma = (node.cover * g.gap) * g.normal;
    // Slip is that against the obstacle's point where the node was.
    Vec<double> before = at(history.u, number);
    for (int c = 0; c < d; ++c)
      before[c] += pair.model.field().points(number, c);
    node.moved.value = node.moved.value - node.cover * motion_from(rigid.pivot, history.place, rigid.place, before);
    node.gamma.value = values(gamma);
    node.normal.value = values(g.normal);
    for (int c = 0; c < d; ++c)
    {
      node.gamma.slope.emplace_back(d * number + c, Vec<double>{gamma[0].d(c), gamma[1].d(c), gamma[2].d(c)});
      node.normal.slope.emplace_back(d * number + c, Vec<double>{g.normal[0].d(c), g.normal[1].d(c), g.normal[2].d(c)});
    }
  }
}
} // namespace detail
} // namespace impact_reference
