// SPDX-License-Identifier: MIT
#include "contact_explicit.h"
#include <algorithm>

namespace impact_reference
{
namespace
{
Vec<double> tangential(const Vec<double>& v, const Vec<double>& n)
{
  return v - dot(v, n) * n;
}
} // namespace

NodalKinematic::NodalKinematic(NodePairs pairs, double friction, int sweeps)
    : pairs_(std::move(pairs)), gate_(pairs_.nodes().size()), friction_(friction), sweeps_(sweeps),
      was_closed_(pairs_.nodes().size(), false), absorbed_energies_(pairs_.nodes().size())
{
  answer_ = no_contact(pairs_);
}

double NodalKinematic::recoverable() const
{
  double sum = 0;
  for (const Closed& c : closed_)
    sum += std::max(0.0, absorbed_energies_[c.row].energy);
  return sum;
}

// Work of the force f on a node, and of its reaction and the forces c on the masters, in half of the relative motions
// of the steps before and after.
double NodalKinematic::work(const Closed& node, const Vec<double>& f, const std::vector<Vec<double>>& c,
                            const ContactStep& step, const Vector& motion) const
{
  const auto moved = [&](const Vector& u, int n)
  {
    double sum = dot(f, pairs_.relative(u, pairs_.master_moved(n), node.node, node.m));
    for (std::size_t j = 0; j < c.size(); ++j)
      sum += dot(c[j], pairs_.at(u, node.m.masters[j]));
    return sum;
  };
  return (moved(step.moved, step.n) + moved(motion, step.n + 1)) / 2;
}

// b_ij: forces on the masters while the force on the slave node is its normal.
std::vector<Vec<double>> NodalKinematic::weights(const Closed& node, const Vector& u) const
{
  auto b = pairs_.moment_forces(node.m.normal, u, node.node, node.m);
  for (std::size_t j = 0; j < b.size(); ++j)
    b[j] = b[j] - node.m.phi[j] * node.m.normal;
  return b;
}

// Force of a node that opens: its work is at most the node's share of the absorbed energy, its impulse at most that of
// the last steps.
// @param sums s_j
double NodalKinematic::release(const Closed& node, const ContactStep& step, const Vector& predicted,
                               const std::map<std::int64_t, double>& sums) const
{
  const Absorbed& absorbed = absorbed_energies_[node.row];
  const int d = pairs_.gdim();
  const Vec<double>& n = node.m.normal;
  const auto b = weights(node, step.u);
  double response = 0;
  for (int k = 0; k < d; ++k)
  {
    response += n[k] * n[k] * sums.at(node.node) * step.inverse(d * node.node + k);
    for (std::size_t j = 0; j < b.size(); ++j)
      if (const std::int64_t master = node.m.masters[j]; norm(b[j]) > 0)
        response += b[j][k] * b[j][k] / norm(b[j]) * sums.at(master) * step.inverse(d * master + k);
  }
  // a p + h w p^2 / 2 = E'; where a < 0 the same root without cancellation.
  const double a = work(node, n, pairs_.moment_forces(n, step.u, node.node, node.m), step, predicted - step.u);
  const double energy = step.release_share * absorbed.energy, root = std::sqrt(a * a + 2 * step.h * response * energy);
  const double force = a > 0 ? 2 * energy / (a + root) : (root - a) / (step.h * response);
  return std::min(absorbed.impulse * step.dt / step.h, force);
}

void NodalKinematic::close(const ContactStep& step, const Vector& predicted, KinematicWeights& all)
{
  for (const std::int64_t node : pairs_.nodes())
    ++all.num_surfaces[node];
  for (const auto& [node, area] : pairs_.master_areas())
    ++all.num_surfaces[node];
  slip_before_ = answer_.slip;
  answer_ = no_contact(pairs_);
  const Vector motion = predicted - step.u;
  const Approach approach(pairs_, predicted, motion, step.n + 1, step.dt);
  const Vec<double> rigid = pairs_.master_moved(step.n + 1);

  std::vector<Closed>& closed = closed_;
  closed.clear();
  for (std::size_t i = 0; i < pairs_.nodes().size(); ++i)
  {
    const Meeting m = approach.arrival(i, was_closed_[i], gate_.marked(i));
    const auto before = [&] { return approach.departure(i, was_closed_[i]); };
    answer_.gap(i) = m.gap;
    const bool may_close = gate_.lets(i, before, m, was_closed_[i]), closes = may_close and m.gap < 0;
    const bool leaves =
        was_closed_[i] and absorbed_energies_[i].energy > 0 and std::isfinite(m.gap) and m.gap >= 0 and not m.beside;
    if (closes and not was_closed_[i])
      absorbed_energies_[i] = {};
    was_closed_[i] = closes or leaves;
    if (not was_closed_[i])
      continue;
    const std::int64_t node = pairs_.nodes()[i];
    closed.push_back({std::int64_t(i), node, m, pairs_.relative(motion, rigid, node, m), {}});
    if (m.on_facet) // forces act at t_n, along the normal that the facet has then
      closed.back().m.normal = pairs_.facet_normal(m, step.u);
    closed.back().leaves = leaves;
    if (friction_ > 0)
      closed.back().carried = pairs_.carried(motion, step.u, node, closed.back().m);
  }
  // What weighs on the nodes, and in which directions.
  for (const Closed& c : closed)
  {
    Eigen::Matrix3d along = Eigen::Matrix3d::Identity();
    if (friction_ == 0)
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l)
          along(k, l) = c.m.normal[k] * c.m.normal[l];
    const auto weigh = [&](std::int64_t node, double part)
    {
      all.sums[node] += part;
      all.directions.try_emplace(node, Eigen::Matrix3d::Zero()).first->second += part * along;
    };
    const auto b = weights(c, step.u);
    weigh(c.node, 1.0);
    for (std::size_t j = 0; j < c.m.masters.size(); ++j)
      weigh(c.m.masters[j], c.leaves ? norm(b[j]) : std::abs(c.m.phi[j]));
  }
}

