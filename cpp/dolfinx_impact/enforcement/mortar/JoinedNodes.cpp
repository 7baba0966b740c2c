// SPDX-License-Identifier: MIT
#include "JoinedNodes.h"
#include <algorithm>
#include <limits>
#include <numeric>

namespace dolfinx_impact::enforcement
{
namespace
{
typedef std::vector<std::int8_t> Mask;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Covered part of a facet below which it counts as not covered, where other pairs may cover the rest: what is left out
/// is missing in the balance of pressures. By degree of the displacement; the mass matrix of a part h of a facet has a
/// condition of h^-2 and h^-4.
constexpr double least_cover[] = {0.0, 1e-6, 1e-3};
/// Nodes whose functions are covered by so much more than their whole integral lie under two masters, one behind the
/// other. Less is an overlap of masters side by side that do not feel each other.
constexpr double layered = 1.5;

/// Values where a mask is set, zero elsewhere.
std::vector<double> where(const Mask& mask, std::vector<double> values)
{
  const std::size_t block = mask.empty() ? 1 : values.size() / mask.size();
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = mask[k / block] ? values[k] : 0.0;
  return values;
}
} // namespace

void JoinedNodes::join(std::vector<MortarGeometry*> geometries, std::vector<std::vector<std::int32_t>> numbers,
                       std::size_t count)
{
  const auto joined = std::make_shared<JoinedNodes>(geometries, std::move(numbers), count);
  for (std::size_t k = 0; k < geometries.size(); ++k)
    geometries[k]->join(joined, int(k));
}

JoinedNodes::JoinedNodes(std::vector<MortarGeometry*> geometries, std::vector<std::vector<std::int32_t>> numbers,
                         std::size_t count)
    : _geometries(std::move(geometries)), _numbers(std::move(numbers)), _count(count), _sums_of(distinct()),
      _share(count, 0.0)
{
  for (std::size_t k : _sums_of)
    add(k, _geometries[k]->share(), _share);
  for (MortarGeometry* g : _geometries)
    g->set_least_cover(least_cover[g->slave().displacement.degree]);
}

std::vector<std::size_t> JoinedNodes::distinct() const
{
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < _geometries.size(); ++k)
  {
    std::vector<int> same;
    for (std::size_t i : found)
      same.push_back(_geometries[k]->slave().id == _geometries[i]->slave().id);
    MPI_Allreduce(MPI_IN_PLACE, same.data(), int(same.size()), MPI_INT, MPI_MIN, _geometries[0]->comm());
    if (std::none_of(same.begin(), same.end(), [](int s) { return s; }))
      found.push_back(k);
  }
  return found;
}

// --- sums over the pairs ---------------------------------------------------------------------------------------------

void JoinedNodes::add(std::size_t k, std::span<const double> values, std::vector<double>& sums) const
{
  const std::size_t num = _numbers[k].size(), block = sums.size() / std::max<std::size_t>(_count, 1);
  for (std::size_t i = 0; i < num; ++i)
    for (std::size_t c = 0; c < block; ++c)
      sums[_numbers[k][i] * block + c] += values[i * block + c];
}

std::vector<double> JoinedNodes::known(std::span<const double> u) const
{
  std::vector<double> out(u.begin(), u.end());
  for (const MortarGeometry* g : _geometries)
  {
    const MortarIncrement& step = g->increment;
    out.insert(out.end(), step.start.begin(), step.start.end());
    out.insert(out.end(), step.start_displacement.begin(), step.start_displacement.end());
    out.insert(out.end(), step.displacement.begin(), step.displacement.end());
    out.insert(out.end(), step.start_rotation.begin(), step.start_rotation.end());
    out.insert(out.end(), step.rotation.begin(), step.rotation.end());
    out.insert(out.end(), step.driven.begin(), step.driven.end());
    out.insert(out.end(), g->offset.begin(), g->offset.end());
  }
  return out;
}

