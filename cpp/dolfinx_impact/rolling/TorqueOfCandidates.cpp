// SPDX-License-Identifier: MIT
#include "TorqueOfCandidates.h"
#include "../common/vectors.h"
#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <map>

namespace dolfinx_impact::rolling
{
namespace
{
constexpr double first_step = 1e-5; ///< of the speed: change of slip velocity with which the torque is looked at first
constexpr double farthest = 0.1;    ///< of the speed: changes of slip velocity beyond which the torque is out of reach
/// Accuracy of the change of spin: of slip velocities over the speed, and relative.
constexpr double absolute = 1e-16, relative = 1e-14;
constexpr std::uintmax_t most_evaluations = 100;
} // namespace

TorqueOfCandidates::Solution TorqueOfCandidates::solve(const FrictionProblem& problem, const LinearState& state) const
{
  const std::size_t num = slope.gap.size(), g = num ? slope.slip.size() / num : 1;
  double largest = 0.0;
  for (std::size_t i = 0; i < num; ++i)
    largest = std::max(largest, std::sqrt(dot(&slope.slip[i * g], &slope.slip[i * g], int(g))));
  std::vector<double> last = state.forces;
  std::string fault;
  std::map<double, double> known; // not computed twice: at a solution the sign is that of round-off
  const auto missing = [&](double change)
  {
    if (const auto found = known.find(change); found != known.end())
      return found->second;
    FrictionProblem::Solution at = problem.solve(state.plus(change, slope), last);
    last = std::move(at.forces);
    if (fault.empty())
      fault = at.fault;
    double torque = by_spin * change;
    for (std::size_t k = 0; k < last.size(); ++k)
      torque += row[k] * (last[k] - state.forces[k]);
    return known[change] = torque - wanted;
  };
  const double here = missing(0.0);
  if (largest == 0.0 || std::ranges::all_of(last, [](double f) { return f == 0.0; }))
    return {last, 0.0, no_friction};
  // A larger spin slips more and takes more torque.
  const double sign = here > 0.0 ? -1.0 : 1.0;
  double low = 0.0, high = 0.0, step = first_step * speed / largest;
  while (fault.empty())
  {
    high = sign * step;
    if (missing(high) * sign >= 0.0)
      break;
    low = high;
    step *= 4.0;
    if (step > farthest * speed / largest)
      return {last, high, out_of_reach};
  }
  if (!fault.empty() || here == 0.0)
    return {last, 0.0, fault};
  const auto [from, to] = std::minmax(low, high);
  const auto close = [&](double a, double b)
  { return std::abs(b - a) <= 2.0 * absolute * speed / largest + 2.0 * relative * std::max(std::abs(a), std::abs(b)); };
  std::uintmax_t evaluations = most_evaluations;
  const double at_from = missing(from), at_to = missing(to);
  double change = at_from == 0.0 ? from : to;
  if (at_from != 0.0 && at_to != 0.0)
  {
    const auto [a, b] = boost::math::tools::toms748_solve(missing, from, to, at_from, at_to, close, evaluations);
    change = std::abs(missing(a)) < std::abs(missing(b)) ? a : b;
  }
  FrictionProblem::Solution found = problem.solve(state.plus(change, slope), last);
  return {std::move(found.forces), change, fault.empty() ? found.fault : fault};
}
} // namespace dolfinx_impact::rolling
