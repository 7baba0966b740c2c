// SPDX-License-Identifier: MIT
#include "SteadySlip.h"
#include "contact_solve.h"
#include <algorithm>
#include <set>

namespace impact_reference
{
namespace
{
using Nodal = Dual<12>; // by z, n, the increment of slip times D, and gamma

Vec<Nodal> variables(const Vec<double>& v, int first)
{
  return {Nodal::variable(v[0], first), Nodal::variable(v[1], first + 1), Nodal::variable(v[2], first + 2)};
}

// Two unit vectors orthogonal to n, the second is e_z in the plane; the first ones are along the locked axes, and their
// number.
std::pair<std::array<Vec<double>, 2>, int> tangents(const Vec<double>& n, const std::vector<int>& locked, int gdim)
{
  const Vec<double> z{0, 0, 1}, x{1, 0, 0};
  Vec<double> first = unit(cross(gdim == 2 or std::abs(n[2]) < 0.9 ? z : x, n));
  int held = 0;
  for (int c : locked)
  {
    Vec<double> axis;
    axis[c] = 1;
    axis = axis - dot(axis, n) * n;
    if (norm(axis) < std::sqrt(0.5)) // it holds the normal rather than a tangent
      continue;
    if (held == 0 and gdim == 3)
      first = unit(axis);
    held = std::min(held + 1, gdim - 1);
  }
  return {{first, cross(n, first)}, held};
}

struct NodeEquations
{
  std::vector<Nodal> rows;  // gdim
  std::vector<bool> length; // true if the row is a length, else a pressure
  ContactStatus status = ContactStatus::open;
};

// The conditions at one node: first its normal, then its tangential ones.
// @param locked directions in which nothing can slip whatever the traction: there is none along them
// @param opening gap at the start of the step of a node that was open then, else zero
NodeEquations equations(const MortarNode& node, const Vec<double>& z_value, bool active, double friction,
                        double tangential_scale, double opening, const std::vector<int>& locked, int gdim)
{
  NodeEquations e;
  const auto z = variables(z_value, 0), n = variables(node.normal.value, 3), w = variables(node.moved.value, 6),
             gamma = variables(node.gamma.value, 9);
  if (not active)
  {
    for (int c = 0; c < gdim; ++c)
      e.rows.push_back(z[c]);
    e.length.assign(gdim, false);
    return e;
  }
  const Nodal pressure = dot(z, n);
  const auto [basis, held] = tangents(node.normal.value, locked, gdim);
  const Vec<Nodal> t = z - pressure * n, s = (1 / node.cover) * (w - dot(w, n) * n);
  // A node that has closed in the step is held by p/opening per length of its way.
  const bool fresh = opening > 0;
  Vec<Nodal> trial = fresh ? Nodal(-1 / opening) * (pressure * s) : t - Nodal(tangential_scale) * s;
  for (int a = 0; a < held; ++a)
    trial = trial - dot(trial, constant<Nodal>(basis[a])) * constant<Nodal>(basis[a]);
  const double size = norm(values(trial)), bound = friction * std::max(0.0, pressure.v);
  e.status = friction > 0 and size <= bound ? ContactStatus::stick : ContactStatus::slip;
  e.rows.push_back(dot(n, gamma) / node.cover);
  e.length.push_back(true);
  for (int a = 0; a < gdim - 1; ++a)
  {
    const Vec<Nodal> along = constant<Nodal>(basis[a]);
    const bool none = friction == 0 or a < held or (e.status == ContactStatus::slip and bound == 0);
    if (none)
      e.rows.push_back(dot(along, t));
    else if (e.status == ContactStatus::stick and fresh)
      e.rows.push_back(dot(along, t - trial));
    else if (e.status == ContactStatus::stick)
      e.rows.push_back(dot(along, s));
    else
      e.rows.push_back(dot(along, t - (friction * pressure / norm(trial)) * trial));
    e.length.push_back(not none and not fresh and e.status == ContactStatus::stick);
  }
  return e;
}

Vec<double> row(const Matrix& z, std::int64_t node)
{
  return {z(node, 0), z(node, 1), z.cols() > 2 ? z(node, 2) : 0};
}

class Saddle
{
public:
  Saddle(const detail::System& system, const Rule& rule, Basis basis, const ContactOptions& options,
         const ContactState& start, const ContactPair& pair, const SteadySlip* steady)
      : system_(system), rule_(rule), basis_(basis), options_(options), steady_(steady), d_(pair.slave.gdim)
  {
    // Only to give rows and columns of the system one size: the largest stiffness over a length.
    double largest = 0;
    for (const auto& e : system.stiffness(start.u))
      largest = std::max(largest, std::abs(e.value()));
    stress_ = largest / std::pow(pair.size(), d_ - 2);
    const Mortar m = mortar(pair, rule, basis, start.u, start.history, start.z);
    for (const auto& [number, node] : m.nodes)
      if (dot(row(start.z, number), node.normal.value) > 0)
        active_.insert(number);
  }