bool JoinedNodes::differs(const std::vector<double>& state, const std::vector<double>& before) const
{
  int here = state != before;
  MPI_Allreduce(MPI_IN_PLACE, &here, 1, MPI_INT, MPI_MAX, _geometries[0]->comm());
  return here;
}

void JoinedNodes::update(std::span<const double> u)
{
  std::vector<double> state = known(u);
  if (!differs(state, _updated))
    return;
  update_all(u);
  _updated = std::move(state);
}

void JoinedNodes::forget()
{
  _updated.clear();
  _evaluated.clear();
}

GapAndSlip JoinedNodes::evaluate_at(int k, std::span<const double> u)
{
  const MortarGeometry::Elsewhere elsewhere(_geometries);
  std::vector<double> state = known(u);
  if (differs(state, _evaluated))
  {
    update_all(u);
    _evaluated = std::move(state);
  }
  const MortarGeometry& there = *_geometries[k];
  return {there.now().gap, there.slip_of(jump(k, there.moved()))};
}

/// Gaps, normals, weights and carriers of all pairs.
void JoinedNodes::update_all(std::span<const double> u)
{
  const std::size_t gdim = _geometries[0]->gdim(), num = _geometries.size();
  std::vector<double> around(_count, 0.0), area(_count, 0.0);
  for (MortarGeometry* g : _geometries)
    g->update_cover(u);
  for (std::size_t k = 0; k < num; ++k)
    add(k, _geometries[k]->now().around, around);
  for (std::size_t k : _sums_of)
    add(k, _geometries[k]->now().area, area);
  std::vector<Mask> parts;
  std::vector<double> unlocked(_count * gdim, 0.0), locked(_count * gdim, 0.0), sums(_count * gdim, 0.0);
  for (std::size_t k = 0; k < num; ++k)
  {
    MortarGeometry& g = *_geometries[k];
    Mask carriers(g.num_nodes(), 1);
    for (std::size_t i = 0; i < carriers.size() && g.master(); ++i)
      carriers[i] = around[_numbers[k][i]] > gap::least_share * area[_numbers[k][i]];
    g.integrate(carriers);
    const SlaveNodes& n = g.now();
    Mask part(g.num_nodes());
    std::vector<double> on(n.own_locked.begin(), n.own_locked.end()), off(on.size());
    for (std::size_t i = 0; i < part.size(); ++i)
      part[i] = n.participates[i] && n.own_cover[i] != 0.0;
    for (std::size_t j = 0; j < off.size(); ++j)
      off[j] = part[j / gdim] && !n.own_locked[j] ? 1.0 : 0.0;
    add(k, off, unlocked);
    add(k, on, locked);
    parts.push_back(std::move(part));
  }
  for (std::size_t k : _sums_of)
    add(k, _geometries[k]->normal_sums(), sums);
  for (std::size_t k = 0; k < num; ++k)
  {
    MortarGeometry& g = *_geometries[k];
    SlaveNodes& n = g.now();
    std::vector<double> own_sums(g.num_nodes() * gdim);
    n.locked.resize(own_sums.size());
    for (std::size_t j = 0; j < own_sums.size(); ++j)
    {
      const std::size_t at = _numbers[k][j / gdim] * gdim + j % gdim;
      own_sums[j] = sums[at];
      n.locked[j] = unlocked[at] == 0.0 && locked[at] > 0.0;
    }
    g.update_own_gap(n.locked, &own_sums);
  }
  keep_nearest(parts, around);
  std::vector<double> weight(_count, 0.0), cover(_count, 0.0), gap(_count, 0.0), any(_count, 0.0);
  for (std::size_t k = 0; k < num; ++k)
  {
    const SlaveNodes& n = _geometries[k]->now();
    add(k, where(parts[k], n.own_weight), weight);
    add(k, where(parts[k], n.own_cover), cover);
    add(k, where(parts[k], n.weighted_gap), gap);
    add(k, std::vector<double>(parts[k].begin(), parts[k].end()), any);
  }
  std::vector<Mask> carrier = carriers(parts);
  for (std::size_t k = 0; k < num; ++k)
  {
    SlaveNodes& n = _geometries[k]->now();
    const std::size_t size = parts[k].size();
    n.participates.resize(size);
    n.weight.resize(size);
    n.cover.resize(size);
    n.gap.resize(size);
    for (std::size_t i = 0; i < size; ++i)
    {
      const std::size_t at = _numbers[k][i];
      n.participates[i] = any[at] > 0.0;
      n.weight[i] = weight[at];
      n.cover[i] = cover[at];
      n.gap[i] = any[at] > 0.0 ? gap[at] / cover[at] : infinity;
    }
    n.part = std::move(parts[k]);
    n.carrier = std::move(carrier[k]);
  }
}

