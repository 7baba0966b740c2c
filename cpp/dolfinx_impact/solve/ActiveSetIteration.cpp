// SPDX-License-Identifier: MIT
#include "ActiveSetIteration.h"
#include "../common/vectors.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::solve
{
namespace
{
constexpr std::int64_t nobody = -2; // a number that no node has
// Relative difference of the pressures of states that are the same, above the round-off of a linear solution.
constexpr double repeated = 1e-6;

bool equal(std::span<const double> a, std::span<const double> b)
{
  double difference = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
  {
    difference = std::max(difference, std::abs(a[i] - b[i]));
    largest = std::max(largest, std::abs(b[i]));
  }
  return difference <= repeated * largest;
}
} // namespace

int ActiveSetIteration::change(MultiplierContacts contacts)
{
  const bool single = _patience == 0;
  int found = 0;
  for (enforcement::MultiplierContact* contact : contacts)
    found += contact->update_active_set(false, single ? std::optional(nobody) : std::nullopt);
  ++_count;
  if (found < _best)
  {
    _best = found;
    _patience = most_patience;
  }
  else if (!single)
    --_patience;
  if (single && found)
  {
    const auto at = std::ranges::find_if(contacts, [](const auto* c) { return c->last_change() >= 0; });
    enforcement::MultiplierContact* contact = at == contacts.end() ? contacts.front() : *at;
    contact->update_active_set(false, _patience ? std::nullopt : std::optional(contact->last_change()));
  }
  return found;
}

bool RepeatedStates::stops(MultiplierContacts contacts)
{
  std::vector<State> state;
  for (const enforcement::MultiplierContact* c : contacts)
    state.push_back({common::copy_of(c->active()), common::copy_of(c->sliding()), common::copy_of(c->multiplier())});
  std::vector<int> same;
  for (const std::vector<State>& before : _states)
    same.push_back(std::ranges::equal(
        state, before, [](const State& a, const State& b)
        { return a.active == b.active && a.sliding == b.sliding && equal(a.multiplier, b.multiplier); }));
  MPI_Allreduce(MPI_IN_PLACE, same.data(), int(same.size()), MPI_INT, MPI_MIN, _comm);
  _states.push_back(std::move(state));
  const auto last = std::find(same.rbegin(), same.rend(), 1);
  if (last != same.rend() && !_end)
  {
    const std::size_t again = same.rend() - last - 1, period = _states.size() - 1 - again;
    _end = _states.size() + std::size_t(_later) % period;
  }
  return _end && _states.size() >= *_end;
}

void RepeatedStates::forget()
{
  _states.clear();
  _end.reset();
}
} // namespace dolfinx_impact::solve
