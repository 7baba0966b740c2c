// SPDX-License-Identifier: MIT
#include "contact_mortar.h"
#include "DenseLu.h"
#include "contact_segments.h"

namespace impact_reference
{
namespace
{
using Square = Eigen::MatrixXd;

// Integrals over the segments of one slave and one master facet, with derivatives.
template <typename T>
struct SegmentIntegrals
{
  int n;
  std::vector<T> m, d, mixed;          // int phi_j phi_k, int phi_j, int phi_j phi_l(xi_m)
  std::vector<Vec<T>> distance, moved; // int phi_j (x_s - x_m), the same of the increments

  explicit SegmentIntegrals(int nodes) : n(nodes), m(n * n), d(n), mixed(n * n), distance(n), moved(n) {}
};

// The same as matrices: their values, or their derivatives by one variable.
struct Integrals
{
  Square m, mixed;
  Vector d;
  Matrix distance, moved;

  // `number` takes the value or one derivative out of a T.
  template <typename T, typename Number>
  Integrals(const SegmentIntegrals<T>& s, Number number)
      : m(s.n, s.n), mixed(s.n, s.n), d(s.n), distance(s.n, 3), moved(s.n, 3)
  {
    for (int j = 0; j < s.n; ++j)
    {
      d(j) = number(s.d[j]);
      for (int c = 0; c < 3; ++c)
      {
        distance(j, c) = number(s.distance[j][c]);
        moved(j, c) = number(s.moved[j][c]);
      }
      for (int k = 0; k < s.n; ++k)
      {
        m(j, k) = number(s.m[s.n * j + k]);
        mixed(j, k) = number(s.mixed[s.n * j + k]);
      }
    }
  }
};

// Sums of one slave and one master facet, from the slave's own shape functions: with the dual basis psi = A phi they
// are turned into the mortar integrals when the whole facet is known. Without template argument: Eigen's code is
// compiled once.
struct Sums
{
  const Facet* master;
  Integrals value;
  std::vector<Integrals> slope; // by the degrees of freedom of the slave's facet, then of the master's
};

Vec<double> vec(const Eigen::RowVectorXd& v)
{
  return {v(0), v(1), v.size() > 2 ? v(2) : 0};
}

class Integration
{
public:
  Integration(const ContactPair& pair, const Rule& rule, Basis basis, const Vector& u, const ContactHistory& history,
              const Matrix& z, Mortar& out)
      : pair_(pair), rule_(rule), basis_(basis), u_(u), history_(history), z_(z), out_(out), n_(pair.slave.num_nodes()),
        d_(pair.slave.gdim)
  {
  }

  void run()
  {
    std::vector<std::vector<Sums>> sums;
    sums.reserve(pair_.slave.facets.size());
    for (const Facet& slave : pair_.slave.facets)
      sums.push_back(facet(slave));
    for (std::size_t f = 0; f < sums.size(); ++f)
      count(pair_.slave.facets[f], sums[f]);
    for (auto& [number, node] : out_.nodes)
    {
      node.part = node.is_enough(node.share) and node.is_enough(node.cover);
      node.cover = 0;
    }
    for (std::size_t f = 0; f < sums.size(); ++f)
      combine(pair_.slave.facets[f], sums[f]);
  }

private:
  // Sums of a facet, master by master; none if it counts as not covered.
  std::vector<Sums> facet(const Facet& slave) const
  {
    const auto us = gather(pair_.slave, slave, u_);
    const auto plane = plane_of(pair_.slave, slave, us);
    const auto whole = corners(pair_.slave, slave, us, plane);
    const double size = std::abs(measure(whole));
    double covered = 0;
    std::vector<Sums> sums;
    for (const Facet& master : pair_.master.facets)
    {
      const auto um = gather(pair_.master, master, u_);
      const auto other = plane_of(pair_.master, master, um);
      if (dot(plane.normal, other.normal) >= 0 or
          std::abs(dot(plane.normal, other.centre - plane.centre)) > pair_.search_distance)
        continue;
      const auto segment = overlap(whole, corners(pair_.master, master, um, plane));
      const double area = segment.empty() ? 0 : measure(segment);
      if (area <= 1e-13 * size)
        continue;
      covered += area;
      sums.push_back(
          with_variables(pair_.slave, [&](auto number) { return sum<number>(slave, us, plane, master, um); }));
    }
    if (covered < 1e-2 * size)
      sums.clear();
    return sums;
  }

