// SPDX-License-Identifier: MIT
#include "contact_solve.h"
#include <algorithm>
#include <map>

namespace impact_reference
{
namespace
{
class PenaltySolver
{
public:
  PenaltySolver(const detail::System& system, const Surface& slave, const Rule& rule, double chi, double chi_t,
                const ContactOptions& options)
      : system_(system), rule_(rule), chi_(chi), chi_t_(chi_t), options_(options),
        corners_(corner_functions(slave, rule))
  {
  }

  // From a converged state to the next; Uzawa's rounds if wanted.
  bool step(const ContactPair& pair, ContactState& state, const detail::Target& target, ContactSolution& solution)
  {
    const ContactHistory before = state.history; // of the last step, not of the last round
    if (state.multiplier.size() == 0)
      state.multiplier = Vector::Zero(corners_.cols());
    solution.iterations.push_back(0);
    solution.residuals.push_back(0);
    for (int round = 0; round < 500; ++round)
    {
      if (not equilibrium(pair, state, target, before, solution))
        return false;
      if (not options_.augmented)
        return true;
      const Vector next = augment(solution.points, state.multiplier);
      if ((next - state.multiplier).lpNorm<Eigen::Infinity>() < 1e-8 * chi_ * pair.size())
        return true;
      state.multiplier = next;
    }
    return false;
  }

private:
  // Linear functions of the corners at every slave point: rows points, columns corners.
  static Eigen::SparseMatrix<double> corner_functions(const Surface& slave, const Rule& rule)
  {
    std::map<std::int64_t, int> number;
    for (const Facet& facet : slave.facets)
      for (auto vertex : facet.vertices)
        number.try_emplace(vertex, int(number.size()));
    Entries entries;
    int point = 0;
    for (const Facet& facet : slave.facets)
      for (int q = 0; q < rule.weights.size(); ++q, ++point)
      {
        const Local xi{rule.points(q, 0), slave.tdim() == 2 ? rule.points(q, 1) : 0};
        const auto f = facet_functions<double>(slave.type, 1, xi);
        for (std::size_t v = 0; v < facet.vertices.size(); ++v)
          entries.emplace_back(point, number.at(facet.vertices[v]), f.N[v]);
      }
    Eigen::SparseMatrix<double> result(point, number.size());
    result.setFromTriplets(entries.begin(), entries.end());
    return result;
  }

  // Uzawa's step: the corners' multipliers grow with the mean penetration around them. Points without master do not
  // count; a corner that has no other loses its multiplier.
  Vector augment(const ContactPoints& points, const Vector& multiplier) const
  {
    Vector weight = points.weight, gap = points.gap;
    for (int q = 0; q < gap.size(); ++q)
      if (not std::isfinite(gap(q)))
        weight(q) = gap(q) = 0;
    const Vector sum = corners_.transpose() * weight, mean = corners_.transpose() * weight.cwiseProduct(gap);
    Vector next = Vector::Zero(sum.size());
    for (int c = 0; c < sum.size(); ++c)
      if (sum(c) > 0)
        next(c) = std::max(0.0, multiplier(c) - chi_ * mean(c) / sum(c));
    return next;
  }

  bool equilibrium(const ContactPair& pair, ContactState& state, const detail::Target& target,
                   const ContactHistory& before, ContactSolution& solution)
  {
    ContactState trial = state;
    bool converged = newton(pair, trial, target, before, chi_t_, solution);
    // Points that slip to and fro: come from soft tangential springs, which stick, to the hard ones.
    ContactState good = state;
    double soft = 1e-4, ratio = 10;
    while (not converged and pair.friction > 0 and ratio > 1.05)
    {
      trial = good;
      if (newton(pair, trial, target, before, soft * chi_t_, solution))
      {
        good = trial;
        converged = soft == 1;
        soft = std::min(1.0, soft * ratio);
      }
      else
      {
        ratio = std::sqrt(ratio);
        soft /= ratio;
      }
    }
    if (converged)
      state = trial;
    return converged;
  }

  bool newton(const ContactPair& pair, ContactState& state, const detail::Target& target, const ContactHistory& before,
              double chi_t, ContactSolution& solution)
  {
    Vector change = system_.missing(state.u, target.values);
    double correction = std::numeric_limits<double>::infinity();
    const Vector lambda = corners_ * state.multiplier;
    int met = 0;
    for (int iteration = 0; iteration <= options_.max_iterations; ++iteration)
    {
      const Penalty contact = penalty(pair, rule_, state.u, chi_, chi_t, before, lambda);
      const Vector internal = system_.body_force(state.u);
      const Vector residual = target.load + contact.force - internal;
      const double scale = system_.size(state.u, internal) + target.load.norm() + contact.force.norm();
      const double relative = scale > 0 ? system_.free(residual).norm() / scale : 0;
      if (not std::isfinite(relative))
        return false;
      met = relative <= options_.tolerance or correction <= options_.tolerance ? met + 1 : 0;
      if (iteration > 0 and met >= options_.in_a_row)
      {
        solution.residuals.back() = relative;
        solution.contact_force = contact.force;
        solution.points = contact.points;
        state.history = contact.history;
        return true;
      }
      Entries entries = system_.stiffness(state.u), reduced;
      entries.insert(entries.end(), contact.tangent.begin(), contact.tangent.end());
      Vector right = system_.free(residual);
      const auto& number = system_.numbers();
      for (const auto& e : entries)
        if (number[e.row()] >= 0 and number[e.col()] >= 0)
          reduced.emplace_back(int(number[e.row()]), int(number[e.col()]), e.value());
        else if (number[e.row()] >= 0)
          right(number[e.row()]) -= e.value() * change(e.col());
      const auto x = detail::solve(reduced, right);
      if (not x)
        return false;
      system_.correct(state.u, change, detail::relaxation(iteration) * *x);
      const double size = state.u.cwiseAbs().maxCoeff();
      correction = std::max(x->size() ? x->cwiseAbs().maxCoeff() : 0, change.cwiseAbs().maxCoeff());
      correction /= size > 0 ? size : 1;
      change.setZero();
      ++solution.iterations.back();
    }
    return false;
  }

  const detail::System& system_;
  const Rule& rule_;
  double chi_, chi_t_;
  const ContactOptions& options_;
  Eigen::SparseMatrix<double> corners_;
};
} // namespace

ContactSolution solve_penalty(const ContactPair& pair, const BodyForces& bodies, const Rule& contact_rule, double chi,
                              double chi_t, const ContactState& start, const ContactLoads& loads,
                              const ContactOptions& options)
{
  const detail::System system(pair.model, bodies, loads);
  PenaltySolver solver(system, pair.slave, contact_rule, chi, chi_t, options);
  return detail::solve_in_steps(system, pair, start, options,
                                [&](const ContactPair& now, ContactState& state, const detail::Target& target,
                                    ContactSolution& solution) { return solver.step(now, state, target, solution); });
}
} // namespace impact_reference
