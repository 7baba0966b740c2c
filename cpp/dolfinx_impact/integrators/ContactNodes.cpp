// SPDX-License-Identifier: MIT
#include "ContactNodes.h"
#include "../common/clones.h"
#include "../common/columns.h"
#include "../common/prefetch.h"
#include <algorithm>
#include <numeric>
#include <utility>

namespace dolfinx_impact::integrators
{
namespace
{
using common::Column, common::column;

/// Calls f<components, entries per node>().
auto with_layout(const NodalFields& fields, const auto& f)
{
  return fields.bs == 2       ? f.template operator()<2, 2>()
         : fields.is_padded() ? f.template operator()<3, 4>()
                              : f.template operator()<3, 3>();
}

/// Nodes of a surface are scattered over the fields: the memory is asked for those that come after so many others.
constexpr std::size_t nodes_ahead = 32;

/// Ask the memory for the values of one of the next nodes, which may lie in two lines of the cache.
/// @param[in] k position of the present node
template <int D, int stride>
inline void prefetch(std::span<const std::int32_t> nodes, std::size_t k, std::span<const double> values)
{
  if (k + nodes_ahead >= nodes.size())
    return;
  const double* next = values.data() + std::size_t(nodes[k + nodes_ahead]) * stride;
  common::prefetch(next);
  if constexpr (stride != 4) // padded nodes lie in one line
    common::prefetch(next + D - 1);
}

/// Least and largest values by component, collected node by node.
template <int D>
struct Extremes
{
  double least[D], largest[D];
  Extremes()
  {
    std::fill_n(least, D, enforcement::IncrementRange::infinity);
    std::fill_n(largest, D, -enforcement::IncrementRange::infinity);
  }
  void add(int c, double value)
  {
    least[c] = std::min(least[c], value);
    largest[c] = std::max(largest[c], value);
  }
  enforcement::IncrementRange range() const
  {
    enforcement::IncrementRange out;
    std::copy_n(least, D, out.least.begin());
    std::copy_n(largest, D, out.largest.begin());
    return out;
  }
};

/// Values of padded nodes, which are whole registers; that of a node reaches into the next one, which is stored after
/// it. Nodes up to the last one.
/// @param[out] u, du, v by node; v null: not wanted
/// @param[out] least, largest increments, springs' work by component
IMPACT_CLONES void gather_padded(std::span<const std::int32_t> nodes, const NodalFields& fields, double dt, double* u,
                                 double* du, double* v, const double* springs, double* least, double* largest,
                                 double* work)
{
  constexpr double infinity = enforcement::IncrementRange::infinity;
  const Column step = {dt, dt, dt, dt};
  Column low = {infinity, infinity, infinity, infinity}, high = -low, sum = {};
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k)
  {
    prefetch<3, 4>(nodes, k, fields.u);
    prefetch<3, 4>(nodes, k, fields.v);
    const std::size_t i = std::size_t(nodes[k]) * 4;
    const Column velocity = column(fields.v.data() + i), d = step * velocity;
    column(u + 3 * k) = column(fields.u.data() + i);
    column(du + 3 * k) = d;
    if (v)
      column(v + 3 * k) = velocity;
    low = d < low ? d : low;
    high = d > high ? d : high;
    sum += column(springs + 3 * k) * d;
  }
  column(least) = low;
  column(largest) = high;
  column(work) = sum;
}

/// Subtract springs' forces from those of padded nodes, up to the last one.
/// @param[out] position, increment products with displacements and their increments, by component
IMPACT_CLONES void subtract_padded(std::span<const std::int32_t> nodes, std::span<double> r, const double* springs,
                                   const double* u, const double* du, double* position, double* increment)
{
  Column by_position = {}, by_increment = {};
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k)
  {
    prefetch<3, 4>(nodes, k, r);
    const Column next = column(springs + 3 * k), force = {next[0], next[1], next[2], 0.0};
    column(r.data() + std::size_t(nodes[k]) * 4) -= force;
    by_position += force * column(u + 3 * k);
    by_increment += force * column(du + 3 * k);
  }
  column(position) = by_position;
  column(increment) = by_increment;
}
} // namespace

