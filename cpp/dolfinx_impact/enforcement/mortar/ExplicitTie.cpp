// SPDX-License-Identifier: MIT
#include "ExplicitTie.h"
#include "../../common/gather.h"
#include <algorithm>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
ExplicitTie::ExplicitTie(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave, surface::Facets master,
                         const TieOptions& options, std::vector<std::int8_t> fixed)
    : _conditions(std::move(V), std::move(slave), std::move(master), options, std::move(fixed)),
      _multipliers(_conditions.num_nodes() * _conditions.gdim(), 0.0)
{
  find_remote();
}

void ExplicitTie::leave_out(std::span<const std::int8_t> taken)
{
  _conditions.leave_out(taken);
  find_remote();
}

/// Nodes of other ranks in the conditions, and who owns them. Collective.
void ExplicitTie::find_remote()
{
  const auto map = _conditions.space().dofmap()->index_map;
  const auto [first, end] = map->local_range();
  const std::vector<std::int64_t> firsts = common::gather(_conditions.comm(), std::vector<std::int64_t>{first});
  _remote.clear();
  for (std::int64_t node : _conditions.rows().columns)
    if (node < first || node >= end)
      _remote.push_back(node);
  std::ranges::sort(_remote);
  _remote.erase(std::ranges::unique(_remote).begin(), _remote.end());
  _owners.clear();
  for (std::int64_t node : _remote)
    _owners.push_back(int(std::ranges::upper_bound(firsts, node) - firsts.begin()) - 1);
  const Constraints& rows = _conditions.rows();
  _num_conditions = std::ranges::count(rows.constrained, std::int8_t(1));
  _columns.clear();
  for (std::size_t k = 0; k < rows.size(); ++k)
  {
    _columns.push_back(first + rows.nodes[k]);
    _columns.insert(_columns.end(), &rows.columns[0] + rows.pointers[k], &rows.columns[0] + rows.pointers[k + 1]);
  }
}

std::span<const std::int32_t> ExplicitTie::required_nodes(operators::Halo& all)
{
  _positions.resize(_columns.size());
  all.map().global_to_local(_columns, _positions);
  if (std::ranges::any_of(_positions, [](std::int32_t node) { return node < 0; }))
    throw std::invalid_argument(_conditions.options().name + ": a node of a tie is not among those of the Halo");
  // Nodes that other ranks need are their owners' too.
  std::vector<double> needed(all.num_nodes(), 0.0);
  for (std::int32_t node : _positions)
    needed[node] = 1.0;
  const std::vector<double> here = needed;
  all.reverse(needed, 1);
  _needed.clear();
  for (std::int32_t node = 0; node < all.num_nodes(); ++node)
    if (node < all.num_owned() ? needed[node] > 0.0 : here[node] > 0.0)
      _needed.push_back(node);
  return _needed;
}

void ExplicitTie::assign_numbers(operators::Halo&, std::span<const std::int32_t> numbers, std::span<const double>)
{
  const Constraints& rows = _conditions.rows();
  const std::size_t g = _conditions.gdim();
  _pointers.assign(1, 0);
  _dofs.clear();
  _values.clear();
  std::size_t own = 0; // place of a row's slave node in `_columns`, before its columns
  for (std::size_t k = 0; k < rows.size(); ++k)
  {
    const std::size_t width = std::size_t(rows.pointers[k + 1] - rows.pointers[k]);
    for (std::size_t d = 0; d < g; ++d)
    {
      if (!rows.constrained[k * g + d])
        continue;
      for (std::size_t a = 0; a < g; ++a)
      {
        const double along = _conditions.weight()[k * g + d] * _conditions.directions()[(k * g + a) * g + d];
        for (std::size_t p = 0; p <= width && along != 0.0; ++p)
        {
          const double value = p == 0 ? along : -along * rows.part(rows.pointers[k] + std::int64_t(p) - 1, int(d));
          if (value == 0.0)
            continue;
          _dofs.push_back(std::size_t(numbers[_positions[own + p]]) * g + a);
          _values.push_back(value);
        }
      }
      _pointers.push_back(_values.size());
    }
    own += width + 1;
  }
}

void ExplicitTie::jumps(std::span<const double> u, std::span<double> out) const
{
  for (std::size_t r = 0; r < _num_conditions; ++r)
  {
    double sum = 0.0;
    for (std::size_t k = _pointers[r]; k < _pointers[r + 1]; ++k)
      sum += _values[k] * u[_dofs[k]];
    out[r] = sum;
  }
}

void ExplicitTie::add_forces(std::span<const double> z, std::span<double> forces)
{
  const Constraints& rows = _conditions.rows();
  const std::size_t g = _conditions.gdim();
  _force = {};
  std::size_t r = 0;
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (std::size_t d = 0; d < g; ++d)
    {
      if (!rows.constrained[k * g + d])
        continue;
      for (std::size_t p = _pointers[r]; p < _pointers[r + 1]; ++p)
        forces[_dofs[p]] += _values[p] * z[r];
      _multipliers[rows.rows[k] * g + d] = z[r];
      // The shape functions add up to one: what the condition gives to the slave in all.
      for (std::size_t a = 0; a < g; ++a)
        _force[a] += _conditions.cover()[k * g + d] * _conditions.directions()[(k * g + a) * g + d] * z[r];
      ++r;
    }
}

std::vector<double> ExplicitTie::traction() const
{
  return _conditions.traction(_multipliers);
}

state::State ExplicitTie::saved_state() const
{
  state::State out(_conditions.options().name);
  out.at(state::Place::node, {_conditions.nodes().begin(), _conditions.nodes().end()});
  out.add_own("multiplier", state::Place::node, _multipliers, _conditions.gdim());
  out.add_own("energies", state::Place::rank, std::vector<double>(6, 0.0));
  out.add_own("force", state::Place::rank, std::vector<double>(_force.begin(), _force.end()));
  return out;
}

void ExplicitTie::resume(const state::State& saved)
{
  const std::span<const double> values = saved.values<double>("multiplier"), force = saved.values<double>("force");
  if (values.size() != _multipliers.size() || force.size() != _force.size())
    throw std::invalid_argument(_conditions.options().name + ": the state is that of other nodes");
  std::ranges::copy(values, _multipliers.begin());
  std::ranges::copy(force, _force.begin());
}

void ExplicitTie::reset()
{
  std::ranges::fill(_multipliers, 0.0);
  _force = {};
}
} // namespace dolfinx_impact::enforcement
