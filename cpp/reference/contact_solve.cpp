// SPDX-License-Identifier: MIT
#include "contact_solve.h"
#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace impact_reference
{
namespace detail
{
System::System(const Model& model, const BodyForces& bodies, const ContactLoads& loads)
    : loads_(loads), bodies_(bodies), numbers_(free_numbers(model.elimination_order(), model.gdim(), loads.fixed_dofs)),
      num_free_(std::count_if(numbers_.begin(), numbers_.end(), [](auto n) { return n >= 0; }))
{
  if (loads.values.size() != std::int64_t(loads.fixed_dofs.size()) or loads.load.size() != model.num_dofs())
    throw std::invalid_argument(
        "a contact solution needs one value per fixed degree of freedom (" + std::to_string(loads.fixed_dofs.size()) +
        ", found " + std::to_string(loads.values.size()) + ") and a load of " + std::to_string(model.num_dofs()) +
        " entries (found " + std::to_string(loads.load.size()) + ")");
  if (not loads.values.allFinite() or not loads.load.allFinite())
    throw std::invalid_argument("a prescribed value or load is NaN or infinite");
}

Entries System::stiffness(const Vector& u) const
{
  const Csr K = bodies_.tangent(u);
  Entries entries;
  entries.reserve(K.data.size());
  for (std::int64_t i = 0; i < K.size; ++i)
    for (std::int64_t k = K.indptr[i]; k < K.indptr[i + 1]; ++k)
      entries.emplace_back(int(i), int(K.indices[k]), K.data[k]);
  return entries;
}

Vector System::free(const Vector& r) const
{
  Vector result(num_free_);
  for (std::size_t i = 0; i < numbers_.size(); ++i)
    if (numbers_[i] >= 0)
      result(numbers_[i]) = r(i);
  return result;
}

void System::correct(Vector& u, const Vector& change, const Vector& correction) const
{
  for (std::size_t i = 0; i < numbers_.size(); ++i)
    u(i) += numbers_[i] >= 0 ? correction(numbers_[i]) : change(i);
}

Vector System::missing(const Vector& u, const Vector& values) const
{
  Vector change = Vector::Zero(u.size());
  for (std::size_t k = 0; k < loads_.fixed_dofs.size(); ++k)
    change(loads_.fixed_dofs[k]) = values(k) - u(loads_.fixed_dofs[k]);
  return change;
}

Vector System::reactions(const Vector& u, const Vector& load, const Vector& contact) const
{
  const Vector r = body_force(u) - load - contact;
  Vector result = Vector::Zero(u.size());
  for (auto dof : loads_.fixed_dofs)
    result(dof) = r(dof);
  return result;
}

std::optional<Vector> solve(const Entries& entries, const Vector& right)
{
  Eigen::SparseMatrix<double> matrix(right.size(), right.size());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return solve_lu(matrix, right);
}

ContactSolution solve_in_steps(const System& system, const ContactPair& bodies, const ContactState& start,
                               const ContactOptions& options, const Step& step)
{
  if (options.steps < 1 or options.max_iterations < 1 or not(options.tolerance > 0))
    throw std::invalid_argument("steps and max_iterations must be at least 1 and tolerance positive");
  const ContactLoads& loads = system.loads_;
  const Vector values_n = loads.values - system.missing(start.u, loads.values)(loads.fixed_dofs);
  const RigidPlace place_n = start.history.place;
  ContactSolution solution;
  solution.state = start;
  double factor = 0, size = 1.0 / options.steps;
  const double smallest = options.halve ? size / 300 : size;
  std::string why = "the iteration did not converge";
  while (factor < 1 - 1e-12)
  {
    const double next = factor + size > 1 - 1e-12 ? 1 : factor + size;
    const Target target{(1 - next) * values_n + next * loads.values, (1 - next) * start.load + next * loads.load};
    ContactPair pair = bodies;
    if (pair.rigid)
      pair.rigid->place = (1 - next) * place_n + next * loads.place;
    ContactSolution trial = solution;
    bool converged = false;
    try
    {
      converged = step(pair, trial.state, target, trial);
    }
    catch (const std::domain_error& error) // turned inside out: a smaller step may not be
    {
      why = error.what();
    }
    if (converged)
    {
      trial.state.load = target.load;
      solution = std::move(trial);
      factor = next;
      continue;
    }
    size /= 2;
    if (size < smallest)
    {
      std::ostringstream text;
      text << "the contact iteration did not converge beyond " << 100 * factor << " % of the step (" << why
           << "): use more steps, and check that every body is held by supports or by closed contact";
      throw std::runtime_error(text.str());
    }
  }
  solution.reactions = system.reactions(solution.state.u, solution.state.load, solution.contact_force);
  return solution;
}
} // namespace detail

FreeSolution solve_free(const Model& model, const BodyForces& bodies, Vector u, const ContactLoads& loads,
                        const ContactOptions& options)
{
  const detail::System system(model, bodies, loads);
  Vector change = system.missing(u, loads.values);
  double correction = std::numeric_limits<double>::infinity();
  int met = 0;
  for (int iteration = 0; iteration <= options.max_iterations; ++iteration)
  {
    const Vector force = system.body_force(u);
    const double scale = system.size(u, force) + loads.load.norm();
    const Vector residual = system.free(loads.load - force);
    const double relative = scale > 0 ? residual.norm() / scale : 0;
    if (not std::isfinite(relative))
      break;
    met = relative <= options.tolerance or correction <= options.tolerance ? met + 1 : 0;
    if (iteration > 0 and met >= options.in_a_row)
      return {u, system.reactions(u, loads.load, Vector::Zero(u.size())), iteration, relative};
    Entries entries;
    Vector right = residual;
    const auto& number = system.numbers();
    for (const auto& e : system.stiffness(u))
      if (number[e.row()] >= 0 and number[e.col()] >= 0)
        entries.emplace_back(int(number[e.row()]), int(number[e.col()]), e.value());
      else if (number[e.row()] >= 0)
        right(number[e.row()]) -= e.value() * change(e.col());
    const auto x = detail::solve(entries, right);
    if (not x)
      break;
    system.correct(u, change, *x);
    const double largest = u.cwiseAbs().maxCoeff();
    correction = std::max(x->size() ? x->cwiseAbs().maxCoeff() : 0, change.cwiseAbs().maxCoeff());
    correction /= largest > 0 ? largest : 1;
    change.setZero();
  }
  throw std::runtime_error("Newton's method did not converge in a step without contact: use smaller steps");
}
} // namespace impact_reference