  bool step(const ContactPair& pair, ContactState& state, const detail::Target& target, ContactSolution& solution)
  {
    const ContactState start = state;
    if (pair.friction > 0 and not steady_) // in a steady flow no node has just closed
      look_before(pair, start);
    for (double spring : {0.1, 0.01, 1.0, 0.001})
    {
      state = start;
      spring_ = spring;
      if (newton(pair, state, target, solution))
        return true;
      if (pair.friction == 0)
        break;
    }
    return false;
  }

private:
  // Which nodes the step finds open, and how far.
  void look_before(const ContactPair& pair, const ContactState& start)
  {
    ContactPair then = pair;
    if (then.rigid)
      then.rigid->place = start.history.place;
    const Mortar m = mortar(then, rule_, basis_, start.u, start.history, start.z);
    opening_.assign(start.z.rows(), std::numeric_limits<double>::infinity());
    for (const auto& [number, node] : m.nodes)
    {
      if (not node.part)
        continue;
      const double gap = dot(node.normal.value, node.gamma.value) / node.cover;
      const bool pressed = dot(row(start.z, number), node.normal.value) > 0;
      opening_[number] = pressed or gap <= 1e-12 * pair.size() ? 0.0 : gap;
    }
  }

  bool newton(const ContactPair& pair, ContactState& state, const detail::Target& target, ContactSolution& solution)
  {
    ContactHistory before = state.history;
    const double size = pair.size();
    Vector change = system_.missing(state.u, target.values);
    double correction = std::numeric_limits<double>::infinity();
    std::set<std::int64_t> active = active_;
    int met = 0;
    for (int iteration = 0; iteration <= options_.max_iterations; ++iteration)
    {
      if (steady_)
        steady_->set_back(pair, state.u, before);
      Mortar m = mortar(pair, rule_, basis_, state.u, before, state.z);
      if (drop_idle(m, state.z))
        m = mortar(pair, rule_, basis_, state.u, before, state.z);
      if (steady_)
        steady_->differentiate(m);
      const bool same = update(m, state.z, active, size);
      const Vector internal = system_.body_force(state.u);
      const Vector residual = target.load + m.force - internal;
      const double scale = system_.size(state.u, internal) + target.load.norm() + m.force.norm();
      double relative = scale > 0 ? system_.free(residual).norm() / scale : 0;
      std::vector<ContactStatus> status(state.z.rows(), ContactStatus::open);
      const Vector right = assemble(pair, m, state, before, active, change, residual, status, relative);
      if (not std::isfinite(relative))
        return false;
      const bool meets = relative <= options_.tolerance or correction <= options_.tolerance;
      met = same and status == status_ and meets ? met + 1 : 0;
      if (iteration > 0 and met >= options_.in_a_row)
      {
        finish(m, state, before, pair, solution, status);
        solution.iterations.push_back(iteration);
        solution.residuals.push_back(relative);
        active_ = active;
        return true;
      }
      status_ = status;
      const auto x = detail::solve(entries_, right);
      if (not x)
        return false;
      const double part = detail::relaxation(iteration);
      system_.correct(state.u, change, part * x->head(system_.num_free()));
      for (const auto& [node, number] : unknown_)
        state.z.row(node) += part * stress_ * x->segment(number, d_).transpose();
      const double largest = state.u.cwiseAbs().maxCoeff();
      correction = x->head(system_.num_free()).lpNorm<Eigen::Infinity>() + change.lpNorm<Eigen::Infinity>();
      correction /= largest > 0 ? largest : 1;
      change.setZero();
    }
    return false;
  }

