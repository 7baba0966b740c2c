// SPDX-License-Identifier: MIT
#include "PlasticBody.h"
#include "NodalPressure.h"
#include "rigid.h"
#include "solve.h"
#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace impact_reference
{
PlasticBody::PlasticBody(const Model& model, const Rule& rule, const std::map<int, J2Parameters>& laws,
                         PlasticStrain strain, Dilatation dilatation)
    : model_(model), sampler_(model.sampler(rule)), kinematics_{model.hypothesis(), strain, dilatation}
{
  if (kinematics_.hypothesis == Hypothesis::plane_stress and dilatation != Dilatation::pointwise)
    throw std::invalid_argument("plane stress goes without mean dilatation: it does not lock");
  if (not model.linear())
    throw std::invalid_argument("plasticity needs materials with the law linear_elastic: finite strain is an option of "
                                "the plastic body");
  for (const auto& [tag, parameters] : laws)
    laws_.emplace(tag, J2(parameters));
  std::map<int, bool> used;
  for (std::int64_t c = 0; c < model.num_cells(); ++c)
  {
    const auto law = laws_.find(model.tag(c));
    if (law == laws_.end())
    {
      if (finite_strain())
        throw std::invalid_argument("cell " + std::to_string(c) + " has no plastic law: in finite strain every cell " +
                                    "needs one, with a yield stress that is never reached where it stays elastic");
      continue;
    }
    used[law->first] = true;
    const Material& m = model.material(c);
    if (m.E != law->second.parameters().E or m.nu != law->second.parameters().nu)
      throw std::invalid_argument("the material of cell " + std::to_string(c) +
                                  " and its plastic law have different elastic constants");
  }
  for (const auto& [tag, law] : laws_)
    if (not used[tag])
      throw std::invalid_argument("a plastic law was given for tag " + std::to_string(tag) + ", which no cell has");
  history_.assign(model.num_cells() * sampler_.num_points(), J2::virgin(strain));
}

void PlasticBody::set_history(const std::vector<J2History>& history)
{
  if (history.size() != history_.size())
    throw std::invalid_argument("the body has " + std::to_string(history_.size()) + " points, but the history has " +
                                std::to_string(history.size()));
  history_ = history;
}

Matrix PlasticBody::stiffness_at_rest(std::int64_t cell) const
{
  const Matrix X = model_.cell_points(cell);
  const Vector still = Vector::Zero(std::int64_t(model_.cell_nodes(cell).size()) * model_.gdim());
  const auto law = laws_.find(model_.tag(cell));
  if (law == laws_.end())
    return internal(sampler_, X, model_.material(cell), still, true, cell).tangent;
  const std::vector<J2History> virgin(sampler_.num_points(), J2::virgin(kinematics_.strain));
  return plastic_internal(sampler_, X, law->second, kinematics_, still, virgin, true, cell).tangent;
}

PlasticBody::Trial PlasticBody::evaluate(const Vector& u, bool with_tangent) const
{
  model_.check_vector(u);
  if (averages_pressure_ and with_tangent)
    throw std::invalid_argument("with pressures averaged at the nodes there is no tangent here");
  const int n = sampler_.num_points();
  Trial trial;
  trial.force = Vector::Zero(u.size());
  trial.history = history_;
  trial.stress = Matrix::Zero(Eigen::Index(history_.size()), 9);
  if (with_tangent)
    trial.tangent = model_.pattern().matrix(model_.gdim());
  for (std::int64_t c = 0; c < model_.num_cells(); ++c)
  {
    const Matrix X = model_.cell_points(c);
    const Vector ue = model_.gather(u, c);
    const auto law = laws_.find(model_.tag(c));
    if (law == laws_.end())
    {
      const Internal answer = internal(sampler_, X, model_.material(c), ue, with_tangent, c);
      trial.energy += answer.energy;
      model_.scatter(trial.force, model_.gdim(), c, answer.force);
      if (with_tangent)
        model_.pattern().add(trial.tangent, model_.gdim(), model_.cell_nodes(c), answer.tangent);
      continue;
    }
    const PlasticInternal answer = plastic_internal(sampler_, X, law->second, kinematics_, ue,
                                                    std::span(history_).subspan(n * c, n), with_tangent, c);
    trial.energy += answer.energy;
    trial.work += answer.work;
    trial.dissipation += answer.dissipation;
    std::copy(answer.history.begin(), answer.history.end(), trial.history.begin() + n * c);
    for (int q = 0; q < n; ++q)
      for (int i = 0; i < 9; ++i)
        trial.stress(n * c + q, i) = answer.answers[q].stress(i / 3, i % 3);
    model_.scatter(trial.force, model_.gdim(), c, answer.force);
    if (with_tangent)
      model_.pattern().add(trial.tangent, model_.gdim(), model_.cell_nodes(c), answer.tangent);
  }
  if (averages_pressure_)
  {
    // All but a share of the volumetric part of the cells is replaced by that of the nodes.
    constexpr double replaced = 0.999;
    const bool small = not finite_strain();
    const auto law = [&](int tag)
    {
      const J2Parameters& p = laws_.at(tag).parameters();
      return plastic_law(p.E / (3 * (1 - 2 * p.nu)), small);
    };
    const NodalPressure pressure(model_);
    const NodalPressure::Answer nodes = pressure.at_nodes(u, small, law), cells = pressure.in_cells(u, small, law);
    trial.force += replaced * (nodes.force - cells.force);
    trial.energy += replaced * (nodes.energy - cells.energy);
  }
  return trial;
}

void PlasticBody::average_pressure()
{
  const NodalPressure checked(model_);
  if (kinematics_.strain == PlasticStrain::hencky or kinematics_.dilatation != Dilatation::pointwise)
    throw std::invalid_argument("pressure is averaged at nodes of small strain or Simo's law, without mean dilatation");
  for (std::int64_t c = 0; c < model_.num_cells(); ++c)
    if (not laws_.contains(model_.tag(c)))
      throw std::invalid_argument("pressure is averaged at nodes where all cells have a plastic law");
  averages_pressure_ = true;
}

namespace
{
// Newton's method on the free degrees of freedom. The tangent of Armstrong and Frederick's law is not symmetric: LU.
class Newton
{
public:
  Newton(PlasticBody& body, const std::vector<std::int64_t>& fixed_dofs, double tolerance, int max_iterations)
      : body_(body), fixed_(fixed_dofs), tolerance_(tolerance), most_(max_iterations),
        numbers_(free_numbers(body.model().elimination_order(), body.model().gdim(), fixed_dofs))
  {
  }

  // Moves u to equilibrium and commits the history; false leaves both as they were.
  bool step(Vector& u, const Vector& values, const Vector& load)
  {
    Vector next = u, change = Vector::Zero(u.size());
    for (std::size_t k = 0; k < fixed_.size(); ++k)
      change(fixed_[k]) = values(Eigen::Index(k)) - u(fixed_[k]);
    try
    {
      PlasticBody::Trial trial = body_.evaluate(next, true);
      for (int iteration = 1; iteration <= most_; ++iteration)
      {
        ++iterations;
        if (not correct(next, trial.tangent, load - trial.force, change))
          return false;
        change.setZero();
        trial = body_.evaluate(next, true);
        const double scale = trial.force.norm() + load.norm();
        residual = scale > 0 ? free(load - trial.force).norm() / scale : 0;
        if (not std::isfinite(residual))
          return false;
        if (residual <= tolerance_)
        {
          body_.commit(trial);
          u = next;
          force = trial.force;
          energy = trial.energy;
          work = trial.work;
          return true;
        }
      }
      why = "the residual did not fall";
    }
    catch (const std::domain_error& error)
    {
      why = error.what();
    }
    return false;
  }

  int iterations = 0;
  double residual = 0, energy = 0, work = 0;
  Vector force;
  std::string why = "the residual did not fall";

private:
  Vector free(const Vector& r) const
  {
    Vector result(std::count_if(numbers_.begin(), numbers_.end(), [](auto n) { return n >= 0; }));
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      if (numbers_[i] >= 0)
        result(numbers_[i]) = r(Eigen::Index(i));
    return result;
  }

  bool correct(Vector& u, const Csr& K, const Vector& residual, const Vector& change)
  {
    const Vector right = free(residual - K.dot(change));
    u += change;
    if (right.size() == 0)
      return true;
    Eigen::SparseMatrix<double> reduced = reduce(K, numbers_);
    reduced.makeCompressed();
    const std::optional<Vector> solved = solve_lu(reduced, right);
    if (not solved)
    {
      why = "the tangent became singular";
      return false;
    }
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      if (numbers_[i] >= 0)
        u(Eigen::Index(i)) += (*solved)(numbers_[i]);
    return true;
  }

  PlasticBody& body_;
  const std::vector<std::int64_t>& fixed_;
  double tolerance_;
  int most_;
  std::vector<std::int64_t> numbers_;
};
} // namespace

PlasticStates solve_plastic(PlasticBody& body, const std::vector<std::int64_t>& fixed_dofs, const Vector& u0,
                            const Vector& load0, const Matrix& values, const Matrix& loads, double tolerance,
                            int max_iterations)
{
  const auto n = body.model().num_dofs();
  const Eigen::Index steps = values.rows();
  if (steps < 1 or values.cols() != std::int64_t(fixed_dofs.size()) or loads.rows() != steps or loads.cols() != n or
      u0.size() != n or load0.size() != n)
    throw std::invalid_argument("a path needs a row of " + std::to_string(fixed_dofs.size()) + " values and a row of " +
                                std::to_string(n) +
                                " loads for every step, and displacements and a load to start from");
  if (not values.allFinite() or not loads.allFinite() or not u0.allFinite() or not load0.allFinite())
    throw std::invalid_argument("a prescribed value or load is NaN or infinite");
  std::vector<bool> fixed(n);
  for (std::int64_t dof : fixed_dofs)
  {
    if (dof < 0 or dof >= n)
      throw std::invalid_argument("fixed degree of freedom " + std::to_string(dof) + " is out of range");
    fixed[dof] = true;
  }
  if (const std::string loose = free_rigid_motions(body.model(), fixed); not loose.empty())
    throw std::runtime_error("the stiffness is singular: these rigid motions are free: " + loose +
                             "; fix more degrees of freedom");
  Newton newton(body, fixed_dofs, tolerance, max_iterations);
  PlasticStates out{Matrix(steps, n), Matrix(steps, n), Vector(steps), Vector(steps), {}, {}};
  Vector u = u0, from_load = load0, from_values(fixed_dofs.size());
  for (std::size_t k = 0; k < fixed_dofs.size(); ++k)
    from_values(Eigen::Index(k)) = u0(fixed_dofs[k]);
  for (Eigen::Index s = 0; s < steps; ++s)
  {
    const Vector to_load = loads.row(s).transpose(), to_values = values.row(s).transpose();
    double done = 0, size = 1;
    newton.iterations = 0;
    while (done < 1)
    {
      const double next = std::min(1.0, done + size);
      if (newton.step(u, from_values + next * (to_values - from_values), from_load + next * (to_load - from_load)))
      {
        done = next;
        continue;
      }
      size /= 2;
      if (size < 1.0 / 1024)
      {
        std::ostringstream text;
        text << "Newton's method did not converge in step " << s << " beyond " << 100 * done
             << " % of it, last relative residual " << newton.residual << " (" << newton.why
             << "): use more steps or check whether the load can be carried";
        throw std::runtime_error(text.str());
      }
    }
    from_load = to_load;
    from_values = to_values;
    out.u.row(s) = u.transpose();
    out.force.row(s) = newton.force.transpose();
    out.energy(s) = newton.energy;
    out.work(s) = newton.work;
    out.iterations.push_back(newton.iterations);
    out.residuals.push_back(newton.residual);
  }
  return out;
}
} // namespace impact_reference
