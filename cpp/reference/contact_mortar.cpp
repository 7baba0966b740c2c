#include "contact_mortar.h"
#include "contact_segments.h"

namespace impact::reference
{
namespace
{
using Square = Eigen::MatrixXd;

// Sums over the segments of one slave and one master facet, from the slave's own shape functions: with the dual basis
// psi = A phi they are turned into the mortar integrals when the whole facet is known.
template <typename T>
struct Sums
{
  const Facet* master = nullptr;
  int n;
  std::vector<T> m, d, mixed;          // int phi_j phi_k, int phi_j, int phi_j phi_l(xi_m)
  std::vector<Vec<T>> distance, moved; // int phi_j (x_s - x_m), the same of the increments

  explicit Sums(int nodes) : n(nodes), m(n * n), d(n), mixed(n * n), distance(n), moved(n) {}
};

Square matrix(const std::vector<double>& entries, int n)
{
  return Eigen::Map<const Matrix>(entries.data(), n, n);
}

template <typename T>
std::vector<double> numbers(const std::vector<T>& v)
{
  std::vector<double> result(v.size());
  for (std::size_t i = 0; i < v.size(); ++i)
    result[i] = value(v[i]);
  return result;
}

template <typename T>
Matrix rows(const std::vector<Vec<T>>& v)
{
  Matrix result(v.size(), 3);
  for (std::size_t i = 0; i < v.size(); ++i)
    for (int c = 0; c < 3; ++c)
      result(i, c) = value(v[i][c]);
  return result;
}

Vec<double> vec(const Eigen::RowVectorXd& v)
{
  return {v(0), v(1), v.size() > 2 ? v(2) : 0};
}

template <int N>
class Integration
{
public:
  using T = Dual<N>;
  Integration(const ContactPair& pair, const Rule& rule, bool dual, const Vector& u, const ContactHistory& history,
              const Matrix& z, Mortar& out)
      : pair_(pair), rule_(rule), dual_(dual), u_(u), history_(history), z_(z), out_(out), n_(pair.slave.num_nodes()),
        d_(pair.slave.gdim)
  {
  }

  void facet(const Facet& slave)
  {
    const auto us = gather(pair_.slave, slave, u_);
    const auto plane = plane_of(pair_.slave, slave, us);
    const auto whole = corners(pair_.slave, slave, us, plane);
    const double size = std::abs(measure(whole));
    double covered = 0;
    std::vector<Sums<T>> sums;
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
      sums.push_back(sum(slave, us, plane, master, um));
    }
    if (covered >= 1e-2 * size)
      combine(slave, sums);
  }

private:
  Sums<T> sum(const Facet& slave, const std::vector<Vec<double>>& us_value, const Plane<double>& plane_value,
              const Facet& master, const std::vector<Vec<double>>& um_value) const
  {
    const Surface &s = pair_.slave, &m = pair_.master;
    const auto us = seeded<N>(s, slave, u_, 0), um = seeded<N>(m, master, u_, N / 2);
    const auto plane = plane_of(s, slave, us);
    const auto us_n = gather(s, slave, history_.u), um_n = gather(m, master, history_.u);
    Sums<T> result(n_);
    result.master = &master;
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
    return result;
  }

  // Turns the sums of a facet into integrals with its multiplier basis, and adds them to its nodes.
  void combine(const Facet& slave, const std::vector<Sums<T>>& sums)
  {
    Square m = Square::Zero(n_, n_);
    Vector d = Vector::Zero(n_);
    Matrix distance = Matrix::Zero(n_, 3), moved = distance, z = Matrix::Zero(n_, 3);
    for (const auto& s : sums)
    {
      m += matrix(numbers(s.m), n_);
      const auto ds = numbers(s.d);
      d += Eigen::Map<const Vector>(ds.data(), n_);
      distance += rows(s.distance);
      moved += rows(s.moved);
    }
    for (int j = 0; j < n_; ++j)
      z.row(j).head(d_) = z_.row(slave.nodes[j]);
    const Eigen::FullPivLU<Square> lu(m);
    const Square A = dual_ ? Square(lu.solve(Square(d.asDiagonal())).transpose()) : Square::Identity(n_, n_);
    const Matrix zhat = A.transpose() * z, gamma = A * distance, slip = A * moved;
    for (int j = 0; j < n_; ++j)
    {
      MortarNode& node = out_.nodes.at(slave.nodes[j]);
      node.D += d(j);
      node.gamma.value = node.gamma.value + vec(gamma.row(j));
      node.moved.value = node.moved.value + vec(slip.row(j));
      for (int k = 0; k < n_; ++k)
        if (const double D = dual_ ? (j == k ? d(j) : 0) : m(j, k); D != 0)
        {
          out_.D.emplace_back(slave.nodes[j], slave.nodes[k], D);
          add(slave.nodes[k], D * z.row(j));
        }
    }
    for (const auto& s : sums)
    {
      const Square mixed = A * matrix(numbers(s.mixed), n_);
      for (int l = 0; l < n_; ++l)
      {
        for (int j = 0; j < n_; ++j)
          out_.M.emplace_back(slave.nodes[j], s.master->nodes[l], mixed(j, l));
        add(s.master->nodes[l], -mixed.col(l).transpose() * z);
      }
    }
    for (const auto& s : sums)
      differentiate(slave, sums, s, lu, A, distance, moved, z, zhat);
  }