// Row sums of the bodies' response to the forces, component by component.
void NodalKinematic::respond(const ContactStep& step, const Vector& predicted, const KinematicWeights& all)
{
  const int d = std::min(pairs_.gdim(), 3); // no more than a Vec has
  for (Closed& c : closed_)
  {
    if (c.leaves)
      c.f = release(c, step, predicted, all.sums) * c.m.normal;
    for (int k = 0; k < d; ++k)
    {
      double sum = all.in_sweeps.at(c.node) * step.inverse(d * c.node + k);
      for (std::size_t j = 0; j < c.m.masters.size(); ++j)
        sum += std::abs(c.m.phi[j]) * all.in_sweeps.at(c.m.masters[j]) * step.inverse(d * c.m.masters[j] + k);
      c.normal += c.m.normal[k] * c.m.normal[k] * sum;
      c.across = std::max(c.across, sum);
    }
    if (not(c.normal > 1e-9 * c.across))
      c.normal = 0;
  }
}

// Forces act at t_n: there the reaction's moment is taken.
void NodalKinematic::push(Vector& force, const Closed& c, const ContactStep& step) const
{
  pairs_.add(force, c.f, c.node, c.m);
  pairs_.add_moment(force, c.f, step.u, c.node, c.m);
}

void NodalKinematic::push(const ContactStep& step, Vector& force) const
{
  for (const Closed& c : closed_)
    push(force, c, step);
}

void NodalKinematic::sweep(const ContactStep& step, const Vector& moved, int number)
{
  const double factor = (number % 2 == 0 ? 1.0 : 1.5) / step.h; // sweeps 2, 4, ... over-relaxed
  for (Closed& c : closed_)
  {
    const Vec<double>& n = c.m.normal;
    const Vec<double> so_far = pairs_.relative(moved, {}, c.node, c.m);
    if (c.normal > 0 and not c.leaves)
      c.f = c.f + (factor * (-c.m.gap - dot(n, so_far)) / c.normal) * n;
    if (friction_ > 0 and c.across > 0)
      c.f = c.f - (factor / c.across) * tangential(c.moved - c.carried + so_far, n);
    const double normal = std::max(0.0, dot(c.f, n));
    Vec<double> t;
    c.cut = true;
    if (friction_ > 0)
    {
      t = tangential(c.f, n);
      const double size = norm(t), bound = friction_ * normal;
      c.cut = size > bound;
      if (c.cut)
        t = (bound / size) * t;
    }
    c.f = normal * n + t;
  }
}

void NodalKinematic::conclude(const ContactStep& step, const Vector& moved)
{
  const int d = std::min(pairs_.gdim(), 3); // no more than a Vec has
  for (const Closed& c : closed_)
  {
    const Vec<double>& n = c.m.normal;
    const Vec<double> so_far = pairs_.relative(moved, {}, c.node, c.m), t = tangential(c.f, n);
    const Vec<double> slip = tangential(c.moved - c.carried + so_far, n);
    push(answer_.force, c, step);
    if (friction_ > 0)
      pairs_.add(answer_.tangential, t, c.node, c.m);
    answer_.total = answer_.total + c.f;
    answer_.friction = answer_.friction + t;
    answer_.gap(c.row) = c.m.gap + dot(n, so_far);
    if (not(dot(c.f, n) > 0))
      continue;
    answer_.status[c.row] = c.cut ? ContactStatus::slip : ContactStatus::stick;
    for (int k = 0; k < d; ++k)
    {
      answer_.traction(c.row, k) = friction_ > 0 ? t[k] : 0;
      answer_.slip(c.row, k) = slip_before_(c.row, k) + slip[k];
    }
  }
}

void NodalKinematic::corrected(const ContactStep& step, const Vector& next)
{
  const Vector motion = next - step.u;
  for (const Closed& c : closed_)
  {
    const Vec<double> normal = dot(c.f, c.m.normal) * c.m.normal;
    const double more = -work(c, normal, pairs_.moment_forces(c.f, step.u, c.node, c.m), step, motion);
    absorbed_ += more;
    Absorbed& absorbed = absorbed_energies_[c.row];
    if (c.leaves)
      absorbed = {};
    else
    {
      absorbed.energy += more;
      absorbed.impulse = 0.95 * absorbed.impulse + step.h / step.dt * dot(c.f, c.m.normal);
    }
  }
}
} // namespace impact_reference
