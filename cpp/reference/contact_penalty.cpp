// SPDX-License-Identifier: MIT
#include "contact.h"
#include <Eigen/Sparse>
#include <stdexcept>

namespace impact_reference
{
namespace
{

struct PointData
{
  double chi, chi_t, friction, multiplier, tolerance, shift;
  bool touched;
  Vec<double> traction_n, slip_n;
};

template <typename T>
struct Friction
{
  Vec<T> traction;
  ContactStatus status = ContactStatus::stick;
  Vec<double> slip;
};

// Coulomb's law with a tangential spring; `moved` is the slave's increment against the master's.
template <typename T>
Friction<T> coulomb(const PointData& data, const T& p, const Vec<T>& n, const Vec<T>& moved)
{
  Friction<T> result;
  const auto tangential = [&](const Vec<T>& v) { return v - dot(v, n) * n; };
  const Vec<T> s = tangential(moved);
  Vec<T> before; // traction of the last state, turned into the tangent plane without a change of length
  const double length = norm(data.traction_n);
  if (length > 0)
  {
    const Vec<T> turned = tangential(constant<T>(data.traction_n));
    if (value(norm(turned)) > 0)
      before = (length / norm(turned)) * turned;
  }
  const Vec<T> trial = before - T(data.chi_t) * s;
  const double size = norm(values(trial)), bound = data.friction * value(p);
  result.traction = trial;
  result.slip = data.slip_n;
  if (size > bound)
  {
    result.status = ContactStatus::slip;
    result.traction = (data.friction * p / norm(trial)) * trial;
    result.slip = result.slip + (1 / data.chi_t) * (values(result.traction) - values(trial));
  }
  return result;
}

template <typename T>
void put(Matrix& rows, std::int64_t row, const Vec<T>& v)
{
  for (int c = 0; c < rows.cols(); ++c)
    rows(row, c) = value(v[c]);
}

Vec<double> get(const Matrix& rows, std::int64_t row)
{
  Vec<double> v;
  for (int c = 0; c < rows.cols(); ++c)
    v[c] = rows(row, c);
  return v;
}

template <int N>
class Evaluation
{
public:
  using T = Dual<N>;
  Evaluation(const ContactPair& pair, const Rule& rule, const Vector& u, const ContactHistory& history)
      : pair_(pair), rule_(rule), u_(u), history_(history), half_(N / 2), tolerance_(1e-12 * pair.size())
  {
    if (not pair.rigid)
    {
      projector_.emplace(pair.master, u, pair.search_distance);
      if (pair.friction > 0)
        projector_n_.emplace(pair.master, history.u, pair.search_distance);
    }
  }

