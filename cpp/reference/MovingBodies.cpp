// SPDX-License-Identifier: MIT
#include "MovingBodies.h"
#include "contact_solve.h"
#include <stdexcept>

namespace impact_reference
{
namespace
{
// Velocities of a cell's nodes as its kinetic energy sees them: rows nodes, columns nodes.
Eigen::MatrixXd seen_velocities(const Model& model, std::int64_t cell, const std::vector<bool>& redistributed)
{
  const auto nodes = model.cell_nodes(cell);
  const auto n = Eigen::Index(nodes.size());
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index c = 0; c < n; ++c)
  {
    if (not redistributed[nodes[c]])
      continue;
    Eigen::RowVectorXd weights = Eigen::RowVectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i)
      if (not redistributed[nodes[i]])
        weights(i) = 1 / (model.field().points.row(nodes[i]) - model.field().points.row(nodes[c])).squaredNorm();
    if (weights.sum() > 0)
      T.row(c) = weights / weights.sum();
  }
  return T;
}

Matrix redistribute(const Matrix& m, const Eigen::MatrixXd& T, int d)
{
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(m.rows(), m.cols());
  for (Eigen::Index i = 0; i < T.rows(); ++i)
    for (Eigen::Index k = 0; k < T.cols(); ++k)
      for (int a = 0; a < d; ++a)
        all(d * i + a, d * k + a) = T(i, k);
  const Matrix m_all = m.lazyProduct(all);
  return all.transpose().lazyProduct(m_all);
}

Matrix lumped_cell(const Vector& lumped, const Eigen::MatrixXd& T, int d)
{
  Matrix result = Matrix::Zero(lumped.size(), lumped.size());
  for (Eigen::Index i = 0; i < T.rows(); ++i)
    for (Eigen::Index k = 0; k < T.cols(); ++k)
      for (int a = 0; a < d; ++a)
        result(d * k + a, d * k + a) += T(i, k) * lumped(d * i + a);
  return result;
}
} // namespace

MovingBodies::MovingBodies(std::unique_ptr<BodyForces> internal, Csr mass, double alpha, double beta)
    : internal_(std::move(internal)), mass_(std::move(mass)), alpha_(alpha), beta_(beta),
      unit_size_(internal_->unit_size())
{
  if (not(alpha >= 0) or not(beta >= 0) or not std::isfinite(alpha) or not std::isfinite(beta))
    throw std::invalid_argument("the factors of Rayleigh's damping must not be negative");
}

void MovingBodies::set_motion(StepMotion motion)
{
  for (const Vector* v : {&motion.start, &motion.a_slope, &motion.a_rest, &motion.v_slope, &motion.v_rest})
    if (v->size() != mass_.size or not v->allFinite())
      throw std::invalid_argument("the motion of a step needs " + std::to_string(mass_.size) + " finite values");
  motion_ = std::move(motion);
}

Vector MovingBodies::acceleration(const Vector& u) const
{
  return motion_.a_slope.cwiseProduct(u - motion_.start) + motion_.a_rest;
}

Vector MovingBodies::velocity(const Vector& u) const
{
  return motion_.v_slope.cwiseProduct(u - motion_.start) + motion_.v_rest;
}

Vector MovingBodies::damping_force(const Vector& u, const Vector& v) const
{
  Vector result = Vector::Zero(u.size());
  if (alpha_ > 0)
    result += alpha_ * mass_.dot(v);
  if (beta_ > 0)
    result += beta_ * internal_->damping_stiffness(u).dot(v);
  if (internal_->dashpots())
    result += internal_->dashpots()->dot(v);
  return result;
}

Vector MovingBodies::force(const Vector& u) const
{
  return mass_.dot(acceleration(u)) + damping_force(u, velocity(u)) + internal_->force(u);
}