  // Takes away multipliers of nodes that do not take part. True if there were some.
  static bool drop_idle(const Mortar& m, Matrix& z)
  {
    bool any = false;
    for (const auto& [number, node] : m.nodes)
      if (not node.part and not z.row(number).isZero(0))
      {
        z.row(number).setZero();
        any = true;
      }
    return any;
  }

  // Next active set; true if it is the same. What touches up to rounding is active.
  static bool update(const Mortar& m, const Matrix& z, std::set<std::int64_t>& active, double size)
  {
    const double largest = z.size() ? z.cwiseAbs().maxCoeff() : 0;
    std::set<std::int64_t> next;
    for (const auto& [number, node] : m.nodes)
    {
      if (not node.part)
        continue;
      const double pressure = dot(row(z, number), node.normal.value);
      const double gap = dot(node.normal.value, node.gamma.value) / node.cover;
      const bool was = active.count(number) > 0;
      if (was ? pressure >= -1e-11 * largest : gap < (largest > 0 ? -1e-12 : 1e-10) * size)
        next.insert(number);
    }
    const bool same = next == active;
    active = std::move(next);
    return same;
  }

  // On a plane of symmetry slave and master are held along the same axis: no traction can make them slip along it, and
  // there is none.
  bool is_locked(const ContactPair& pair, const Mortar& m, std::int64_t number, int c, const ContactState& state,
                 const ContactHistory& before, const Vector& change) const
  {
    const std::int64_t dof = d_ * number + c;
    if (not pair.prescribed[dof] or state.u(dof) + change(dof) != before.u(dof))
      return false;
    if (pair.rigid)
      return pair.rigid->place.displacement[c] == before.place.displacement[c] and
             norm(pair.rigid->place.angle - before.place.angle) == 0;
    return std::any_of(m.M.begin(), m.M.end(),
                       [&](const auto& e) { return e.row() == number and pair.prescribed[d_ * e.col() + c]; });
  }