  Penalty run(double chi, double chi_t, const Vector& multiplier)
  {
    const std::int64_t n = rule_.weights.size(), count = n * std::int64_t(pair_.slave.facets.size());
    const int d = pair_.slave.gdim;
    Penalty result{Vector::Zero(u_.size()), {}, {}, no_history(pair_, count)};
    ContactPoints& out = result.points;
    out = {Vector::Constant(count, std::numeric_limits<double>::infinity()),
           Matrix::Zero(count, d),
           std::vector<std::int64_t>(count, -1),
           Matrix::Zero(count, d - 1),
           Matrix::Zero(count, d),
           Vector::Zero(count),
           Vector::Zero(count),
           Matrix::Zero(count, d),
           std::vector<ContactStatus>(count, ContactStatus::open),
           Flags::Zero(count)};
    result.history.u = u_;
    if (pair_.rigid)
      result.history.place = pair_.rigid->place;
    for (std::int64_t i = 0; i < count; ++i)
    {
      const PointData data{chi,
                           chi_t,
                           pair_.friction,
                           multiplier.size() ? multiplier(i) : 0,
                           tolerance_,
                           pair_.gap_shift.size() ? pair_.gap_shift(i) : 0,
                           history_.touched(i) != 0,
                           get(history_.traction, i),
                           get(history_.slip, i)};
      point(i, i / n, i % n, data, result);
    }
    return result;
  }

private:
  void point(std::int64_t i, std::int64_t f, std::int64_t q, const PointData& data, Penalty& result)
  {
    const Surface& slave = pair_.slave;
    const Facet& facet = slave.facets[f];
    ContactPoints& out = result.points;
    const Local xi{rule_.points(q, 0), slave.tdim() == 2 ? rule_.points(q, 1) : 0};
    const auto us = seeded<N>(slave, facet, u_, 0);
    const Spot<T> s = spot(slave, facet, us, {T(xi[0]), T(xi[1])});
    const double weight = rule_.weights(q) * reference_area<double>(slave, facet, xi);
    put(out.position, i, s.x);
    out.weight(i) = weight;
    const auto before = gather(slave, facet, history_.u);
    Vec<T> moved;
    for (std::size_t k = 0; k < us.size(); ++k)
      moved = moved + s.f.N[k] * (us[k] - constant<T>(before[k]));
    T gap;
    Vec<T> normal;
    FacetFunctions<T> fm;
    const Facet* other = nullptr;
    if (pair_.rigid)
    {
      const auto g = gap_and_normal<T>(*pair_.rigid, pair_.rigid->place, s.x);
      gap = g.gap;
      normal = g.normal;
      moved = moved - motion_of_point<T>(pair_.rigid->pivot, history_.place, pair_.rigid->place, s.x);
    }
    else
    {
      if (not projector_)
        throw std::logic_error("a deformable master without a projector");
      const Foot foot = projector_->closest(values(s.x), values(s.normal()));
      if (foot.facet < 0)
        return;
      other = &pair_.master.facets[foot.facet];
      const auto um = seeded<N>(pair_.master, *other, u_, half_);
      const auto g = projector_->follow(foot, um, s.x);
      gap = g.gap;
      normal = g.normal;
      fm = g.f;
      out.beside(i) = foot.beside;
      const auto master_before = gather(pair_.master, *other, history_.u);
      for (std::size_t l = 0; l < um.size(); ++l)
        moved = moved - fm.N[l] * (um[l] - constant<T>(master_before[l]));
      out.facet[i] = foot.facet;
      for (int c = 0; c < out.xi.cols(); ++c)
        out.xi(i, c) = foot.xi[c];
    }
    if (out.beside(i) == 0)
      gap = gap + T(data.shift);
    out.gap(i) = value(gap);
    put(out.normal, i, normal);
    T p = data.multiplier - data.chi * gap;
    // Surfaces that touch up to rounding are given their stiffness, or a loose body would have none.
    if (p.v < (data.chi > 0 ? -data.chi * data.tolerance : 0) or data.chi == 0)
      return;
    p.v = std::max(p.v, 0.0);
    Vec<T> traction = p * normal;
    out.pressure(i) = p.v;
    if (p.v > 0)
      out.status[i] = pair_.friction > 0 ? ContactStatus::stick : ContactStatus::slip;
    if (pair_.friction > 0)
    {
      const auto friction = coulomb(data, p, normal, closed_part(data, p, facet, xi) * moved);
      traction = traction + friction.traction;
      put(out.traction, i, friction.traction);
      if (p.v > 0)
      {
        out.status[i] = friction.status;
        result.history.touched(i) = 1;
        put(result.history.traction, i, friction.traction);
      }
      put(result.history.slip, i, friction.slip);
    }
    add(result, facet, us.size(), s.f, other, fm, weight, traction);
  }

  // Gap of a point of the slave in state n.
  double gap_n(const Facet& facet, const Local& xi, double shift) const
  {
    const auto before = gather(pair_.slave, facet, history_.u);
    const Spot<double> s = spot(pair_.slave, facet, before, {xi[0], xi[1]});
    if (pair_.rigid)
      return gap_and_normal<double>(*pair_.rigid, history_.place, s.x).gap + shift;
    if (not projector_n_)
      throw std::logic_error("a deformable master without a projector of state n");
    const Foot foot = projector_n_->closest(s.x, s.normal());
    if (foot.facet < 0)
      return std::numeric_limits<double>::infinity();
    const auto master = gather(pair_.master, pair_.master.facets[foot.facet], history_.u);
    return projector_n_->follow(foot, master, s.x).gap + (foot.beside ? 0 : shift);
  }

