// SPDX-License-Identifier: MIT
#include "Tie.h"
#include "../../common/gather.h"
#include "../../common/text.h"
#include "../../common/vectors.h"
#include "../../operators/nodal_sums.h"
#include "../../operators/petsc_check.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
using operators::check;

namespace
{
/// Of positions.
constexpr double round_off_of_positions = 4 * std::numeric_limits<double>::epsilon();
} // namespace

Tie::Tie(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave, surface::Facets master,
         const TieOptions& options, std::vector<std::int8_t> fixed)
    : _conditions(std::move(V), std::move(slave), std::move(master), options, fixed), _fixed(std::move(fixed))
{
  const std::size_t num = _conditions.num_nodes(), vector = num * _conditions.gdim();
  _multipliers.assign(vector, 0.0);
  _jump.assign(vector, 0.0);
  _u.assign(_fixed.size(), 0.0);
  _normal = _conditions.normal();
  _pressure.assign(num, 0.0);
  _linearised.assign(num, 0.0);
  _stiffness.assign(num, 1.0);
  _active.assign(num, 1);
  _sliding.assign(num, 0);
}

void Tie::leave_out(std::span<const std::int8_t> taken)
{
  _conditions.leave_out(taken);
}

void Tie::assign(std::span<const double> multipliers)
{
  if (multipliers.size() != _multipliers.size())
    throw std::invalid_argument("a multiplier of every node and direction is needed");
  std::ranges::copy(multipliers, _multipliers.begin());
  _pressure = along_normal(traction());
}

// --- load steps ------------------------------------------------------------------------------------------------------

void Tie::begin_step(std::span<const double> u, const std::optional<std::array<double, 3>>&,
                     std::span<const double> target)
{
  if (u.size() != _fixed.size() || (!target.empty() && target.size() != u.size()))
    throw std::invalid_argument("displacements are those of all owned and ghost nodes of the space");
  _target.assign(target.begin(), target.end());
}

state::State Tie::state()
{
  state::State out(name());
  out.at(state::Place::node, {nodes().begin(), nodes().end()});
  out.add("multiplier", state::Place::node, _multipliers, _conditions.gdim());
  return out;
}

state::State Tie::saved_state()
{
  state::State out = state().copy();
  _totals.add_to(out, _conditions.gdim());
  return out;
}

void Tie::resume(const state::State& saved, std::span<const double> u)
{
  begin_step(u, std::nullopt, {});
  update_gap(u);
  state().assign_common(saved);
  _totals.resume(saved, std::vector<double>(_multipliers.size(), 0.0));
  _pressure = along_normal(traction());
}

void Tie::accept_step()
{
  const std::vector<double> x = points(), tractions = traction(), slips = slip(), whole = covered();
  const std::vector<ContactStatus> states = status();
  _totals.update(_conditions.comm(), {.gdim = _conditions.gdim(),
                                      .x = x,
                                      .traction = tractions,
                                      .slip = slips,
                                      .status = states,
                                      .weight = _conditions.area(),
                                      .covered = whole});
  // Multipliers of nodes with prescribed components act on their neighbours: forces and moments are those at the nodes.
  const std::size_t g = _conditions.gdim();
  const std::vector<double> forces = contact_forces(), rest = _conditions.space().tabulate_dof_coordinates(false);
  const std::vector<std::int8_t> slave = _conditions.marks(true, false);
  std::array<double, 6> sums{};
  for (std::size_t node = 0; node < forces.size() / g; ++node)
  {
    if (!slave[node])
      continue;
    double at[3] = {}, f[3] = {};
    for (std::size_t c = 0; c < g; ++c)
    {
      at[c] = rest[3 * node + c] + _u[node * g + c];
      f[c] = forces[node * g + c];
      sums[c] += f[c];
    }
    for (int c = 0; c < 3; ++c)
      sums[3 + c] += at[(c + 1) % 3] * f[(c + 2) % 3] - at[(c + 2) % 3] * f[(c + 1) % 3];
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), int(sums.size()), MPI_DOUBLE, MPI_SUM, _conditions.comm());
  std::copy_n(sums.begin(), 3, _totals.force.begin());
  _totals.moment = g == 2 ? std::array{sums[5], 0.0, 0.0} : std::array{sums[3], sums[4], sums[5]};
  _pressure = along_normal(tractions);
}

