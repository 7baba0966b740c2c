#include "contact_explicit.h"

namespace impact::reference
{
NodalKinematic::NodalKinematic(NodePairs pairs, double friction, int sweeps)
    : pairs_(std::move(pairs)), friction_(friction), sweeps_(sweeps)
{
  answer_ = no_contact(pairs_);
}

void NodalKinematic::after(const ContactStep& step, const Vector& predicted)
{
  const int d = pairs_.gdim();
  const Matrix slip_before = answer_.slip;
  answer_ = no_contact(pairs_);
  const auto meetings = pairs_.meet(predicted, step.n + 1);
  const Vector motion = predicted - step.u;
  const Vec<double> rigid = pairs_.master_moved(step.n + 1);

  struct Closed
  {
    std::int64_t row, node;
    const Meeting& m;
    double mass;
    Vec<double> moved, f, residual; // predicted relative motion, force, residual motion
    bool cut = false;
  };
  std::vector<Closed> closed;
  std::map<std::int64_t, double> added; // mass of masters
  for (std::size_t i = 0; i < meetings.size(); ++i)
  {
    const Meeting& m = meetings[i];
    answer_.gap(i) = m.gap;
    if (not(m.gap < 0))
      continue;
    const std::int64_t node = pairs_.nodes()[i];
    closed.push_back({std::int64_t(i), node, m, pairs_.mass(node), pairs_.relative(motion, rigid, node, m), {}, {}});
    for (std::size_t j = 0; j < m.masters.size(); ++j)
      added[m.masters[j]] += std::abs(m.phi[j]) * closed.back().mass;
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
    std::map<std::int64_t, Vec<double>> delta;
    for (Closed& c : closed)
    {
      const Vec<double>& n = c.m.normal;
      const Vec<double> so_far = pairs_.relative(moved, {}, c.node, c.m);
      c.residual = (-c.m.gap - dot(n, so_far)) * n;
      if (friction_ > 0)
        c.residual = c.residual - tangential(c.moved + so_far, n);
      for (std::size_t j = 0; j < c.m.masters.size(); ++j)
        delta[c.m.masters[j]] = delta[c.m.masters[j]] - (c.m.phi[j] * c.mass) * c.residual;
    }
    for (auto& [master, R] : delta)
      for (int k = 0; k < d; ++k)
        R[k] = step.inverse(d * master + k) > 0 ? R[k] / (pairs_.mass(master) + added.at(master)) : 0;
    for (Closed& c : closed)
    {
      const Vec<double>& n = c.m.normal;
      Vec<double> more = c.residual;
      for (std::size_t j = 0; j < c.m.masters.size(); ++j)
        more = more + c.m.phi[j] * delta.at(c.m.masters[j]);
      c.f = c.f + (c.mass / step.h) * more;
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
