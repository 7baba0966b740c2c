// SPDX-License-Identifier: MIT
#include "RollingContact.h"
#include "../common/OnAllRanks.h"
#include "../common/dolfinx_api.h"
#include "../common/gather.h"
#include "../common/text.h"
#include "../common/vectors.h"
#include "../enforcement/mortar/DeformableGeometry.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/la/Vector.h>
#include <limits>
#include <numeric>

namespace dolfinx_impact::rolling
{
namespace
{
using enforcement::ContactStatus;
using enforcement::MortarContact;
using enforcement::MortarOptions;
using operators::check;
using operators::OwnedMatrix;
using operators::OwnedVector;

/// Part of a node's jump that free displacements make; with less it is prescribed. On a plane of symmetry round
/// surfaces have parts of 1e-6, as facets are not opposite to each other exactly; a prescribed slave on a free master
/// has 1.
constexpr double prescribed = 0.1;

std::vector<const surface::Facets*> surfaces(const enforcement::MortarGeometry& g)
{
  std::vector<const surface::Facets*> out{&g.slave()};
  if (g.master())
    out.push_back(g.master());
  return out;
}

/// A matrix over the nodes times each component of nodal vectors, owned, [node*g + c]. Collective.
std::vector<double> nodal_product(Mat matrix, std::span<const double> values, std::size_t g)
{
  Vec made[2] = {};
  check(MatCreateVecs(matrix, &made[0], &made[1]), "vectors are made");
  const OwnedVector x(made[0]), y(made[1]);
  std::vector<double> out;
  for (std::size_t c = 0; c < g; ++c)
  {
    {
      operators::Entries entries(x.get());
      for (std::size_t i = 0; i < entries.size(); ++i)
        entries[i] = values[i * g + c];
    }
    check(MatMult(matrix, x.get(), y.get()), "a matrix is multiplied");
    const std::vector<double> product = operators::values_of(y.get());
    out.resize(product.size() * g);
    for (std::size_t i = 0; i < product.size(); ++i)
      out[i * g + c] = product[i];
  }
  return out;
}

MortarOptions of_flow(MortarOptions options)
{
  options.slip = enforcement::Slip::of_flow;
  options.may_share_nodes = false;
  return options;
}
} // namespace

RollingContact::RollingContact(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave,
                               const Master& master, MortarOptions options, std::vector<std::int8_t> fixed,
                               std::shared_ptr<const Flow> flow)
    : MortarContact(V, std::move(slave), master, of_flow(std::move(options)), fixed), _V(std::move(V)),
      _flow(std::move(flow)), _fixed(std::move(fixed)), _streamlines(_V, surfaces(geometry())), _w(_fixed.size(), 0.0),
      _held(geometry().num_nodes() * geometry().gdim(), 0),
      _slip_velocity(geometry().num_nodes() * geometry().gdim(), 0.0)
{
}

// --- velocities ------------------------------------------------------------------------------------------------------

void RollingContact::update_flow()
{
  _w = _flow->at_nodes();
  _derivative = _streamlines.matrix(_w);
  _rate = 0.0;
}

/// Gaps, normals and matrices of jumps. Collective.
void RollingContact::update_geometry(std::span<const double> u)
{
  update_gap(u);
  const auto& g = geometry();
  if (auto* deformable = dynamic_cast<enforcement::DeformableGeometry*>(&geometry()))
  {
    Mat copy = nullptr;
    check(MatDuplicate(deformable->integrals().jump_matrix(), MAT_COPY_VALUES, &copy), "a matrix is copied");
    _jump.reset(copy);
  }
  else
    _jump = nodal_matrix(*_V, g.numbers(), g.numbers(), g.now().weight);
  Mat product = nullptr;
  check(MatMatMult(_jump.get(), _derivative.get(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, &product),
        "matrices are multiplied");
  _velocity_jump.reset(product);
  _held = held_components();
}

void RollingContact::update(std::span<const double> u)
{
  update_geometry(u);
  turn_to_normals();
  std::ranges::copy(tangential(relative_velocity(u)), _slip_velocity.begin());
}

/// Components in which slave and master are both prescribed, as on a plane of symmetry. Collective.
std::vector<std::int8_t> RollingContact::held_components() const
{
  const auto& g = geometry();
  std::vector<std::int8_t> out(_held.size(), 0);
  int any = std::ranges::any_of(g.fixed(), [](std::int8_t f) { return f != 0; });
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, g.comm());
  if (!any)
    return out;
  std::vector<std::int64_t> rows, columns;
  std::vector<double> sizes;
  PetscInt first = 0, end = 0;
  check(MatGetOwnershipRange(_jump.get(), &first, &end), "a matrix is asked for its rows");
  for (PetscInt row = first; row < end; ++row)
  {
    PetscInt num = 0;
    const PetscInt* at = nullptr;
    const PetscScalar* values = nullptr;
    check(MatGetRow(_jump.get(), row, &num, &at, &values), "a row is read");
    for (PetscInt k = 0; k < num; ++k)
    {
      rows.push_back(row);
      columns.push_back(at[k]);
      sizes.push_back(std::abs(values[k]));
    }
    check(MatRestoreRow(_jump.get(), row, &num, &at, &values), "a row is read");
  }
  const OwnedMatrix size = nodal_matrix(*_V, rows, columns, std::move(sizes));
  std::vector<double> free(std::size_t(end - first) * g.gdim());
  for (std::size_t k = 0; k < free.size(); ++k)
    free[k] = !_fixed[k];
  const std::vector<double> share = means(size.get(), free);
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = share[k] < prescribed && g.now().participates[k / g.gdim()];
  return out;
}

/// A matrix of jumps times nodal vectors, over the cover; zero where no multiplier lives. Collective.
std::vector<double> RollingContact::means(Mat matrix, std::span<const double> values) const
{
  const auto& geometry = this->geometry();
  const std::size_t g = geometry.gdim();
  const std::vector<double> product = nodal_product(matrix, values, g);
  std::vector<double> out(geometry.num_nodes() * g, 0.0);
  for (std::size_t i = 0; i < geometry.num_nodes(); ++i)
    for (std::size_t c = 0; c < g && geometry.now().participates[i]; ++c)
      out[i * g + c] = product[geometry.nodes()[i] * g + c] / geometry.now().cover[i];
  return out;
}

/// Velocity of the undeformed material at owned nodes.
std::span<const double> RollingContact::owned_flow() const
{
  return std::span(_w).first(std::size_t(_V->dofmap()->index_map->size_local()) * geometry().gdim());
}

std::vector<double> RollingContact::relative_velocity(std::span<const double> u) const
{
  std::vector<double> out = means(_jump.get(), owned_flow());
  const std::vector<double> deformed = means(_velocity_jump.get(), u), imposed = imposed_velocity();
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] += deformed[k] + imposed[k];
  return out;
}