// --- Newton iterations -----------------------------------------------------------------------------------------------

void Tie::update_gap(std::span<const double> u)
{
  if (u.size() != _fixed.size())
    throw std::invalid_argument("displacements are those of all owned and ghost nodes of the space");
  _u.assign(u.begin(), u.end());
  _jump = _conditions.jump(u);
  _linearised = along_normal(_jump);
  // Mean normals of the slave's facets, out of the master, where they are now.
  surface::Facets facets = _conditions.slave();
  surface::move(facets, u.data());
  const std::size_t g = _conditions.gdim();
  std::vector<double> sums(u.size(), 0.0);
  gap::add_normals(facets, sums);
  sums = operators::sum_over_ranks(_conditions.space().dofmap()->index_map, std::move(sums), int(g));
  for (std::size_t i = 0; i < nodes().size(); ++i)
  {
    const double *sum = &sums[std::size_t(nodes()[i]) * g], length = std::sqrt(dot(sum, sum, int(g)));
    for (std::size_t c = 0; c < g && length > 0.0; ++c)
      _normal[i * g + c] = sum[c] / length;
  }
}

int Tie::update_active_set(bool, std::optional<std::int64_t>)
{
  return 0;
}

void Tie::add_residual(Vec b) const
{
  operators::subtract(contact_forces(), b);
}

void Tie::update_nodal_stiffness(Mat K)
{
  const std::size_t g = _conditions.gdim();
  Vec diagonal = nullptr;
  check(MatCreateVecs(K, nullptr, &diagonal), "a vector is made");
  check(MatGetDiagonal(K, diagonal), "a matrix is read");
  const std::vector<double> values = operators::values_of(diagonal);
  check(VecDestroy(&diagonal), "a vector is destroyed");
  for (std::size_t i = 0; i < _stiffness.size(); ++i)
  {
    _stiffness[i] = 0.0;
    for (std::size_t c = 0; c < g; ++c)
      _stiffness[i] += std::abs(values[std::size_t(nodes()[i]) * g + c]) / double(g);
  }
}

std::int64_t Tie::num_active() const
{
  return common::sum(_conditions.comm(), (long long)_conditions.num_nodes());
}

double Tie::violation() const
{
  double here = 0.0;
  for (double jump : _jump)
    here = std::max(here, std::abs(jump));
  return common::largest(_conditions.comm(), here) / _conditions.size();
}

std::string Tie::largest_violation() const
{
  return name() + ": the surfaces are apart by " + common::text("%.3e", violation() * _conditions.size()) +
         " against where they were tied";
}

Constraints Tie::constraints()
{
  const std::size_t g = _conditions.gdim();
  Constraints out = _conditions.rows();
  for (std::size_t k = 0; k < out.size(); ++k)
    for (std::size_t d = 0; d < g; ++d)
    {
      const std::size_t at = k * g + d, node = out.nodes[k];
      if (!out.constrained[at])
        continue;
      // Along the normal, what prescribed components of the node have yet to move counts as well.
      double lacking = _jump[out.rows[k] * g + d];
      for (std::size_t c = 0; c < g && !_target.empty(); ++c)
        if (_fixed[node * g + c])
          lacking += _conditions.directions()[(k * g + c) * g + d] * (_target[node * g + c] - _u[node * g + c]);
      out.known[at] = -lacking / _conditions.length()[at];
    }
  return out;
}

void Tie::update_linearised_gap(std::span<const double> increments)
{
  std::vector<double> jump = _conditions.jump(increments);
  for (std::size_t k = 0; k < jump.size(); ++k)
    jump[k] += _jump[k];
  _linearised = along_normal(jump);
}

