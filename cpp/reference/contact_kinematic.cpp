#include "contact_explicit.h"

namespace impact::reference
{
NodalKinematic::NodalKinematic(NodePairs pairs, double friction, int sweeps)
    : pairs_(std::move(pairs)), gate_(pairs_.nodes().size()), friction_(friction), sweeps_(sweeps)
{
  answer_ = no_contact(pairs_);
}

void NodalKinematic::after(const ContactStep& step, const Vector& predicted)
{
  const int d = pairs_.gdim();
  const Matrix slip_before = answer_.slip;
  const auto status_before = answer_.status;
  answer_ = no_contact(pairs_);
  const auto before = pairs_.meet(step.u, step.n), meetings = pairs_.meet(predicted, step.n + 1);
  const Vector motion = predicted - step.u;
  const Vec<double> rigid = pairs_.master_moved(step.n + 1);

  struct Closed
  {
    std::int64_t row, node;
    const Meeting& m;
    Vec<double> moved, f;          // predicted relative motion, force
    double normal = 0, across = 0; // responses: 1 / effective mass along and across the normal
    bool cut = false;
  };
  std::vector<Closed> closed;
  std::map<std::int64_t, double> weights; // of closed nodes on their masters
  for (std::size_t i = 0; i < meetings.size(); ++i)
  {
    const Meeting& m = meetings[i];
    answer_.gap(i) = m.gap;
    if (not gate_.lets(i, before[i], m, status_before[i] != ContactStatus::open) or not(m.gap < 0))
      continue;
    const std::int64_t node = pairs_.nodes()[i];
    for (std::size_t j = 0; j < m.masters.size(); ++j)
      weights[m.masters[j]] += std::abs(m.phi[j]);
    closed.push_back({std::int64_t(i), node, m, pairs_.relative(motion, rigid, node, m), {}});
  }
  // Row sums of the bodies' response to the forces, component by component.
  for (Closed& c : closed)
  {
    for (int k = 0; k < d; ++k)
    {
      double sum = step.inverse(d * c.node + k);
      for (std::size_t j = 0; j < c.m.masters.size(); ++j)
        sum += std::abs(c.m.phi[j]) * weights.at(c.m.masters[j]) * step.inverse(d * c.m.masters[j] + k);
      c.normal += c.m.normal[k] * c.m.normal[k] * sum;
      c.across = std::max(c.across, sum);
    }
    if (not(c.normal > 1e-9 * c.across))
      c.normal = 0;
  }

  // Forces act at t_n: there the reaction's moment is taken.
  const auto push = [&](Vector& force, const Closed& c)
  {
    pairs_.add(force, c.f, c.node, c.m);
    pairs_.add_moment(force, c.f, step.u, c.node, c.m);
  };
  // Motion that the forces have brought.
  const auto brought = [&]
  {
    Vector force = Vector::Zero(pairs_.num_dofs());
    for (const Closed& c : closed)
      push(force, c);
    return Vector(step.h * step.inverse.cwiseProduct(force));
  };
  const auto tangential = [](const Vec<double>& v, const Vec<double>& n) { return v - dot(v, n) * n; };

  for (int sweep = 0; sweep < sweeps_; ++sweep)
  {
    const Vector moved = brought();
    const double factor = (sweep % 2 == 0 ? 1.0 : 1.5) / step.h; // sweeps 2, 4, ... over-relaxed
    for (Closed& c : closed)
    {
      const Vec<double>& n = c.m.normal;
      const Vec<double> so_far = pairs_.relative(moved, {}, c.node, c.m);
      if (c.normal > 0)
        c.f = c.f + (factor * (-c.m.gap - dot(n, so_far)) / c.normal) * n;
      if (friction_ > 0 and c.across > 0)
        c.f = c.f - (factor / c.across) * tangential(c.moved + so_far, n);
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

  const Vector moved = brought();
  for (const Closed& c : closed)
  {
    const Vec<double>& n = c.m.normal;
    const Vec<double> so_far = pairs_.relative(moved, {}, c.node, c.m), t = tangential(c.f, n);
    const Vec<double> slip = tangential(c.moved + so_far, n);
    push(answer_.force, c);
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
      answer_.slip(c.row, k) = slip_before(c.row, k) + slip[k];
    }
  }
}
} // namespace impact::reference