  // Derivatives by the degrees of freedom of one pair. With A m = diag(d): dA = (diag(dd) - A dm) m^-1.
  void differentiate(const Facet& slave, const std::vector<Sums<T>>& sums, const Sums<T>& s,
                     const Eigen::FullPivLU<Square>& lu, const Square& A, const Matrix& distance, const Matrix& moved,
                     const Matrix& z, const Matrix& zhat)
  {
    const Matrix distance_m = lu.solve(distance), moved_m = lu.solve(moved);
    auto dofs = facet_dofs(pair_.slave, slave);
    for (auto dof : facet_dofs(pair_.master, *s.master))
      dofs.push_back(dof);
    for (int v = 0; v < N; ++v)
    {
      Square dm(n_, n_), dmixed(n_, n_);
      Vector dd(n_);
      Matrix ddistance(n_, 3), dmoved(n_, 3);
      for (int j = 0; j < n_; ++j)
      {
        dd(j) = s.d[j].d(v);
        for (int c = 0; c < 3; ++c)
        {
          ddistance(j, c) = s.distance[j][c].d(v);
          dmoved(j, c) = s.moved[j][c].d(v);
        }
        for (int k = 0; k < n_; ++k)
        {
          dm(j, k) = s.m[n_ * j + k].d(v);
          dmixed(j, k) = s.mixed[n_ * j + k].d(v);
        }
      }
      Matrix dgamma = A * ddistance, dslip = A * dmoved, dzhat = Matrix::Zero(n_, 3);
      if (dual_)
      {
        dgamma += dd.asDiagonal() * distance_m - A * dm * distance_m;
        dslip += dd.asDiagonal() * moved_m - A * dm * moved_m;
        dzhat = lu.solve(Matrix(dd.asDiagonal() * z - dm * zhat));
      }
      for (int j = 0; j < n_; ++j)
      {
        MortarNode& node = out_.nodes.at(slave.nodes[j]);
        node.gamma.slope.emplace_back(dofs[v], vec(dgamma.row(j)));
        node.moved.slope.emplace_back(dofs[v], vec(dslip.row(j)));
        const Eigen::RowVectorXd force = dual_ ? Eigen::RowVectorXd(dd(j) * z.row(j)) : dm.row(j) * zhat;
        add(slave.nodes[j], dofs[v], force);
      }
      for (int l = 0; l < n_; ++l)
        add(s.master->nodes[l], dofs[v], -dmixed.col(l).transpose() * zhat);
      if (dual_ and not dzhat.isZero(0))
        for (const auto& other : sums)
        {
          const Matrix force = matrix(numbers(other.mixed), n_).transpose() * dzhat;
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
  bool dual_;
  const Vector& u_;
  const ContactHistory& history_;
  const Matrix& z_;
  Mortar& out_;
  int n_, d_;
};

} // namespace

Mortar mortar(const ContactPair& pair, const Rule& rule, bool dual, const Vector& u, const ContactHistory& history,
              const Matrix& z)
{
  Mortar out;
  out.force = Vector::Zero(u.size());
  detail::areas(pair, out);
  if (pair.rigid)
    detail::against_obstacle(pair, rule, dual, u, history, z, out);
  else
  {
    detail::normals(pair, u, out);
    with_variables(pair.slave,
                   [&](auto n)
                   {
                     Integration<n> integration(pair, rule, dual, u, history, z, out);
                     for (const Facet& facet : pair.slave.facets)
                       integration.facet(facet);
                   });
  }
  return out;
}
} // namespace impact::reference