  // Adds up the integrals of the multipliers' functions, which decide where multipliers live.
  void count(const Facet& slave, const std::vector<Sums>& sums)
  {
    Vector d = Vector::Zero(n_);
    for (const auto& s : sums)
      d += s.value.d;
    if (basis_ == Basis::linear)
      d = Vector(detail::corner_functions(pair_.slave).lazyProduct(d));
    for (int j = 0; j < n_; ++j)
      out_.nodes.at(slave.nodes[j]).cover += d(j);
  }

  template <int N>
  Sums sum(const Facet& slave, const std::vector<Vec<double>>& us_value, const Plane<double>& plane_value,
           const Facet& master, const std::vector<Vec<double>>& um_value) const
  {
    using T = Dual<N>;
    const Surface &s = pair_.slave, &m = pair_.master;
    const auto us = seeded<N>(s, slave, u_, 0), um = seeded<N>(m, master, u_, N / 2);
    const auto plane = plane_of(s, slave, us);
    const auto us_n = gather(s, slave, history_.u), um_n = gather(m, master, history_.u);
    SegmentIntegrals<T> result(n_);
    integrate(overlap(corners(s, slave, us, plane), corners(m, master, um, plane)), rule_,
              [&](const Flat<T>& y, const T& flat_weight)
              {
                const auto xi_s = carry_back(s, slave, us, plane, y, us_value, plane_value);
                const auto xi_m = carry_back(m, master, um, plane, y, um_value, plane_value);
                const Spot<T> ps = spot(s, slave, us, xi_s), pm = spot(m, master, um, xi_m);
                const T w = flat_weight * reference_area(s, slave, xi_s) / dot(ps.area(), plane.normal);
                Vec<T> moved;
                for (int k = 0; k < n_; ++k)
                  moved =
                      moved + ps.f.N[k] * (us[k] - constant<T>(us_n[k])) - pm.f.N[k] * (um[k] - constant<T>(um_n[k]));
                const Vec<T> distance = ps.x - pm.x;
                for (int j = 0; j < n_; ++j)
                {
                  const T wj = w * ps.f.N[j];
                  result.d[j] += wj;
                  result.distance[j] = result.distance[j] + wj * distance;
                  result.moved[j] = result.moved[j] + wj * moved;
                  for (int k = 0; k < n_; ++k)
                  {
                    result.m[n_ * j + k] += wj * ps.f.N[k];
                    result.mixed[n_ * j + k] += wj * pm.f.N[k];
                  }
                }
              });
    Sums sums{&master, Integrals(result, [](const T& x) { return x.v; }), {}};
    for (int v = 0; v < N; ++v)
      sums.slope.emplace_back(result, [v](const T& x) { return x.d(v); });
    return sums;
  }

  // Turns the sums of a facet into integrals with its multiplier basis, and adds them to its nodes.
  void combine(const Facet& slave, const std::vector<Sums>& sums)
  {
    Square m = Square::Zero(n_, n_);
    Vector d = Vector::Zero(n_);
    Matrix distance = Matrix::Zero(n_, 3), moved = distance, z = Matrix::Zero(n_, 3);
    for (const auto& s : sums)
    {
      m += s.value.m;
      d += s.value.d;
      distance += s.value.distance;
      moved += s.value.moved;
    }
    const Square B = detail::handed_over(slave, out_);
    if (sums.empty() or B.isZero(0))
      return;
    for (int j = 0; j < n_; ++j)
      z.row(j).head(d_) = z_.row(slave.nodes[j]);
    const DenseLu lu(m);
    Square A = B;
    if (is_dual())
      A = B.lazyProduct(lu.solve(Square(d.asDiagonal())).transpose());
    else if (basis_ == Basis::linear)
      A = B.lazyProduct(detail::corner_functions(pair_.slave));
    const Square D = is_dual() ? Square(B * d.asDiagonal()) : Square(A.lazyProduct(m));
    const Matrix zhat = A.transpose().lazyProduct(z), gamma = A.lazyProduct(distance), slip = A.lazyProduct(moved),
                 force = D.transpose().lazyProduct(z);
    for (int j = 0; j < n_; ++j)
    {
      MortarNode& node = out_.nodes.at(slave.nodes[j]);
      node.cover += D.row(j).sum();
      node.gamma.value = node.gamma.value + vec(gamma.row(j));
      node.moved.value = node.moved.value + vec(slip.row(j));
      for (int k = 0; k < n_; ++k)
        if (D(j, k) != 0)
          out_.D.emplace_back(slave.nodes[j], slave.nodes[k], D(j, k));
      add(slave.nodes[j], force.row(j));
    }
    for (const auto& s : sums)
    {
      const Square mixed = A.lazyProduct(s.value.mixed);
      for (int l = 0; l < n_; ++l)
      {
        for (int j = 0; j < n_; ++j)
          if (mixed(j, l) != 0)
            out_.M.emplace_back(slave.nodes[j], s.master->nodes[l], mixed(j, l));
        add(s.master->nodes[l], -mixed.col(l).transpose().lazyProduct(z));
      }
    }
    for (const auto& s : sums)
      differentiate(slave, sums, s, lu, A, B, distance, moved, B.transpose().lazyProduct(z), zhat);
  }