std::vector<double> RollingContact::imposed_velocity() const
{
  std::vector<double> out = creepage();
  if (geometry().obstacle())
    for (std::size_t k = 0; k < out.size(); ++k)
      out[k] -= _obstacle_velocity[k % geometry().gdim()];
  return out;
}

/// Rigid slip velocity of slave against master besides that of the motions: the body that spins moves against the other
/// one. Collective.
std::vector<double> RollingContact::creepage() const
{
  const int g = geometry().gdim();
  std::vector<double> out(geometry().num_nodes() * g, 0.0);
  const Motion* spin = _flow->first_spin();
  if (!spin || (_flow->lateral == 0.0 && _flow->turn == 0.0))
    return out;
  const double fast = speed();
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = _flow->lateral * fast * spin->spin()->axis[k % g];
  if (_flow->turn != 0.0)
  {
    const std::vector<double> turning = turn_about_normal(*spin);
    for (std::size_t k = 0; k < out.size(); ++k)
      out[k] += _flow->turn * fast * turning[k];
  }
  for (std::size_t i = 0; i < geometry().num_nodes(); ++i)
    if (!std::ranges::binary_search(spin->nodes, nodes()[i]))
      for (int c = 0; c < g; ++c)
        out[i * g + c] = -out[i * g + c];
  return out;
}