/// Where masters lie one behind the other only the nearest counts.
void JoinedNodes::keep_nearest(std::vector<Mask>& parts, std::span<const double> around) const
{
  std::vector<double> nearest(_count, infinity);
  const auto own_gap = [&](std::size_t k, std::size_t i)
  {
    const SlaveNodes& n = _geometries[k]->now();
    return parts[k][i] ? n.weighted_gap[i] / n.own_cover[i] : infinity;
  };
  for (std::size_t k = 0; k < parts.size(); ++k)
    for (std::size_t i = 0; i < parts[k].size(); ++i)
      nearest[_numbers[k][i]] = std::min(nearest[_numbers[k][i]], own_gap(k, i));
  for (std::size_t k = 0; k < parts.size(); ++k)
    for (std::size_t i = 0; i < parts[k].size(); ++i)
    {
      const std::size_t at = _numbers[k][i];
      if (around[at] > layered * _share[at] && own_gap(k, i) > nearest[at])
        parts[k][i] = 0;
    }
}

/// Which pair has the multiplier of each node: the first that covers enough of it, or that covers most.
std::vector<Mask> JoinedNodes::carriers(const std::vector<Mask>& parts) const
{
  std::vector<double> most(_count, -infinity);
  std::vector<std::vector<double>> rank;
  for (std::size_t k = 0; k < parts.size(); ++k)
  {
    const Mask covered = _geometries[k]->covered();
    std::vector<double>& score = rank.emplace_back(parts[k].size());
    for (std::size_t i = 0; i < score.size(); ++i)
    {
      score[i] = !parts[k][i] ? -infinity : covered[i] ? infinity : _geometries[k]->now().around[i];
      most[_numbers[k][i]] = std::max(most[_numbers[k][i]], score[i]);
    }
  }
  Mask taken(_count, 0);
  std::vector<Mask> out;
  for (std::size_t k = 0; k < parts.size(); ++k)
  {
    Mask& mine = out.emplace_back(parts[k].size());
    for (std::size_t i = 0; i < mine.size(); ++i)
    {
      const std::size_t at = _numbers[k][i];
      mine[i] = parts[k][i] && rank[k][i] == most[at] && !taken[at];
      taken[at] |= mine[i];
    }
  }
  for (std::size_t k = 0; k < parts.size(); ++k)
    for (std::size_t i = 0; i < parts[k].size(); ++i)
      out[k][i] |= !taken[_numbers[k][i]];
  return out;
}

// --- what the pairs' constraints are made of -------------------------------------------------------------------------

std::vector<double> JoinedNodes::jump(int k, std::span<const double> moved) const
{
  const MortarGeometry& here = *_geometries[k];
  const std::size_t gdim = here.gdim();
  std::vector<double> total(_count * gdim, 0.0), out(here.num_nodes() * gdim);
  for (std::size_t i = 0; i < _geometries.size(); ++i)
    add(i, where(_geometries[i]->now().part, _geometries[i]->weighted_jump(moved)), total);
  for (std::size_t j = 0; j < out.size(); ++j)
    out[j] = here.now().participates[j / gdim]
                 ? total[_numbers[k][j / gdim] * gdim + j % gdim] / here.now().cover[j / gdim]
                 : 0.0;
  return out;
}

