#include "contact_explicit.h"
#include <algorithm>

namespace impact::reference
{
NodalPenalty::NodalPenalty(std::vector<NodePairs> directions, double friction, double penalty)
    : friction_(friction), penalty_(penalty), part_(1.0 / double(directions.size()))
{
  answer_ = no_contact(directions[0]);
  for (NodePairs& pairs : directions)
  {
    const ContactAnswer none = no_contact(pairs);
    const std::size_t count = none.status.size();
    directions_.push_back({std::move(pairs), std::vector<double>(count, none.gap(0)), std::vector<bool>(count, false),
                           none.traction, none.slip});
  }
}

double NodalPenalty::stiffness(const NodePairs& pairs, std::int64_t node, const Meeting& m, double dt) const
{
  if (penalty_ > 0)
    return part_ * penalty_ * pairs.area(node);
  return part_ * 0.5 / (dt * dt * pairs.compliance(node, m));
}

void NodalPenalty::before(const ContactStep& step)
{
  const double dissipated = answer_.dissipated;
  answer_ = no_contact(directions_[0].pairs);
  answer_.dissipated = dissipated;
  for (std::size_t k = 0; k < directions_.size(); ++k)
    evaluate(directions_[k], step, k == 0);
}

namespace
{
// Mean penetration over the gaps from g - |r| / 2 to g + |r| / 2.
double overlap(double g, double r)
{
  const double half = std::abs(r) / 2;
  if (g >= half)
    return 0;
  if (g <= -half)
    return -g;
  return (half - g) * (half - g) / (4 * half);
}

// The part below zero of the gaps from g - r to g.
double part_below(double g, double r)
{
  if (r == 0)
    return g < 0 ? 1 : 0;
  return std::clamp(-std::min(g, g - r) / std::abs(r), 0.0, 1.0);
}
} // namespace

void NodalPenalty::evaluate(Direction& direction, const ContactStep& step, bool first)
{
  const NodePairs& pairs = direction.pairs;
  const auto meetings = pairs.meet(step.u, step.n);
  // A balanced pair's total is that on the slave of the first direction.
  const double sign = first ? 1 : -1;
  for (std::size_t i = 0; i < meetings.size(); ++i)
  {
    const Meeting& m = meetings[i];
    const std::int64_t node = pairs.nodes()[i];
    double delta = 0, r = 0;
    Vec<double> moved;
    if (std::isfinite(m.gap))
    {
      moved = pairs.relative(step.moved, pairs.master_moved(step.n), node, m);
      r = dot(m.normal, moved);
      // Who passes beside an edge is not pushed.
      if (not(m.on_rim and m.gap >= 0))
        delta = overlap(m.gap, r);
      // Who was not seen in front of the surface does not belong this deep below it.
      const double gap_before = direction.gap_before[i];
      const bool came = gap_before > 0 and std::isfinite(gap_before);
      if (not direction.closed[i] and not came and -m.gap > m.width / 2)
        delta = 0;
    }
    direction.gap_before[i] = m.gap;
    direction.closed[i] = delta > 0;
    Vec<double> t, slip;
    ContactStatus status = ContactStatus::open;
    if (delta > 0)
    {
      const double k = stiffness(pairs, node, m, step.dt);
      status = ContactStatus::slip;
      answer_.stored += k * delta * delta / 2;
      if (friction_ > 0)
      {
        const Vec<double> s = part_below(m.gap, r) * (moved - r * m.normal);
        const Vec<double> before = turned(get(direction.traction, i), m.normal);
        t = before - k * s;
        const double bound = friction_ * k * delta, size = norm(t);
        status = ContactStatus::stick;
        slip = get(direction.slip, i);
        if (size > bound)
        {
          status = ContactStatus::slip;
          t = (bound / size) * t;
          const Vec<double> more = s + (1 / k) * (t - before);
          slip = slip + more;
          answer_.dissipated += norm(t) * norm(more);
        }
        answer_.stored += dot(t, t) / (2 * k);
        pairs.add(answer_.tangential, t, node, m);
        answer_.friction = answer_.friction + sign * t;
      }
      const Vec<double> f = (k * delta) * m.normal + t;
      pairs.add(answer_.force, f, node, m);
      pairs.add_moment(answer_.force, f, step.u, node, m);
      answer_.total = answer_.total + sign * f;
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
      const auto meetings = pairs.meet(u, 0);
      double highest = 0;
      for (std::size_t i = 0; i < meetings.size(); ++i)
        if (const std::int64_t node = pairs.nodes()[i]; std::isfinite(meetings[i].gap))
          highest = std::max(highest, stiffness(pairs, node, meetings[i], 1) * pairs.compliance(node, meetings[i]));
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
    const auto meetings = pairs.meet(u, 0);
    for (std::size_t i = 0; i < meetings.size(); ++i)
    {
      const Meeting& m = meetings[i];
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
} // namespace impact::reference