/// Velocities of a turn with unit rate about the contact's mean normal into the body that spins, be it slave or master,
/// through the centre of pressure; meshes in space [L]. Collective.
std::vector<double> RollingContact::turn_about_normal(const Motion& spin) const
{
  const auto& n = geometry().now();
  const enforcement::MortarState& s = nodal_state();
  std::array<double, 7> total{};
  for (std::size_t i = 0; i < geometry().num_nodes(); ++i)
  {
    const double pressed = s.active[i] ? s.multiplier[i] * n.weight[i] : 0.0;
    // The normal is outward from the master.
    const double side = std::ranges::binary_search(spin.nodes, nodes()[i]) ? 1.0 : -1.0;
    total[0] += pressed;
    for (int c = 0; c < 3; ++c)
    {
      total[1 + c] += pressed * n.points[i * 3 + c];
      total[4 + c] += side * pressed * n.normal[i * 3 + c];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, total.data(), 7, MPI_DOUBLE, MPI_SUM, geometry().comm());
  std::vector<double> out(n.points.size(), 0.0);
  const double size = std::sqrt(dot(&total[4], &total[4], 3));
  if (total[0] <= 0.0)
    return out;
  const double axis[3] = {total[4] / size, total[5] / size, total[6] / size};
  for (std::size_t i = 0; i < geometry().num_nodes(); ++i)
  {
    double arm[3];
    for (int c = 0; c < 3; ++c)
      arm[c] = n.points[i * 3 + c] - total[1 + c] / total[0];
    cross(axis, arm, &out[i * 3]);
  }
  return out;
}

std::vector<double> RollingContact::material_velocity(std::span<const double> u) const
{
  std::vector<double> out = nodal_product(_derivative.get(), u, geometry().gdim());
  const std::span<const double> w = owned_flow();
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] += w[k];
  return out;
}

std::vector<double> RollingContact::velocity_slope(const Motion& spin, std::span<const double> u) const
{
  const std::size_t g = geometry().gdim();
  const std::vector<double> velocity = material_velocity(u);
  std::vector<double> part(velocity.size(), 0.0);
  for (std::int32_t node : spin.nodes)
    for (std::size_t c = 0; c < g && node * g < part.size(); ++c)
      part[node * g + c] = velocity[node * g + c] / spin.rate->value[0];
  return tangential(means(_jump.get(), part));
}

std::vector<double> RollingContact::gap_change(std::span<const double> moved) const
{
  const int g = geometry().gdim();
  const std::vector<double> jump = means(_jump.get(), moved);
  std::vector<double> out(geometry().num_nodes());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = dot(&geometry().now().normal[i * g], &jump[i * g], g);
  return out;
}

std::vector<double> RollingContact::slip_change(std::span<const double> moved) const
{
  return tangential(means(_velocity_jump.get(), moved));
}

std::vector<double> RollingContact::tangential(std::vector<double> vectors) const
{
  const int g = geometry().gdim();
  for (std::size_t i = 0; i < geometry().num_nodes(); ++i)
  {
    const double* n = &geometry().now().normal[i * g];
    const double along = dot(n, &vectors[i * g], g);
    for (int c = 0; c < g; ++c)
      vectors[i * g + c] = _held[i * g + c] ? 0.0 : vectors[i * g + c] - along * n[c];
  }
  return vectors;
}

std::vector<double> RollingContact::main_direction() const
{
  const std::size_t g = geometry().gdim();
  std::vector<double> out(geometry().num_nodes() * g);
  for (std::size_t i = 0; i < geometry().num_nodes(); ++i)
    std::copy_n(&_w[nodes()[i] * g], g, &out[i * g]);
  return out;
}

double RollingContact::speed() const
{
  const int g = geometry().gdim();
  double here = 0.0;
  for (const surface::Facets* facets : surfaces(geometry()))
    for (std::int32_t node : facets->nodes)
      here = std::max(here, dot(&_w[std::size_t(node) * g], &_w[std::size_t(node) * g], g));
  if (geometry().obstacle())
    here = std::max(here, dot(_obstacle_velocity.data(), _obstacle_velocity.data(), 3));
  return std::sqrt(common::largest(geometry().comm(), here));
}

