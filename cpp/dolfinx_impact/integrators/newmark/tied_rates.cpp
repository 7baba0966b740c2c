// SPDX-License-Identifier: MIT
#include "tied_rates.h"
#include "../../common/OnAllRanks.h"
#include "../../common/gather.h"
#include "../../common/text.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::integrators
{
namespace
{
constexpr double aimed_residual = 1e-14; ///< relative residual: round-off
constexpr double accepted_residual =
    1e-10; ///< relative residual that is accepted where round-off does not let it get there
constexpr int most_tied_iterations =
    500; ///< iterations; the condition of a surface's matrix does not depend on its mesh

typedef std::vector<std::vector<double>> Multipliers; ///< of each tie

double product(MPI_Comm comm, const Multipliers& a, const Multipliers& b)
{
  double sum = 0.0;
  for (std::size_t t = 0; t < a.size(); ++t)
    for (std::size_t k = 0; k < a[t].size(); ++k)
      sum += a[t][k] * b[t][k];
  return common::sum(comm, sum);
}

/// C v of all ties [L^3].
Multipliers jumps(std::span<enforcement::Tie* const> ties, std::span<const double> v)
{
  Multipliers out;
  for (const enforcement::Tie* tie : ties)
  {
    const enforcement::TieConditions& c = tie->conditions();
    std::vector<double>& jump = out.emplace_back(c.jump(v));
    const std::size_t g = c.gdim();
    for (std::size_t k = 0; k < c.rows().size(); ++k)
      for (std::size_t d = 0; d < g; ++d)
        jump[c.rows().rows[k] * g + d] *= c.rows().constrained[k * g + d] ? c.weight()[k * g + d] : 0.0;
  }
  return out;
}
} // namespace

TiedRates tied_rates(const Inertia& inertia, std::span<enforcement::Tie* const> ties,
                     std::span<const std::int8_t> fixed, std::span<const double> rates)
{
  TiedRates out{{rates.begin(), rates.end()}, {}};
  if (ties.empty())
    return out;
  const MPI_Comm comm = ties[0]->conditions().comm();
  const std::vector<double> none(rates.size(), 0.0);
  const auto moved = [&](const Multipliers& z)
  {
    std::vector<double> forces(rates.size(), 0.0);
    for (std::size_t t = 0; t < ties.size(); ++t)
    {
      const std::vector<double> part = ties[t]->conditions().forces(z[t]);
      for (std::size_t i = 0; i < forces.size(); ++i)
        forces[i] += part[i];
    }
    return inertia.accelerations(forces, fixed, none);
  };
  Multipliers left = jumps(ties, rates), z = left;
  for (auto* values : {&left, &z})
    for (std::vector<double>& part : *values)
      for (double& value : part)
        value = values == &left ? -value : 0.0;
  Multipliers direction = left;
  const double start = product(comm, left, left);
  double squared = start;
  int iterations = 0;
  for (; iterations < most_tied_iterations && squared > aimed_residual * aimed_residual * start; ++iterations)
  {
    const Multipliers image = jumps(ties, moved(direction));
    const double curvature = product(comm, direction, image);
    if (!(curvature > 0.0))
      break;
    const double step = squared / curvature;
    for (std::size_t t = 0; t < z.size(); ++t)
      for (std::size_t k = 0; k < z[t].size(); ++k)
      {
        z[t][k] += step * direction[t][k];
        left[t][k] -= step * image[t][k];
      }
    const double next = product(comm, left, left);
    for (std::size_t t = 0; t < z.size(); ++t)
      for (std::size_t k = 0; k < z[t].size(); ++k)
        direction[t][k] = left[t][k] + next / squared * direction[t][k];
    squared = next;
  }
  if (!(squared <= accepted_residual * accepted_residual * start) && start > 0.0)
    throw common::Failure("the forces of the ties at the start were not found in " + std::to_string(iterations) +
                          " iterations: the residual is " + common::text("%.1e", std::sqrt(squared)) + ", it was " +
                          common::text("%.1e", std::sqrt(start)));
  const std::vector<double> more = moved(z);
  for (std::size_t i = 0; i < out.rates.size(); ++i)
    out.rates[i] += more[i];
  out.multipliers = std::move(z);
  return out;
}
} // namespace dolfinx_impact::integrators
