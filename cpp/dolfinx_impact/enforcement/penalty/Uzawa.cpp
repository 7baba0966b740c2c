// SPDX-License-Identifier: MIT
#include "Uzawa.h"
#include "../../common/text.h"
#include "../../operators/nodal_sums.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Part of a corner's area, weighted with its function, below which a master covers little of it.
constexpr double least_cover = 0.2;
} // namespace

Uzawa::Uzawa(std::shared_ptr<const dolfinx::common::IndexMap> map, const surface::Facets& slave,
             const surface::QuadratureRule& rule)
    : multiplier(map->size_local() + map->num_ghosts(), 0.0), _map(std::move(map)), _comm(_map->comm())
{
  const surface::FacetElement functions{slave.displacement.shape, 1};
  const int tdim = functions.tdim();
  _num_corners = functions.num_nodes();
  _table.resize(rule.weights.size() * _num_corners);
  for (std::size_t q = 0; q < rule.weights.size(); ++q)
    functions.values(rule.points.data() + q * tdim, _table.data() + q * _num_corners);
  for (std::size_t f = 0; f < slave.size(); ++f)
    _corners.insert(_corners.end(), slave.nodes_of(f), slave.nodes_of(f) + _num_corners);
  begin();
}

void Uzawa::begin()
{
  _rounds = 0;
  _penetration.fill(std::numeric_limits<double>::infinity());
}

std::optional<std::vector<double>> Uzawa::augment(std::span<const double> gap, std::span<const double> weight,
                                                  double penalty, double tolerance)
{
  multiplier = operators::from_owners(_map, std::move(multiplier), 1);
  const std::size_t per_facet = _table.size() / _num_corners;
  // Of each corner: integral of the gap where there is a master, area where there is one, whole area.
  std::vector<double> sums(3 * multiplier.size(), 0.0);
  for (std::size_t i = 0; i < gap.size(); ++i)
    for (int k = 0; k < _num_corners; ++k)
    {
      double* sum = sums.data() + 3 * _corners[i / per_facet * _num_corners + k];
      const double area = weight[i] * _table[i % per_facet * _num_corners + k];
      sum[2] += area;
      if (std::isfinite(gap[i]))
      {
        sum[0] += area * gap[i];
        sum[1] += area;
      }
    }
  sums = operators::sum_over_ranks(_map, std::move(sums), 3);
  std::vector<double> augmented(multiplier.size());
  std::vector<std::int8_t> little(multiplier.size());
  for (std::size_t node = 0; node < multiplier.size(); ++node)
  {
    const double* sum = sums.data() + 3 * node;
    const double mean = sum[1] > 0.0 ? sum[0] / sum[1] : std::numeric_limits<double>::infinity();
    augmented[node] = std::max(0.0, multiplier[node] - penalty * mean);
    little[node] = sum[1] < least_cover * sum[2];
  }
  augmented = extrapolated(std::move(augmented), little);
  double change = 0.0;
  for (std::size_t node = 0; node < multiplier.size(); ++node)
    change = std::max(change, std::abs(augmented[node] - multiplier[node]));
  change /= penalty;
  MPI_Allreduce(MPI_IN_PLACE, &change, 1, MPI_DOUBLE, MPI_MAX, _comm);
  _penetration = {_penetration[1], change};
  if (change <= tolerance)
    return {};
  multiplier = std::move(augmented);
  ++_rounds;
  std::vector<double> out(gap.size(), 0.0);
  for (std::size_t i = 0; i < out.size(); ++i)
    for (int k = 0; k < _num_corners; ++k)
      out[i] += multiplier[_corners[i / per_facet * _num_corners + k]] * _table[i % per_facet * _num_corners + k];
  return out;
}

/// Where the master covers little around a corner, its multiplier is the mean of the other corners of its facets: the
/// few points there hardly tell it from that of the next corner, and Uzawa's method would take hundreds of rounds to do
/// so. Collective.
std::vector<double> Uzawa::extrapolated(std::vector<double> values, const std::vector<std::int8_t>& little) const
{
  int any = std::ranges::any_of(little, [](std::int8_t l) { return l != 0; });
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, _comm);
  if (!any)
    return values;
  std::vector<double> sums(2 * values.size(), 0.0); // of the others' multipliers, and their number
  for (std::size_t first = 0; first < _corners.size(); first += _num_corners)
  {
    double sum = 0.0, number = 0.0;
    for (int k = 0; k < _num_corners; ++k)
      if (const std::int32_t node = _corners[first + k]; !little[node])
      {
        sum += values[node];
        number += 1.0;
      }
    for (int k = 0; k < _num_corners; ++k)
    {
      sums[2 * _corners[first + k]] += sum;
      sums[2 * _corners[first + k] + 1] += number;
    }
  }
  sums = operators::sum_over_ranks(_map, std::move(sums), 2);
  for (std::size_t node = 0; node < values.size(); ++node)
    if (little[node] && sums[2 * node + 1] > 0.0)
      values[node] = sums[2 * node] / sums[2 * node + 1];
  return values;
}

std::string Uzawa::fault(double penalty, double tolerance) const
{
  using common::text;
  const auto [before, now] = _penetration;
  std::string out = "after " + std::to_string(_rounds - 1) + " augmentations the penetration is " + text("%.3e", now) +
                    ", more than " + text("%.3e", tolerance);
  const double rate = std::isfinite(before) && before > 0.0 ? now / before : 0.0;
  if (rate > 0.0 && rate < 1.0)
  {
    const double more = std::ceil(std::log(tolerance / now) / std::log(rate));
    out += "; each takes " + text("%.1f", 100.0 * (1.0 - rate)) + "% of it away, some " + text("%.0f", more) +
           " more are needed";
  }
  return out + ". The penalty is " + text("%.3e", penalty) +
         ": take a larger one (penalty='auto' is from material and mesh), a larger tolerance, or more "
         "max_augmentations";
}
} // namespace dolfinx_impact::enforcement