void RollingContact::check_directions(std::span<const double> u)
{
  update_flow();
  update_geometry(u);
  const auto& geometry = this->geometry();
  const int g = geometry.gdim();
  const std::vector<double> against = means(_jump.get(), owned_flow());
  double nearest = std::numeric_limits<double>::infinity();
  std::size_t at = 0;
  for (std::size_t i = 0; i < geometry.num_nodes(); ++i)
    if (geometry.now().participates[i] && geometry.now().gap[i] < nearest)
    {
      nearest = geometry.now().gap[i];
      at = i;
    }
  // Gap, place, and the velocities of slave and master there.
  std::vector<double> mine(1 + 3 * g, 0.0);
  mine[0] = nearest;
  if (std::isfinite(nearest))
    for (int c = 0; c < g; ++c)
    {
      const double slave = _w[std::size_t(nodes()[at]) * g + c];
      mine[1 + c] = geometry.now().points[at * g + c];
      mine[1 + g + c] = slave;
      mine[1 + 2 * g + c] = slave - against[at * g + c] + (geometry.obstacle() ? _obstacle_velocity[c] : 0.0);
    }
  const std::vector<double> all = common::gather(geometry.comm(), mine);
  const double* found = all.data();
  for (std::size_t r = 0; r < all.size(); r += mine.size())
    if (all[r] < found[0])
      found = &all[r];
  if (!std::isfinite(found[0]))
    return;
  const std::span<const double> place(found + 1, g), slave(found + 1 + g, g), master(found + 1 + 2 * g, g);
  const auto moves = [](std::span<const double> v)
  { return std::ranges::any_of(v, [](double x) { return x != 0.0; }); };
  const std::string where = name() + ", at " + common::place(place);
  if (has_steady_friction() && !moves(slave) && !moves(master))
    throw common::BadValue(where + ": neither body moves, so that friction has no direction; give a spin or a speed");
  if (dot(slave.data(), master.data(), g) < 0.0)
    throw common::BadValue(where + ": the slave's material moves with " + common::place(slave) +
                           ", the master's with " + common::place(master) +
                           ": spin and speed are of opposite sense; change the sign of one");
}

// --- the law of friction ---------------------------------------------------------------------------------------------

std::vector<std::int8_t> RollingContact::carriers() const
{
  std::vector<std::int8_t> out(usable());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = out[i] && geometry().now().participates[i];
  return out;
}

std::vector<std::int8_t> RollingContact::with_neighbours(const std::vector<std::int8_t>& chosen) const
{
  dolfinx::la::Vector<double> mark(geometry().map(), 1);
  const std::span<double> values = common::array(mark);
  std::ranges::fill(values, 0.0);
  for (std::size_t i = 0; i < chosen.size(); ++i)
    values[nodes()[i]] = chosen[i];
  mark.scatter_fwd();
  const surface::Facets& slave = geometry().slave();
  const std::size_t num = slave.displacement.num_nodes();
  std::vector<std::int32_t> reached;
  for (std::size_t f = 0; f < slave.size(); ++f)
    if (const std::span<const std::int32_t> facet(slave.nodes_of(f), num);
        std::ranges::any_of(facet, [&](std::int32_t node) { return values[node] > 0.0; }))
      reached.insert(reached.end(), facet.begin(), facet.end());
  std::ranges::fill(values, 0.0);
  for (std::int32_t node : reached)
    values[node] = 1.0;
  mark.scatter_rev(std::plus<double>());
  std::vector<std::int8_t> out(chosen);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = out[i] || values[nodes()[i]] > 0.0;
  return out;
}

/// Slip velocity per displacement, largest: what stick conditions are scaled by [1/T]. Collective.
double RollingContact::rate() const
{
  if (_rate == 0.0)
  {
    Vec made = nullptr;
    check(MatCreateVecs(_velocity_jump.get(), nullptr, &made), "a vector is made");
    const OwnedVector diagonal(made);
    check(MatGetDiagonal(_velocity_jump.get(), made), "a diagonal is read");
    double here = 0.0;
    operators::Entries entries(made);
    const std::vector<std::int8_t> carriers = this->carriers();
    for (std::size_t i = 0; i < carriers.size(); ++i)
      if (carriers[i])
        here = std::max(here, std::abs(entries[nodes()[i]]) / geometry().now().cover[i]);
    const double found = common::largest(geometry().comm(), here);
    _rate = found > 0.0 ? found : 1.0;
  }
  return _rate;
}

std::vector<double> RollingContact::steady_friction(std::span<const double> slip,
                                                    std::span<const double> multipliers) const
{
  const std::size_t num = geometry().num_nodes(), g = geometry().gdim();
  if (!options().friction_law)
    return std::vector<double>(num, options().friction);
  std::vector<double> pressure(num);
  for (std::size_t i = 0; i < num; ++i)
    pressure[i] = std::max(0.0, dot(&geometry().now().normal[i * g], &multipliers[i * g], int(g)));
  return law_coefficients(pressure, slip).value;
}

SteadyFriction RollingContact::law(std::span<const double> gap, std::span<const double> slip,
                                   std::span<const double> multipliers) const
{
  const std::vector<std::int8_t> carriers = this->carriers();
  std::vector<double> normal(nodal_stiffness()), across(normal.size());
  const double rate = this->rate();
  for (std::size_t i = 0; i < normal.size(); ++i)
  {
    normal[i] /= carriers[i] ? geometry().now().weight[i] : 1.0;
    across[i] = normal[i] / rate;
  }
  return {{geometry().gdim(), carriers, geometry().now().normal, normal, across},
          steady_friction(slip, multipliers),
          gap,
          slip,
          multipliers};
}

