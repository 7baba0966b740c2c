// SPDX-License-Identifier: MIT
#include "contact_explicit.h"
#include "contact_springs.h"
#include <algorithm>

namespace impact_reference
{
NodalPenalty::NodalPenalty(std::vector<NodePairs> directions, double friction, double penalty, double stiffness_step)
    : friction_(friction), penalty_(penalty), part_(1.0 / double(directions.size())), stiffness_step_(stiffness_step)
{
  answer_ = no_contact(directions[0]);
  for (NodePairs& pairs : directions)
  {
    const ContactAnswer none = no_contact(pairs);
    const std::size_t count = none.status.size();
    directions_.push_back({std::move(pairs), std::vector<Spring>(count), Gate(count), none.traction, none.slip});
  }
}

double NodalPenalty::stiffness(const NodePairs& pairs, std::int64_t node, const Meeting& m, double dt) const
{
  if (penalty_ > 0)
    return part_ * penalty_ * pairs.area(node);
  dt = stiffness_step_ > 0 ? stiffness_step_ : dt;
  double compliance = pairs.spring_compliance(node, m, dt);
  if (const RigidBall* ball = pairs.ball()) // it gives way, and the step must bear that, too
    compliance +=
        dt * dt * ball->mobility(pairs.slave_area(), friction_ > 0) / (4 * (1 / (0.9 * 0.9) - 1) * pairs.area(node));
  return part_ / compliance;
}

void NodalPenalty::before(const ContactStep& step)
{
  const double dissipated = answer_.dissipated, absorbed = answer_.absorbed;
  answer_ = no_contact(directions_[0].pairs);
  answer_.dissipated = dissipated;
  answer_.absorbed = absorbed;
  for (std::size_t k = 0; k < directions_.size(); ++k)
    evaluate(directions_[k], step, k == 0);
}

void NodalPenalty::evaluate(Direction& direction, const ContactStep& step, bool first)
{
  const NodePairs& pairs = direction.pairs;
  const Approach approach(pairs, step.u, step.moved, step.n, step.dt);
  // A balanced pair's total is that on the slave of the first direction.
  const double sign = first ? 1 : -1;
  for (std::size_t i = 0; i < pairs.nodes().size(); ++i)
  {
    const std::int64_t node = pairs.nodes()[i];
    Spring& spring = direction.springs[i];
    const Spring last = spring;
    const Meeting m = approach.arrival(i, last.closed, direction.gate.marked(i));
    const auto before = [&] { return approach.departure(i, last.closed); };
    const bool met = std::isfinite(m.gap), may_close = direction.gate.lets(i, before, m, last.closed);
    double delta = 0, r = 0;
    Vec<double> moved;
    if (met)
    {
      moved = pairs.relative(step.moved, pairs.master_moved(step.n, m.x), node, m);
      r = dot(m.normal, moved);
      // Who passes beside an edge is not pushed.
      if (may_close and not(m.beside and m.gap >= 0))
        delta = overlap(m.gap, r);
    }
    spring.closed = delta > 0;
    spring.gap = m.gap;
    spring.normal = 0;

    // What the node's force has taken in the step, but for the work of the force that is not known yet.
    double change = 0;
    Vec<double> across;
    if (spring.closed or (met and may_close))
    {
      const double most = 2 * norm(moved);
      change = last.closed ? std::clamp(m.gap - last.gap, -most, most) : r;
      across = moved - r * m.normal;
      if (friction_ > 0) // who sticks to a facet turns with it
      {
        const Vec<double> turned = pairs.carried(step.moved, step.u, node, m);
        across = across - turned + dot(turned, m.normal) * m.normal;
      }
    }
    const double k = spring.closed ? stiffness(pairs, node, m, step.dt) : last.stiffness;
    double stored = 0; // in the step before
    if (last.closed)
      stored = last.normal * last.normal / (2 * last.stiffness);
    else if (spring.closed) // below the surface when it is seen first
      stored = k * std::pow(std::max(0.0, change - m.gap), 2) / 2;
    const double a = last.e + stored - last.normal * change / 2;
    const Vec<double> t_before = get(direction.traction, i), t_rotated = rotated(t_before, m.normal);
    const double b = dot(t_before, t_before) / (2 * last.stiffness) - dot(t_rotated, across) / 2;

    Vec<double> t, slip;
    ContactStatus status = ContactStatus::open;
    if (spring.closed)
    {
      spring.stiffness = k;
      spring.normal = normal_force(k, delta, m.gap, change, a, stored);
      spring.e = a - spring.normal * (change + spring.normal / k) / 2;
      answer_.absorbed += spring.e - last.e;
      answer_.stored += spring.normal * spring.normal / (2 * k);
      status = ContactStatus::slip;
      if (friction_ > 0)
      {
        const double bound = friction_ * spring.normal;
        const Vec<double> along = part_below(m.gap, r) * across, trial = t_rotated - k * along;
        t = cut_to(trial, bound);
        bool slips = norm(trial) > bound;
        const double round_off = 1e-12 * (dot(t_before, t_before) / (2 * last.stiffness) + dot(t, t) / k);
        if (last.q + tangential_change(t, k, across, b) < -round_off)
        {
          // Project into the ball of the forces without energy deficit, around centre.
          slips = true;
          const Vec<double> centre = (-k / 2) * across;
          const double radius = std::sqrt(std::max(0.0, dot(centre, centre) + 2 * k * (last.q + b)));
          t = cut_to(centre + cut_to(t - centre, radius), bound);
        }
        slip = get(direction.slip, i);
        if (slips)
          slip = slip + along + (1 / k) * (t - t_rotated);
        else
          status = ContactStatus::stick;
        const double more = tangential_change(t, k, across, b);
        spring.q = std::min(0.0, last.q + more);
        answer_.dissipated += more;
        answer_.stored += dot(t, t) / (2 * k);
        pairs.add(answer_.tangential, t, node, m);
        answer_.friction = answer_.friction + sign * t;
      }
      const Vec<double> f = spring.normal * m.normal + t;
      pairs.add(answer_.force, f, node, m);
      pairs.add_moment(answer_.force, f, step.u, node, m);
      answer_.total = answer_.total + sign * f;
      const Vec<double> r = pairs.arm(step.n, m.x);
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
          answer_.moment(a, b) += f[a] * r[b];
      if (RigidBall* ball = pairs.ball())
        ball->add(f, m.x);
    }
    else if (last.closed)
    {
      // A deficit is kept; a surplus is dissipated.
      answer_.absorbed += a - last.e;
      spring.e = std::min(0.0, a);
      answer_.dissipated += b;
      spring.q = std::min(0.0, last.q + b);
    }
    put(direction.traction, i, t);
    put(direction.slip, i, slip);
    if (first)
    {
      answer_.gap(i) = m.gap;
      answer_.status[i] = status;
      put(answer_.traction, i, t);
      put(answer_.slip, i, slip);
    }
  }
}

double NodalPenalty::added_frequency(const Vector& u) const
{
  double sum = 0;
  if (penalty_ > 0)
    for (const Direction& direction : directions_)
    {
      const NodePairs& pairs = direction.pairs;
      const Configuration now(pairs, u, pairs.obstacle(0));
      double highest = 0;
      for (std::size_t i = 0; i < pairs.nodes().size(); ++i)
        if (const Meeting m = now.meet(i, Vector::Zero(u.size()), false); std::isfinite(m.gap))
        {
          const std::int64_t node = pairs.nodes()[i];
          highest = std::max(highest, stiffness(pairs, node, m, 1) * pairs.compliance(node, m));
        }
      if (const RigidBall* ball = pairs.ball())
        highest += part_ * penalty_ * ball->mobility(pairs.slave_area(), friction_ > 0);
      sum += highest;
    }
  return sum;
}

Entries NodalPenalty::springs(const Vector& u) const
{
  Entries entries;
  if (not(penalty_ > 0))
    return entries;
  for (const Direction& direction : directions_)
  {
    const NodePairs& pairs = direction.pairs;
    const int d = pairs.gdim();
    const Configuration now(pairs, u, pairs.obstacle(0));
    for (std::size_t i = 0; i < pairs.nodes().size(); ++i)
    {
      const Meeting m = now.meet(i, Vector::Zero(u.size()), false);
      if (not std::isfinite(m.gap))
        continue;
      const double k = stiffness(pairs, pairs.nodes()[i], m, 1);
      std::vector<std::pair<std::int64_t, double>> parts{{pairs.nodes()[i], 1.0}};
      for (std::size_t j = 0; j < m.masters.size(); ++j)
        parts.emplace_back(m.masters[j], -m.phi[j]);
      for (const auto& [a, wa] : parts)
        for (const auto& [b, wb] : parts)
          for (int r = 0; r < d; ++r)
            for (int c = 0; c < d; ++c)
            {
              const double direction_part = friction_ > 0 ? double(r == c) : m.normal[r] * m.normal[c];
              entries.emplace_back(int(d * a + r), int(d * b + c), k * wa * wb * direction_part);
            }
    }
  }
  return entries;
}
} // namespace impact_reference