std::vector<double> JoinedNodes::over_master(int k, std::span<const double> values) const
{
  std::vector<double> total(_count, 0.0), out;
  for (std::size_t i = 0; i < _geometries.size(); ++i)
    add(i, where(_geometries[i]->now().part, _geometries[i]->over_master(values)), total);
  for (std::int32_t number : _numbers[k])
    out.push_back(total[number]);
  return out;
}

std::vector<std::int32_t> JoinedNodes::rows_in(int k, int other) const
{
  std::vector<std::int32_t> places(_count, -1), out;
  for (std::size_t i = 0; i < _numbers[other].size(); ++i)
    places[_numbers[other][i]] = std::int32_t(i);
  for (std::int32_t number : _numbers[k])
    out.push_back(places[number]);
  return out;
}

gap::MasterRows JoinedNodes::master_rows(int k, std::span<const std::int32_t> rows) const
{
  std::vector<std::vector<std::pair<std::int64_t, double>>> lines(rows.size());
  for (std::size_t other = 0; other < _geometries.size(); ++other)
  {
    const MortarGeometry& g = *_geometries[other];
    const std::vector<std::int32_t> places = rows_in(k, int(other));
    std::vector<std::size_t> found;
    std::vector<std::int32_t> index;
    for (std::size_t r = 0; r < rows.size(); ++r)
    {
      const std::int32_t at = places[rows[r]];
      if (at >= 0 && g.now().part[at])
      {
        found.push_back(r);
        index.push_back(at);
      }
    }
    const gap::MasterRows own = g.weighted_rows(index, std::vector<double>(g.num_nodes(), 1.0));
    for (std::size_t j = 0; j < found.size(); ++j)
      for (std::int64_t p = own.pointers[j]; p < own.pointers[j + 1]; ++p)
        lines[found[j]].emplace_back(own.columns[p], own.values[p]);
  }
  gap::MasterRows out{{0}, {}, {}};
  for (std::size_t r = 0; r < rows.size(); ++r)
  {
    for (const auto& [column, value] : lines[r])
    {
      out.columns.push_back(column);
      out.values.push_back(value / _geometries[k]->now().weight[rows[r]]);
    }
    out.pointers.push_back(std::int64_t(out.columns.size()));
  }
  return out;
}

std::vector<double> JoinedNodes::forces(int k, std::span<const double> traction) const
{
  const std::size_t gdim = _geometries[k]->gdim();
  std::vector<double> by_number(_count * gdim, 0.0), out;
  add(k, where(_geometries[k]->now().carrier, {traction.begin(), traction.end()}), by_number);
  for (std::size_t i = 0; i < _geometries.size(); ++i)
  {
    const MortarGeometry& g = *_geometries[i];
    std::vector<double> own(g.num_nodes() * gdim);
    for (std::size_t j = 0; j < own.size(); ++j)
      own[j] = by_number[_numbers[i][j / gdim] * gdim + j % gdim];
    const std::vector<double> forces = g.forces(where(g.now().part, std::move(own)));
    out.resize(forces.size(), 0.0);
    std::transform(out.begin(), out.end(), forces.begin(), out.begin(), std::plus<>());
  }
  return out;
}

std::vector<double> JoinedNodes::mean(int k, std::span<const double> values) const
{
  const SlaveNodes& here = _geometries[k]->now();
  std::vector<double> total(_count, 0.0), out(_numbers[k].size());
  for (std::size_t i = 0; i < _geometries.size(); ++i)
  {
    const SlaveNodes& n = _geometries[i]->now();
    std::vector<double> weighted(n.own_cover);
    for (double& value : weighted)
      value *= values[i];
    add(i, where(n.part, std::move(weighted)), total);
  }
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = here.participates[i] ? total[_numbers[k][i]] / here.cover[i] : values[k];
  return out;
}
} // namespace dolfinx_impact::enforcement