  bool is_dual() const { return basis_ == Basis::dual; }

  // Derivatives by the degrees of freedom of one pair. With A m = B diag(d): dA = (B diag(dd) - A dm) m^-1.
  // zb = B^T z, zhat = A^T z.
  void differentiate(const Facet& slave, const std::vector<Sums>& sums, const Sums& s, const DenseLu& lu,
                     const Square& A, const Square& B, const Matrix& distance, const Matrix& moved, const Matrix& zb,
                     const Matrix& zhat)
  {
    const Matrix distance_m = lu.solve(distance), moved_m = lu.solve(moved);
    auto dofs = facet_dofs(pair_.slave, slave);
    for (auto dof : facet_dofs(pair_.master, *s.master))
      dofs.push_back(dof);
    for (std::size_t v = 0; v < s.slope.size(); ++v)
    {
      const Square &dm = s.slope[v].m, &dmixed = s.slope[v].mixed;
      const Vector& dd = s.slope[v].d;
      Matrix dgamma = A.lazyProduct(s.slope[v].distance), dslip = A.lazyProduct(s.slope[v].moved),
             dzhat = Matrix::Zero(n_, 3);
      if (is_dual())
      {
        const Square dA_m = B * dd.asDiagonal() - A.lazyProduct(dm); // dA m
        dgamma += dA_m.lazyProduct(distance_m);
        dslip += dA_m.lazyProduct(moved_m);
        dzhat = lu.solve(dd.asDiagonal() * zb - dm.lazyProduct(zhat));
      }
      for (int j = 0; j < n_; ++j)
      {
        MortarNode& node = out_.nodes.at(slave.nodes[j]);
        node.gamma.slope.emplace_back(dofs[v], vec(dgamma.row(j)));
        node.moved.slope.emplace_back(dofs[v], vec(dslip.row(j)));
        const Eigen::RowVectorXd force =
            is_dual() ? Eigen::RowVectorXd(dd(j) * zb.row(j)) : Eigen::RowVectorXd(dm.row(j).lazyProduct(zhat));
        add(slave.nodes[j], dofs[v], force);
      }
      for (int l = 0; l < n_; ++l)
        add(s.master->nodes[l], dofs[v], -dmixed.col(l).transpose().lazyProduct(zhat));
      if (is_dual() and not dzhat.isZero(0))
        for (const auto& other : sums)
        {
          const Matrix force = other.value.mixed.transpose().lazyProduct(dzhat);
          for (int l = 0; l < n_; ++l)
            add(other.master->nodes[l], dofs[v], -force.row(l));
        }
    }
  }

  void add(std::int64_t node, const Eigen::RowVectorXd& force)
  {
    out_.force.segment(d_ * node, d_) += force.head(d_).transpose();
  }

  void add(std::int64_t node, std::int64_t dof, const Eigen::RowVectorXd& slope)
  {
    for (int c = 0; c < d_; ++c)
      if (slope(c) != 0)
        out_.tangent.emplace_back(int(d_ * node + c), int(dof), -slope(c));
  }

  const ContactPair& pair_;
  const Rule& rule_;
  Basis basis_;
  const Vector& u_;
  const ContactHistory& history_;
  const Matrix& z_;
  Mortar& out_;
  int n_, d_;
};

} // namespace

Mortar mortar(const ContactPair& pair, const Rule& rule, Basis basis, const Vector& u, const ContactHistory& history,
              const Matrix& z)
{
  Mortar out;
  out.force = Vector::Zero(u.size());
  detail::areas(pair, basis, out);
  if (pair.rigid)
    detail::against_obstacle(pair, *pair.rigid, rule, basis, u, history, z, out);
  else
  {
    detail::normals(pair, u, out);
    Integration(pair, rule, basis, u, history, z, out).run();
  }
  return out;
}
} // namespace impact_reference
