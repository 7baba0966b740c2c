// SPDX-License-Identifier: MIT
#include "NodalPair.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::enforcement
{
NodalPair::NodalPair(std::vector<std::shared_ptr<NodalContact>> directions) : _directions(std::move(directions))
{
  if (_directions.empty() || _directions.size() > 2)
    throw std::invalid_argument("the contact of a pair has one or two directions, not " +
                                std::to_string(_directions.size()));
}

ContactEnergy NodalPair::energy() const
{
  ContactEnergy sum = _directions.front()->energy();
  for (std::size_t k = 1; k < _directions.size(); ++k)
  {
    const ContactEnergy more = _directions[k]->energy();
    sum.stored += more.stored;
    sum.friction += more.friction;
    sum.normal += more.normal;
    sum.later_friction += more.later_friction;
    sum.later_normal += more.later_normal;
    sum.recoverable += more.recoverable;
  }
  return sum;
}

std::array<double, 3> NodalPair::force() const
{
  std::array<double, 3> sum = _directions.front()->force();
  for (std::size_t k = 1; k < _directions.size(); ++k) // these forces act on nodes of the pair's master
    for (std::size_t c = 0; c < 3; ++c)
      sum[c] -= _directions[k]->force()[c];
  return sum;
}

std::vector<state::State> NodalPair::saved_states() const
{
  std::vector<state::State> out;
  for (const auto& direction : _directions)
    out.push_back(direction->saved_state());
  const std::array<double, 3> all = force();
  for (state::State& state : out)
  {
    const auto values = state.values<double>("force");
    for (std::size_t c = 0; c < values.size(); ++c)
      values[c] = &state == &out.front() ? all[c] : 0.0;
  }
  return out;
}

void NodalPair::resume(const std::vector<state::State>& saved)
{
  if (saved.size() != _directions.size())
    throw std::invalid_argument("the contact of a pair has " + std::to_string(_directions.size()) +
                                " directions, states are given of " + std::to_string(saved.size()));
  for (std::size_t k = 0; k < saved.size(); ++k)
  {
    const state::State direction = saved[k].copy();
    if (k > 0)
      std::ranges::fill(direction.values<double>("force"), 0.0);
    _directions[k]->resume(direction);
  }
}

Passage NodalPair::passage() const
{
  Passage farthest;
  for (const auto& direction : _directions)
    if (const Passage passage = direction->passage(); passage.facets > farthest.facets)
      farthest = passage;
  return farthest;
}

double NodalPair::spring_frequency(std::span<const double> mass) const
{
  double square = 0.0;
  for (const auto& direction : _directions)
    square += direction->added_square_frequency(mass);
  return std::sqrt(square);
}

double NodalPair::damping_rate(std::span<const double> mass) const
{
  double rate = 0.0;
  for (const auto& direction : _directions)
    rate += direction->added_damping_rate(mass);
  return rate;
}

NodalPair balanced_penalty(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets& master,
                           NodePenaltyOptions options)
{
  options.share *= 0.5;
  auto first = std::make_shared<NodePenalty>(V, slave, master, options);
  auto second = std::make_shared<NodePenalty>(V, master, slave, options);
  return NodalPair({std::move(first), std::move(second)});
}
} // namespace dolfinx_impact::enforcement