Csr MovingBodies::tangent(const Vector& u) const
{
  Csr result = internal_->tangent(u);
  if (result.indices != mass_.indices)
    throw std::logic_error("mass and stiffness have different patterns");
  const Csr damping = beta_ > 0 ? internal_->damping_stiffness(u) : Csr{};
  const Csr* dashpots = internal_->dashpots();
  for (std::int64_t i = 0; i < result.size; ++i)
    for (std::int64_t k = result.indptr[i]; k < result.indptr[i + 1]; ++k)
    {
      const std::int64_t j = result.indices[k];
      const double M = mass_.data[k],
                   C = alpha_ * M + (beta_ > 0 ? beta_ * damping.data[k] : 0) + (dashpots ? dashpots->data[k] : 0);
      result.data[k] += M * motion_.a_slope(j) + C * motion_.v_slope(j);
    }
  return result;
}

double MovingBodies::size(const Vector& u, const Vector& force) const
{
  return mass_.dot(motion_.a_slope.cwiseProduct(u - motion_.start)).norm() + mass_.dot(motion_.a_rest).norm() +
         internal_->force(u).norm() + force.norm() + 0.1 * unit_size_;
}

Csr inertia_matrix(const Model& model, const Rule& rule, const std::string& lumping,
                   const std::vector<bool>& redistributed)
{
  if (not redistributed.empty() and std::int64_t(redistributed.size()) != model.field().points.rows())
    throw std::invalid_argument("redistribution of mass needs a flag per node");
  const int d = model.gdim();
  const auto& cell_type = model.geometry().cell;
  const Sampler sampler = model.sampler(rule);
  const bool lumped = lumping != "consistent";
  const LumpedMass lump(cell_type, model.field().degree, model.geometry().degree, rule,
                        model.hypothesis() == Hypothesis::axisymmetric, lumped ? lumping : "auto");
  Csr result = model.pattern().matrix(d);
  for (std::int64_t c = 0; c < model.num_cells(); ++c)
  {
    const Matrix X = model.cell_points(c);
    const auto nodes = model.cell_nodes(c);
    const Eigen::MatrixXd T =
        seen_velocities(model, c, redistributed.empty() ? std::vector<bool>(model.num_dofs()) : redistributed);
    const Matrix cell = lumped ? lumped_cell(lump(X, model.material(c), c), T, d)
                               : redistribute(mass(sampler, X, model.material(c), c), T, d);
    model.pattern().add(result, d, nodes, cell);
  }
  if (not lumped)
    result.add(model.added_mass());
  else
  {
    const Vector rows = model.added_mass().dot(Vector::Ones(result.size));
    for (std::int64_t i = 0; i < result.size; ++i)
      for (std::int64_t k = result.indptr[i]; k < result.indptr[i + 1]; ++k)
        if (result.indices[k] == i)
          result.data[k] += rows(i);
  }
  return result;
}

Vector solve_acceleration(const Csr& mass, const Vector& force, Vector a, const std::vector<bool>& unknown)
{
  std::vector<int> number(unknown.size(), -1);
  int n = 0;
  for (std::size_t i = 0; i < unknown.size(); ++i)
    if (unknown[i])
      number[i] = n++;
  Entries entries;
  Vector right(n);
  for (std::int64_t i = 0; i < mass.size; ++i)
  {
    if (number[i] < 0)
      continue;
    right(number[i]) = force(i);
    for (std::int64_t k = mass.indptr[i]; k < mass.indptr[i + 1]; ++k)
      if (const std::int64_t j = mass.indices[k]; number[j] >= 0)
        entries.emplace_back(number[i], number[j], mass.data[k]);
      else
        right(number[i]) -= mass.data[k] * a(j);
  }
  const auto x = detail::solve(entries, right);
  if (not x)
    throw std::runtime_error("the mass matrix is singular: give every material a density");
  for (std::size_t i = 0; i < unknown.size(); ++i)
    if (unknown[i])
      a(std::int64_t(i)) = (*x)(number[i]);
  return a;
}
} // namespace impact_reference
