// SPDX-License-Identifier: MIT
#include "ForceTerm.h"
#include <algorithm>
#include <dolfinx/fem/DofMap.h>
#include <stdexcept>

namespace dolfinx_impact::integrators
{
namespace
{
/// Share of a rank's degrees of freedom up to which it pays to visit them one by one: loops over all run several at a
/// time.
constexpr double few = 0.1;
} // namespace

double sum_of_products(std::size_t size, const double* a, const double* b)
{
  double sum[4] = {};
  std::size_t k = 0;
  for (; k + 4 <= size; k += 4)
    for (int j = 0; j < 4; ++j)
      sum[j] += a[k + j] * b[k + j];
  for (; k < size; ++k)
    sum[0] += a[k] * b[k];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

void FormForces::check() const
{
  if (!early || !outer || !late)
    throw std::invalid_argument(std::string("the operator of the ") +
                                (!early   ? "early"
                                 : !outer ? "outer"
                                          : "late") +
                                " cells is null: give one without cells where there are none");
  for (const std::string& name : {displacement, velocity})
    if (!name.empty() && std::ranges::none_of(parts(), [&](const InternalForce* part) { return part->has(name); }))
      throw std::invalid_argument("no kernel of the forces has a coefficient named '" + name +
                                  "': give the name in the kernels, or an empty one if they have none");
}

std::vector<std::int32_t> FormForces::outer_nodes() const
{
  std::vector<std::int32_t> nodes = outer->reached_dofs();
  if (!nodes.empty())
  {
    const int bs = outer->test_space()->dofmap()->index_map_bs();
    std::ranges::transform(nodes, nodes.begin(), [bs](std::int32_t dof) { return dof / bs; });
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  }
  return nodes;
}

bool FormForces::has_history() const
{
  return std::ranges::any_of(parts(), [](const InternalForce* part) { return part && part->has_history(); });
}

double FormForces::elastic_energy() const
{
  double sum = 0.0;
  if (has_history())
    for (const InternalForce* part : parts())
      sum += part->sum("elastic");
  return sum;
}

std::size_t FormForces::num_unsolved() const
{
  std::size_t sum = 0;
  if (has_history())
    for (const InternalForce* part : parts())
      sum += part->num_failures();
  return sum;
}

void FormForces::commit() const
{
  for (InternalForce* part : parts())
    part->commit();
}

void FormForces::read(const NodalFields& fields) const
{
  for (InternalForce* operation : parts())
  {
    if (!displacement.empty())
      operation->read(displacement, fields.u.data(), fields.stride);
    if (!velocity.empty())
      operation->read(velocity, fields.v.data(), fields.stride);
  }
}

void FormForces::read_positions(const operators::NodePositions& positions) const
{
  for (InternalForce* operation : parts())
    operation->read_positions(&positions);
}

void assemble(const InternalForce& operation, const NodalFields& fields, AlignedVector& values)
{
  const std::span<double> own(values.data(), fields.own_entries);
  if (fields.is_padded())
    operation.assemble_padded(own);
  else
    operation.assemble(own);
}

ForceTerm::ForceTerm(FormForces forms, WorkKind kind, const NodalFields& fields)
    : _forms(std::move(forms)), _kind(kind), _sign(kind == WorkKind::external ? -1.0 : 1.0)
{
  if (kind == WorkKind::contact)
    throw std::invalid_argument("contacts are added by add_contact");
  _forms.check();
  for (const InternalForce* operation : _forms.parts())
    for (const std::int32_t dof : operation->reached_dofs())
      _entries.push_back(std::int32_t(fields.entry(dof)));
  std::sort(_entries.begin(), _entries.end());
  _entries.erase(std::unique(_entries.begin(), _entries.end()), _entries.end());
  _few = _entries.size() < few * fields.own;
  resize(fields);
}

void ForceTerm::resize(const NodalFields& fields)
{
  _force.resize(fields.u.size(), 0.0);
  _forms.read(fields);
}

void ForceTerm::reset()
{
  std::fill(_force.begin(), _force.end(), 0.0);
  _gathered = false;
  work = {};
}

double ForceTerm::sum_with(std::size_t own, const double* values) const
{
  if (!_few || _gathered)
    return sum_of_products(own, _force.data(), values);
  double sum = 0.0;
  for (const std::int32_t i : _entries)
    sum += _force[i] * values[i];
  return sum;
}

void ForceTerm::evaluate(NodalFields& fields, double dt)
{
  double* force = _force.data();
  const bool few = _few && !_gathered;
  if (few)
    for (const std::int32_t i : _entries)
      force[i] = 0.0;
  else
    std::fill(force, force + fields.own_entries, 0.0);
  _gathered = false;
  for (const InternalForce* operation : _forms.parts())
    assemble(*operation, fields, _force);
  if (_few)
    for (const std::int32_t i : _entries)
      fields.r[i] += _sign * force[i];
  else
    for (std::size_t i = 0; i < fields.own_entries; ++i)
      fields.r[i] += _sign * force[i];
  _position = sum_with(fields.own_entries, fields.u.data());
  work.before = 0.5 * dt * power(fields);
}

void ForceTerm::work_of_step(const NodalFields& fields, double dt)
{
  work.done += 0.5 * dt * power(fields);
}

std::vector<double> ForceTerm::saved_force(NodalFields& fields)
{
  // Owners take all of it, here as in the run that continues.
  fields.halo->reverse(_force, fields.bs, fields.stride);
  std::fill(_force.begin() + fields.owned_entries, _force.end(), 0.0);
  _gathered = true;
  return fields.owned_values(_force);
}

void ForceTerm::restore(const NodalFields& fields, std::span<const double> force, const Work& saved, double position)
{
  fields.spread(force, _force);
  _gathered = true;
  work = saved;
  _position = position;
}
} // namespace dolfinx_impact::integrators
