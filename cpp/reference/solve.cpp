// SPDX-License-Identifier: MIT
#include "solve.h"
#include "rigid.h"
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace impact_reference
{
namespace
{
using Sparse = Eigen::SparseMatrix<double>;

// Newton's method on the free degrees of freedom; the fixed ones move to their values in the first iteration.
class Newton
{
public:
  Newton(const Model& model, const Rule& rule, const std::vector<std::int64_t>& fixed_dofs,
         const NewtonOptions& options)
      : model_(model), rule_(rule), fixed_(fixed_dofs), options_(options),
        numbers_(free_numbers(model.elimination_order(), model.gdim(), fixed_dofs))
  {
  }

  // Moves u to equilibrium under `load` with u = `values` on the fixed dofs. False if the iteration fails.
  bool step(Vector& u, const Vector& values, const Vector& load, StaticSolution& solution)
  {
    Vector change = Vector::Zero(u.size());
    for (std::size_t k = 0; k < fixed_.size(); ++k)
      change(fixed_[k]) = values(k) - u(fixed_[k]);
    Vector internal = model_.internal_force(rule_, u);
    for (int iteration = 1; iteration <= options_.max_iterations; ++iteration)
    {
      Csr K = model_.linear() ? model_.stiffness(rule_) : model_.elastic_tangent(rule_, u);
      K.add(model_.springs());
      if (not correct(u, K, load - internal, change))
        return false;
      change.setZero();
      internal = model_.internal_force(rule_, u);
      const double scale = internal.norm() + load.norm();
      const double residual = scale > 0 ? free(load - internal).norm() / scale : 0;
      if (not std::isfinite(residual))
        return false;
      if (residual <= options_.tolerance or model_.linear())
      {
        solution.iterations.push_back(iteration);
        solution.residuals.push_back(residual);
        return true;
      }
      last_residual = residual;
    }
    return false;
  }

  Vector free(const Vector& r) const
  {
    Vector result(std::count_if(numbers_.begin(), numbers_.end(), [](auto n) { return n >= 0; }));
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      if (numbers_[i] >= 0)
        result(numbers_[i]) = r(i);
    return result;
  }

  double last_residual = 0;

private:
  // Adds the correction K^-1 residual, with `change` on the fixed dofs. False if K is singular.
  bool correct(Vector& u, const Csr& K, const Vector& residual, const Vector& change)
  {
    u += change;
    const Vector right = free(residual - K.dot(change));
    if (right.size() == 0)
      return true;
    const Sparse reduced = reduce(K, numbers_);
    if (not analysed_)
      solver_.analyzePattern(reduced);
    analysed_ = true;
    solver_.factorize(reduced);
    if (solver_.info() != Eigen::Success)
      return false;
    const Vector pivots = solver_.vectorD().cwiseAbs();
    if (not(pivots.minCoeff() > 1e-15 * pivots.maxCoeff()))
      return false;
    const Vector solved = solver_.solve(right);
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      if (numbers_[i] >= 0)
        u(i) += solved(numbers_[i]);
    return true;
  }

  const Model& model_;
  const Rule& rule_;
  const std::vector<std::int64_t>& fixed_;
  NewtonOptions options_;
  std::vector<std::int64_t> numbers_;
  Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> solver_;
  bool analysed_ = false;
};
} // namespace

Sparse reduce(const Csr& matrix, const std::vector<std::int64_t>& numbers)
{
  const auto n = std::count_if(numbers.begin(), numbers.end(), [](auto i) { return i >= 0; });
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(matrix.data.size());
  for (std::int64_t i = 0; i < matrix.size; ++i)
    for (std::int64_t k = matrix.indptr[i]; k < matrix.indptr[i + 1]; ++k)
      if (numbers[i] >= 0 and numbers[matrix.indices[k]] >= 0)
        entries.emplace_back(numbers[i], numbers[matrix.indices[k]], matrix.data[k]);
  Sparse result(n, n);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

StaticSolution solve_static(const Model& model, const Rule& rule, const std::vector<std::int64_t>& fixed_dofs,
                            const Vector& values, const Vector& load, const NewtonOptions& options)
{
  if (values.size() != std::int64_t(fixed_dofs.size()) or load.size() != model.num_dofs())
    throw std::invalid_argument("solve_static needs one value per fixed degree of freedom (" +
                                std::to_string(fixed_dofs.size()) + ", found " + std::to_string(values.size()) +
                                ") and a load of " + std::to_string(model.num_dofs()) + " entries (found " +
                                std::to_string(load.size()) + ")");
  if (not values.allFinite() or not load.allFinite())
    throw std::invalid_argument("a prescribed value or load is NaN or infinite");
  if (options.steps < 1 or options.max_iterations < 1 or not(options.tolerance > 0))
    throw std::invalid_argument("steps and max_iterations must be at least 1 and tolerance positive");
  Newton newton(model, rule, fixed_dofs, options);
  std::vector<bool> fixed(model.num_dofs());
  for (std::int64_t dof : fixed_dofs)
    fixed[dof] = true;
  // Springs to the ground may hold what supports do not; the pivots tell.
  if (const std::string loose = free_rigid_motions(model, fixed); not loose.empty() and not model.on_foundation())
    throw std::runtime_error("the stiffness is singular: these rigid motions are free: " + loose +
                             "; fix more degrees of freedom");

  StaticSolution solution{Vector::Zero(model.num_dofs()), Vector::Zero(model.num_dofs()), {}, {}};
  double factor = 0, size = 1.0 / (model.linear() ? 1 : options.steps);
  const double smallest = size / 1024;
  std::string why = "the residual did not fall or the tangent became singular";
  while (factor < 1 - 1e-12)
  {
    const double next = std::min(1.0, factor + size);
    Vector u = solution.u;
    bool converged = false;
    try
    {
      converged = newton.step(u, next * values, next * load, solution);
    }
    catch (const std::domain_error& error) // the trial deformation was turned inside out: a smaller step may not be
    {
      why = error.what();
    }
    if (converged)
    {
      solution.u = u;
      factor = next;
      continue;
    }
    if (model.linear())
      throw std::runtime_error("the stiffness is singular although every rigid motion is held: use a rule with more "
                               "points or check the mesh for nearly empty cells");
    size /= 2;
    if (size < smallest)
    {
      std::ostringstream text;
      text << "Newton's method did not converge beyond " << 100 * factor << " % of the load, last relative residual "
           << newton.last_residual << " (" << why << "): use more load steps or check whether the load can be carried";
      throw std::runtime_error(text.str());
    }
  }
  const Vector out_of_balance = model.internal_force(rule, solution.u) - load;
  for (std::int64_t dof : fixed_dofs)
    solution.reactions(dof) = out_of_balance(dof);
  return solution;
}
} // namespace impact_reference