  // Fills the matrix; returns the right-hand side and raises `relative` to the residual of the conditions.
  Vector assemble(const ContactPair& pair, const Mortar& m, const ContactState& state, const ContactHistory& before,
                  const std::set<std::int64_t>& active, const Vector& change, const Vector& residual,
                  std::vector<ContactStatus>& status, double& relative)
  {
    const auto& free = system_.numbers();
    unknown_.clear();
    int next = int(system_.num_free());
    for (const auto& [number, node] : m.nodes)
      if (node.part)
      {
        unknown_[number] = next;
        next += d_;
      }
    entries_.clear();
    Vector right = Vector::Zero(next);
    right.head(system_.num_free()) = system_.free(residual);
    const auto put = [&](std::int64_t row, std::int64_t dof, double value)
    {
      if (free[dof] >= 0)
        entries_.emplace_back(int(row), int(free[dof]), value);
      else
        right(row) -= value * change(dof);
    };
    Entries stiffness = system_.stiffness(state.u);
    stiffness.insert(stiffness.end(), m.tangent.begin(), m.tangent.end());
    for (const auto& e : stiffness)
      if (free[e.row()] >= 0)
        put(free[e.row()], e.col(), e.value());
    for (const auto& [list, sign] : {std::pair{&m.D, -1.0}, std::pair{&m.M, 1.0}})
      for (const auto& e : *list)
        if (unknown_.count(e.row()))
          for (int c = 0; c < d_; ++c)
            if (const auto n = free[d_ * e.col() + c]; n >= 0)
              entries_.emplace_back(int(n), unknown_.at(e.row()) + c, sign * stress_ * e.value());
    const double largest = state.z.cwiseAbs().maxCoeff(), size = pair.size();
    for (const auto& [number, first] : unknown_)
    {
      const MortarNode& node = m.nodes.at(number);
      std::vector<int> locked;
      for (int c = 0; c < d_; ++c)
        if (is_locked(pair, m, number, c, state, before, change))
          locked.push_back(c);
      const double spring = spring_ * stress_ / size;
      const double opening = opening_.empty() ? 0.0 : opening_[number];
      const auto e =
          equations(node, row(state.z, number), active.count(number) > 0, pair.friction, spring, opening, locked, d_);
      status[number] = e.status;
      for (int a = 0; a < d_; ++a)
      {
        const Nodal& r = e.rows[a];
        const double factor = e.length[a] ? stress_ : 1;
        right(first + a) -= factor * r.v;
        relative = std::max(relative, std::abs(r.v) / (e.length[a] ? size : largest > 0 ? largest : 1));
        for (int c = 0; c < d_; ++c)
          if (r.d(c) != 0)
            entries_.emplace_back(first + a, first + c, factor * stress_ * r.d(c));
        int from = 3;
        for (const NodalVector* v : {&node.normal, &node.moved, &node.gamma})
        {
          for (const auto& [dof, slope] : v->slope)
          {
            double value = 0;
            for (int c = 0; c < 3; ++c)
              value += r.d(from + c) * slope[c];
            if (value != 0)
              put(first + a, dof, factor * value);
          }
          from += 3;
        }
      }
    }
    return right;
  }

  void finish(const Mortar& m, ContactState& state, const ContactHistory& before, const ContactPair& pair,
              ContactSolution& solution, const std::vector<ContactStatus>& status) const
  {
    solution.contact_force = m.force;
    solution.status = status;
    solution.pressure = Vector::Zero(state.z.rows());
    solution.gap = Vector::Constant(state.z.rows(), std::numeric_limits<double>::infinity());
    for (const auto& [number, node] : m.nodes)
      if (node.part)
      {
        solution.pressure(number) = dot(row(state.z, number), node.normal.value);
        solution.gap(number) = dot(node.normal.value, node.gamma.value) / node.cover;
      }
    state.history = before;
    state.history.u = state.u;
    if (pair.rigid)
      state.history.place = pair.rigid->place;
  }

  const detail::System& system_;
  const Rule& rule_;
  Basis basis_;
  const ContactOptions& options_;
  const SteadySlip* steady_;
  int d_;
  double stress_;
  double spring_ = 0.1; // how strongly slip decides between stick and slip; no part of the solution
  std::set<std::int64_t> active_;
  std::vector<double> opening_; // by node, empty without friction
  std::vector<ContactStatus> status_;
  std::map<std::int64_t, int> unknown_;
  Entries entries_;
};
} // namespace

ContactSolution solve_lagrange(const ContactPair& pair, const BodyForces& bodies, const Rule& contact_rule, Basis basis,
                               const ContactState& start, const ContactLoads& loads, const ContactOptions& options,
                               const SteadySlip* steady)
{
  const detail::System system(pair.model, bodies, loads);
  Saddle saddle(system, contact_rule, basis, options, start, pair, steady);
  return detail::solve_in_steps(system, pair, start, options,
                                [&](const ContactPair& now, ContactState& state, const detail::Target& target,
                                    ContactSolution& solution) { return saddle.step(now, state, target, solution); });
}
} // namespace impact_reference