double RollingContact::steady_violation() const
{
  const int g = geometry().gdim();
  const double fast = speed();
  const std::vector<double>& gap = geometry().now().gap;
  const std::vector<double> vectors = traction();
  const SteadyFriction law = this->law(gap, _slip_velocity, vectors);
  double pressure = 0.0, here = 0.0;
  for (double p : nodal_state().multiplier)
    pressure = std::max(pressure, p);
  pressure = common::largest(geometry().comm(), pressure);
  for (std::size_t i = 0; i < gap.size(); ++i)
    if (law.active[i]) // carriers alone are
    {
      here = std::max(here, std::abs(gap[i]) / geometry().size());
      if (!law.sliding[i] && fast > 0.0 && has_steady_friction())
        here = std::max(here, std::sqrt(dot(&_slip_velocity[i * g], &_slip_velocity[i * g], g)) / fast);
    }
  if (pressure > 0.0)
    for (std::size_t k = 0; k < vectors.size(); ++k)
      here = std::max(here, std::abs(law.target[k] - vectors[k]) / pressure * 1e-2);
  return common::largest(geometry().comm(), here);
}

void RollingContact::set_tractions(std::span<const double> multipliers, const SteadyFriction& law)
{
  const int g = geometry().gdim();
  enforcement::MortarState& s = nodal_state();
  const std::vector<double> across = tangential(common::copy_of(multipliers));
  std::ranges::copy(law.active, s.active.begin());
  std::ranges::copy(law.sliding, s.sliding.begin());
  for (std::size_t i = 0; i < s.active.size(); ++i)
  {
    s.multiplier[i] = s.active[i] ? dot(&geometry().now().normal[i * g], &multipliers[i * g], g) : 0.0;
    for (int c = 0; c < g; ++c)
      s.friction_traction[i * g + c] = s.active[i] ? across[i * g + c] : 0.0;
  }
}

/// Friction tractions turn with the surface, keeping their size.
void RollingContact::turn_to_normals()
{
  const int g = geometry().gdim();
  std::vector<double>& traction = nodal_state().friction_traction;
  const std::vector<double> turned = tangential(traction);
  for (std::size_t i = 0; i < geometry().num_nodes(); ++i)
  {
    const double size = std::sqrt(dot(&traction[i * g], &traction[i * g], g));
    const double left = std::sqrt(dot(&turned[i * g], &turned[i * g], g));
    for (int c = 0; c < g; ++c)
      traction[i * g + c] = left > 0.0 ? turned[i * g + c] * (size / left) : 0.0;
  }
}

// --- what is another one than in statics
// -------------------------------------------------------------------------------

state::State RollingContact::state()
{
  state::State out = MortarContact::state();
  out.add("slip_velocity", state::Place::node, _slip_velocity, geometry().gdim());
  out.add("friction_power", state::Place::all, _friction_power);
  return out;
}

state::State RollingContact::saved_state()
{
  state::State out = MortarContact::saved_state();
  out.add_own("slip_velocity", state::Place::node, std::vector<double>(_slip_velocity), geometry().gdim());
  out.add_own("friction_power", state::Place::all, std::vector<double>{_friction_power});
  return out;
}

void RollingContact::accept_step()
{
  std::ranges::copy(opened(geometry().now().gap), nodal_state().opening.begin());
  nodal_state().begun = 1;
  update_totals();
  if (!_velocity_jump)
    return;
  double here = 0.0;
  const std::size_t g = geometry().gdim();
  for (std::size_t k = 0; k < _slip_velocity.size(); ++k)
    here += geometry().now().cover[k / g] * nodal_state().friction_traction[k] * _slip_velocity[k];
  _friction_power = -common::sum(geometry().comm(), here);
}

std::vector<double> RollingContact::slip() const
{
  return std::vector<double>(geometry().num_nodes() * geometry().gdim(), 0.0);
}

std::vector<ContactStatus> RollingContact::status() const
{
  const enforcement::MortarState& s = nodal_state();
  std::vector<ContactStatus> out(s.active.size(), ContactStatus::open);
  for (std::size_t i = 0; i < out.size(); ++i)
    if (s.active[i] && geometry().now().part[i])
      out[i] = s.sliding[i] || !has_steady_friction() ? ContactStatus::slip : ContactStatus::stick;
  return out;
}
} // namespace dolfinx_impact::rolling