void ContactNodes::assign_numbers(NodalFields& fields, std::vector<std::int32_t> nodes, bool kinematic_contact)
{
  const Forces kept = forces(fields);
  _kept = {};
  _kinematic = kinematic_contact;
  _corrected = false;
  Halo& all = *fields.halo;
  const int bs = fields.bs;
  const std::int32_t owned = all.num_owned();
  if (_kinematic)
  {
    std::vector<double> corrected(all.num_nodes(), 0.0);
    for (std::int32_t node : nodes)
      corrected[node] = 1.0;
    all.forward(corrected, 1);
    for (std::int32_t node = owned; node < all.num_nodes(); ++node)
      if (corrected[node] > 0.0)
        nodes.push_back(node);
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  _nodes = std::move(nodes);
  const std::int64_t own = std::lower_bound(_nodes.begin(), _nodes.end(), owned) - _nodes.begin();
  // Global numbers, from the owners to those who have the nodes as ghosts.
  const auto& map = all.map();
  std::int64_t first = 0;
  dolfinx::MPI::check_error(map.comm(), MPI_Exscan(&own, &first, 1, MPI_INT64_T, MPI_SUM, map.comm()));
  if (dolfinx::MPI::rank(map.comm()) == 0)
    first = 0; // MPI leaves it undefined there
  _numbers.assign(all.num_nodes(), -1);
  _mass.resize(_nodes.size());
  std::vector<double> global(all.num_nodes(), -1.0);
  for (std::size_t k = 0; k < _nodes.size(); ++k)
  {
    _numbers[_nodes[k]] = std::int32_t(k);
    _mass[k] = fields.mass[std::size_t(_nodes[k]) * fields.stride];
    global[_nodes[k]] = double(first + std::int64_t(k));
  }
  all.forward(global, 1);
  std::vector<std::int64_t> ghosts;
  std::vector<int> owners;
  for (std::size_t k = own; k < _nodes.size(); ++k)
  {
    ghosts.push_back(std::int64_t(global[_nodes[k]]));
    owners.push_back(map.owners()[_nodes[k] - owned]);
  }
  if (_halo)
    _traffic += _halo->traffic();
  _halo = std::make_unique<Halo>(
      std::make_shared<const dolfinx::common::IndexMap>(map.comm(), std::int32_t(own), ghosts, owners));
  const std::size_t size = _nodes.size() * bs;
  for (std::vector<double>* values : {&u, &du, &springs, &kinematic})
    values->assign(size, 0.0);
  for (std::vector<double>* values : {&v, &v_before, &r_before, &du_before})
    values->assign(_kinematic ? size : 0, 0.0);
  inverse.resize(size);
  for (std::size_t k = 0; k < _nodes.size(); ++k)
  {
    const std::size_t i = std::size_t(_nodes[k]) * bs;
    std::copy_n(fields.inverse.data() + fields.entry(i), bs, inverse.data() + k * bs);
    if (i < fields.owned)
    {
      std::copy_n(kept.springs.data() + i, bs, springs.data() + k * bs);
      std::copy_n(kept.kinematic.data() + i, bs, kinematic.data() + k * bs);
    }
  }
}

ContactNodes::Forces ContactNodes::forces(const NodalFields& fields)
{
  if (!_kept.springs.empty())
    return _kept;
  Forces out{std::vector<double>(fields.owned, 0.0), std::vector<double>(fields.owned, 0.0)};
  if (!_halo)
    return out;
  std::vector<double> sums = springs;
  _halo->reverse(sums, fields.bs);
  for (std::size_t k = 0; k < _nodes.size(); ++k)
    if (const std::size_t i = std::size_t(_nodes[k]) * fields.bs; i < fields.owned)
    {
      std::copy_n(sums.data() + k * fields.bs, fields.bs, out.springs.data() + i);
      std::copy_n(kinematic.data() + k * fields.bs, fields.bs, out.kinematic.data() + i);
    }
  return out;
}

void ContactNodes::reset()
{
  std::fill(springs.begin(), springs.end(), 0.0);
  std::fill(kinematic.begin(), kinematic.end(), 0.0);
  _kept = {};
  _corrected = false;
}

template <int D, int stride, bool kinematic_contact>
double ContactNodes::gather_all(const NodalFields& fields, double dt, bool with_springs)
{
  double work[4] = {};
  Extremes<D> increments;
  std::size_t first = 0;
  if constexpr (stride == 4)
    if (_nodes.size() > 1)
    {
      double least[4], largest[4];
      gather_padded(_nodes, fields, dt, u.data(), du.data(), kinematic_contact ? v.data() : nullptr, springs.data(),
                    least, largest, work);
      first = _nodes.size() - 1;
      std::copy_n(least, D, increments.least);
      std::copy_n(largest, D, increments.largest);
      if (with_springs)
        std::fill_n(springs.data(), first * D, 0.0);
      else
        std::fill_n(work, D, 0.0);
    }
  for (std::size_t k = first; k < _nodes.size(); ++k)
  {
    prefetch<D, stride>(_nodes, k, fields.u);
    prefetch<D, stride>(_nodes, k, fields.v);
    for (int c = 0; c < D; ++c)
    {
      const std::size_t i = std::size_t(_nodes[k]) * stride + c, n = k * D + c;
      u[n] = fields.u[i];
      du[n] = dt * fields.v[i];
      increments.add(c, du[n]);
      if constexpr (kinematic_contact)
        v[n] = fields.v[i];
      if (with_springs)
        work[c] += std::exchange(springs[n], 0.0) * du[n];
    }
  }
  _range = increments.range();
  return std::accumulate(work, work + D, 0.0);
}

double ContactNodes::gather(const NodalFields& fields, double dt, bool with_springs)
{
  return with_layout(fields,
                     [&]<int D, int stride>()
                     {
                       return _kinematic ? gather_all<D, stride, true>(fields, dt, with_springs)
                                         : gather_all<D, stride, false>(fields, dt, with_springs);
                     });
}

ContactNodes::Products ContactNodes::add_springs(NodalFields& fields) const
{
  const auto sweep = [&]<int D, int stride>()
  {
    double position[4] = {}, work[4] = {};
    std::size_t first = 0;
    if constexpr (stride == 4)
      if (_nodes.size() > 1)
      {
        subtract_padded(_nodes, fields.r, springs.data(), u.data(), du.data(), position, work);
        first = _nodes.size() - 1;
      }
    for (std::size_t k = first; k < _nodes.size(); ++k)
    {
      prefetch<D, stride>(_nodes, k, fields.r);
      for (int c = 0; c < D; ++c)
      {
        const double force = springs[k * D + c];
        fields.r[std::size_t(_nodes[k]) * stride + c] -= force;
        position[c] += force * u[k * D + c];
        work[c] += force * du[k * D + c];
      }
    }
    return Products{std::accumulate(position, position + D, 0.0), std::accumulate(work, work + D, 0.0)};
  };
  return with_layout(fields, sweep);
}

void ContactNodes::keep(const NodalFields& fields)
{
  if (_corrected)
    std::swap(v, v_before);
  with_layout(fields,
              [&]<int D, int stride>()
              {
                for (std::size_t k = 0; k < _nodes.size(); ++k)
                {
                  const std::size_t i = std::size_t(_nodes[k]) * stride;
                  prefetch<D, stride>(_nodes, k, fields.r);
                  std::copy_n(fields.r.data() + i, D, r_before.data() + k * D);
                  if (!_corrected)
                    std::copy_n(fields.v.data() + i, D, v_before.data() + k * D);
                }
              });
  _corrected = false;
}

void ContactNodes::put_displacements(NodalFields& fields) const
{
  with_layout(fields,
              [&]<int D, int stride>()
              {
                for (std::size_t k = 0; k < _nodes.size(); ++k)
                {
                  prefetch<D, stride>(_nodes, k, fields.u);
                  std::copy_n(u.data() + k * D, D, fields.u.data() + std::size_t(_nodes[k]) * stride);
                }
              });
}

template <int D, int stride>
void ContactNodes::finish_all(NodalFields& fields, double dt)
{
  const std::size_t owned = _halo->num_owned();
  Extremes<D> increments;
  for (std::size_t k = 0; k < _nodes.size(); ++k)
  {
    prefetch<D, stride>(_nodes, k, fields.v);
    for (int c = 0; c < D; ++c)
    {
      const std::size_t i = std::size_t(_nodes[k]) * stride + c, n = k * D + c;
      if (k < owned)
        fields.v[i] = v[n];
      else
        v[n] = fields.v[i];
      du[n] = dt * v[n];
      increments.add(c, du[n]);
    }
  }
  _range = increments.range();
  _corrected = true;
}

void ContactNodes::finish_correction(NodalFields& fields, double dt)
{
  with_layout(fields, [&]<int D, int stride>() { finish_all<D, stride>(fields, dt); });
}

Halo::Traffic ContactNodes::traffic() const
{
  Halo::Traffic out = _traffic;
  if (_halo)
    out += _halo->traffic();
  return out;
}
} // namespace dolfinx_impact::integrators