std::pair<std::vector<double>, std::vector<double>> Tie::linearised_response(std::span<const double> increments,
                                                                             std::span<const double>) const
{
  return {along_normal(_conditions.jump(increments)), std::vector<double>(_pressure.size(), 0.0)};
}

void Tie::update_multipliers(std::span<const double> residual)
{
  const Constraints& rows = _conditions.rows();
  const std::size_t g = _conditions.gdim();
  std::vector<double> forces(_multipliers.size(), 0.0);
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (std::size_t d = 0; d < g; ++d)
      for (std::size_t a = 0; a < g && rows.constrained[k * g + d]; ++a)
        forces[rows.rows[k] * g + d] += rows.frames[(k * g + a) * g + d] * residual[rows.nodes[k] * g + a];
  set_multipliers(forces);
}

void Tie::set_multipliers(std::span<const double> forces)
{
  const Constraints& rows = _conditions.rows();
  const std::size_t g = _conditions.gdim();
  std::ranges::fill(_multipliers, 0.0);
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (std::size_t d = 0; d < g; ++d)
      if (const std::size_t at = k * g + d; rows.constrained[at])
        _multipliers[rows.rows[k] * g + d] =
            forces[rows.rows[k] * g + d] / (_conditions.weight()[at] * _conditions.length()[at]);
  _pressure = along_normal(traction());
}

double Tie::gap_round_off() const
{
  const std::size_t g = _conditions.gdim();
  double squared = 0.0;
  const std::vector<double> x = points();
  for (std::size_t i = 0; i < _stiffness.size(); ++i)
  {
    const double force = _stiffness[i] * round_off_of_positions * std::sqrt(dot(&x[i * g], &x[i * g], int(g)));
    squared += force * force;
  }
  return std::sqrt(common::sum(_conditions.comm(), squared));
}

std::vector<double> Tie::unit_gap(std::int64_t) const
{
  return std::vector<double>(std::size_t(_conditions.space().dofmap()->index_map->size_local()) * _conditions.gdim(),
                             0.0);
}

std::vector<double> Tie::unit_force(std::int64_t number) const
{
  return unit_gap(number);
}

// --- results ---------------------------------------------------------------------------------------------------------

/// Parts of vectors along the normals, by node.
std::vector<double> Tie::along_normal(std::span<const double> values) const
{
  const std::size_t g = _conditions.gdim();
  std::vector<double> out(values.size() / g);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = dot(&_normal[i * g], &values[i * g], int(g));
  return out;
}

std::vector<double> Tie::points() const
{
  const std::size_t g = _conditions.gdim();
  std::vector<double> out(_conditions.points());
  for (std::size_t i = 0; i < nodes().size(); ++i)
    for (std::size_t c = 0; c < g; ++c)
      out[i * g + c] += _u[std::size_t(nodes()[i]) * g + c];
  return out;
}

std::vector<double> Tie::gap() const
{
  const std::size_t g = _conditions.gdim();
  std::vector<double> apart(_conditions.offset());
  for (std::size_t k = 0; k < apart.size(); ++k)
    apart[k] += _jump[k];
  if (!_conditions.options().normal_only)
    return along_normal(apart);
  std::vector<double> out(apart.size() / g, 0.0);
  for (std::size_t k = 0; k < apart.size(); ++k)
    out[k / g] += apart[k]; // one direction of each node has a condition
  return out;
}

std::vector<double> Tie::pressure() const
{
  return _pressure;
}

std::vector<double> Tie::slip() const
{
  return std::vector<double>(_multipliers.size(), 0.0);
}

std::vector<ContactStatus> Tie::status() const
{
  return std::vector<ContactStatus>(nodes().size(),
                                    _conditions.options().normal_only ? ContactStatus::slip : ContactStatus::stick);
}
} // namespace dolfinx_impact::enforcement