  // How much of the step comes after closing, if lambda - chi g changes evenly in the step.
  T closed_part(const PointData& data, const T& p, const Facet& facet, const Local& xi) const
  {
    if (data.touched)
      return T(1);
    const double g = gap_n(facet, xi, data.shift), lacking = data.chi * g - data.multiplier;
    if (g <= data.tolerance or lacking <= 0)
      return T(1);
    return std::isfinite(g) ? p / (p + T(lacking)) : T(0);
  }

  void add(Penalty& result, const Facet& facet, std::size_t nodes, const FacetFunctions<T>& fs, const Facet* other,
           const FacetFunctions<T>& fm, double weight, const Vec<T>& traction) const
  {
    const int d = pair_.slave.gdim;
    std::vector<std::int64_t> columns = facet_dofs(pair_.slave, facet);
    if (other)
      for (auto dof : facet_dofs(pair_.master, *other))
        columns.push_back(dof);
    const auto put_row = [&](std::int64_t row, const T& force)
    {
      result.force(row) += force.v;
      for (std::size_t c = 0; c < columns.size(); ++c)
        if (force.d(c) != 0)
          result.tangent.emplace_back(int(row), int(columns[c]), -force.d(c));
    };
    for (std::size_t k = 0; k < nodes; ++k)
      for (int c = 0; c < d; ++c)
      {
        put_row(d * facet.nodes[k] + c, weight * fs.N[k] * traction[c]);
        if (other)
          put_row(d * other->nodes[k] + c, -weight * fm.N[k] * traction[c]);
      }
  }

  const ContactPair& pair_;
  const Rule& rule_;
  const Vector& u_;
  const ContactHistory& history_;
  int half_;
  double tolerance_;
  std::optional<Projector> projector_, projector_n_;
};
} // namespace

double ContactPair::size() const
{
  const Matrix& x = model.geometry().points;
  return (x.colwise().maxCoeff() - x.colwise().minCoeff()).maxCoeff();
}

std::vector<std::int64_t> facet_dofs(const Surface& surface, const Facet& facet)
{
  std::vector<std::int64_t> dofs;
  for (std::int64_t node : facet.nodes)
    for (int c = 0; c < surface.gdim; ++c)
      dofs.push_back(surface.gdim * node + c);
  return dofs;
}

Csr csr(const Entries& entries, std::int64_t size)
{
  Eigen::SparseMatrix<double, Eigen::RowMajor, int> m(size, size);
  m.setFromTriplets(entries.begin(), entries.end());
  Csr result;
  result.size = size;
  result.indptr.assign(m.outerIndexPtr(), m.outerIndexPtr() + size + 1);
  result.indices.assign(m.innerIndexPtr(), m.innerIndexPtr() + m.nonZeros());
  result.data.assign(m.valuePtr(), m.valuePtr() + m.nonZeros());
  return result;
}

ContactHistory no_history(const ContactPair& pair, std::int64_t num_points)
{
  const int d = pair.slave.gdim;
  return {Vector::Zero(pair.model.num_dofs()),
          {},
          Matrix::Zero(num_points, d),
          Matrix::Zero(num_points, d),
          Flags::Zero(num_points)};
}

Penalty penalty(const ContactPair& pair, const Rule& rule, const Vector& u, double chi, double chi_t,
                const ContactHistory& history, const Vector& multiplier)
{
  return with_variables(pair.slave,
                        [&](auto n) { return Evaluation<n>(pair, rule, u, history).run(chi, chi_t, multiplier); });
}
} // namespace impact_reference
