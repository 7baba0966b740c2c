// SPDX-License-Identifier: MIT
#include "MortarGeometry.h"
#include "../../operators/body_size.h"
#include "../../operators/nodal_sums.h"
#include "../../operators/petsc_check.h"
#include "JoinedNodes.h"
#include "active_set.h"
#include "prescribed_components.h"
#include <algorithm>
#include <basix/quadrature.h>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <unordered_set>

namespace dolfinx_impact::enforcement
{
using operators::check;

FacetRule::FacetRule(surface::FacetShape shape, int degree)
{
  const auto cell = shape == surface::FacetShape::interval   ? basix::cell::type::interval
                    : shape == surface::FacetShape::triangle ? basix::cell::type::triangle
                                                             : basix::cell::type::quadrilateral;
  std::array<std::vector<double>, 2> made = basix::quadrature::make_quadrature<double>(
      basix::quadrature::type::Default, cell, basix::polyset::type::standard, degree);
  points = std::move(made[0]);
  weights = std::move(made[1]);
}

FacetRule FacetRule::of_segments(const surface::Facets& slave, const surface::Facets& master, std::optional<int> degree)
{
  const bool flat = slave.displacement.shape != surface::FacetShape::quadrilateral && slave.geometry.degree == 1;
  return FacetRule(slave.gdim == 2 ? surface::FacetShape::interval : surface::FacetShape::triangle,
                   degree.value_or(2 * slave.displacement.degree + master.displacement.degree + (flat ? 2 : 4)));
}

MortarGeometry::MortarGeometry(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave,
                               const MortarOptions& options, std::vector<std::int8_t> fixed)
    : _space(std::move(V)), _slave(std::move(slave)), _options(options), _prescribed(std::move(fixed)),
      _size(operators::body_size(*_space->mesh()))
{
  const auto nodal_map = map();
  const std::size_t g = gdim(), all = nodal_map->size_local() + nodal_map->num_ghosts();
  if (_prescribed.size() != all * g)
    throw std::invalid_argument("prescribed degrees of freedom are a mask of all owned and ghost ones");
  increment.start.assign(all * g, 0.0);
  increment.driven.assign(all * g, 0.0);
  // Exact for the shape functions on flat, affine facets, with the radius as weight.
  const FacetRule rule(_slave.displacement.shape, 2 * _slave.displacement.degree + 2);
  _nodes = gap::multiplier_nodes(*_space, _slave, rule.view(), options.basis, options.axisymmetric);
  _numbers.resize(num_nodes());
  nodal_map->local_to_global(_nodes.nodes, _numbers);
  const std::vector<double> x = _space->tabulate_dof_coordinates(false);
  _rest.resize(all * g);
  for (std::size_t node = 0; node < all; ++node)
    std::copy_n(&x[3 * node], g, &_rest[node * g]);
  for (std::int32_t node : _nodes.nodes)
    _fixed.insert(_fixed.end(), &_prescribed[node * g], &_prescribed[node * g] + g);
  offset.assign(num_nodes(), 0.0);
}

void MortarGeometry::join(std::shared_ptr<JoinedNodes> joined, int member)
{
  _joined = std::move(joined);
  _member = member;
}

state::State MortarGeometry::state()
{
  state::State out("geometry");
  out.add("start", state::Place::node, increment.start, gdim());
  out.add("start_displacement", state::Place::all, state::View(std::span<double>(increment.start_displacement)), 3);
  out.add("displacement", state::Place::all, state::View(std::span<double>(increment.displacement)), 3);
  if (turns())
  {
    out.add("start_rotation", state::Place::all, state::View(std::span<double>(increment.start_rotation)), 9);
    out.add("rotation", state::Place::all, state::View(std::span<double>(increment.rotation)), 9);
  }
  return out;
}

MortarGeometry::Elsewhere::Elsewhere(std::vector<MortarGeometry*> geometries) : _geometries(std::move(geometries))
{
  for (MortarGeometry* g : _geometries)
    g->_at = 1;
}

MortarGeometry::Elsewhere::~Elsewhere()
{
  for (MortarGeometry* g : _geometries)
    g->_at = 0;
}

std::vector<double> MortarGeometry::edge_angles() const
{
  return std::vector<double>(num_nodes(), 0.0);
}

void MortarGeometry::forget()
{
  if (_joined)
    _joined->forget();
}

// --- increments and states -------------------------------------------------------------------------------------------

void MortarGeometry::begin_step(std::span<const double> u, const std::optional<std::array<double, 3>>& displacement,
                                std::span<const double> target, const std::optional<gap::Matrix3>& rotation)
{
  if (u.size() != _prescribed.size() || (!target.empty() && target.size() != u.size()))
    throw std::invalid_argument("displacements are those of all owned and ghost nodes of the space");
  std::copy(u.begin(), u.end(), increment.start.begin());
  for (std::size_t i = 0; i < u.size(); ++i)
    increment.driven[i] = !target.empty() && _prescribed[i] ? target[i] - u[i] : 0.0;
  if (displacement)
  {
    increment.start_displacement = increment.displacement;
    increment.displacement = *displacement;
    increment.start_rotation = increment.rotation;
    increment.rotation = rotation.value_or(increment.rotation);
  }
}

void MortarGeometry::move(std::span<const double> u)
{
  if (u.size() != _prescribed.size())
    throw std::invalid_argument("displacements are those of all owned and ghost nodes of the space");
  SlaveNodes& n = now();
  n.u.assign(u.begin(), u.end());
  surface::move(_slave, u.data());
  const std::size_t g = gdim();
  n.points.resize(num_nodes() * g);
  for (std::size_t i = 0; i < num_nodes(); ++i)
    for (std::size_t c = 0; c < g; ++c)
      n.points[i * g + c] = _rest[_nodes.nodes[i] * g + c] + u[_nodes.nodes[i] * g + c];
}

void MortarGeometry::update_gap(std::span<const double> u)
{
  if (_joined)
    _joined->update(u);
  else
    update_alone(u);
}

void MortarGeometry::update_alone(std::span<const double> u)
{
  update_cover(u);
  integrate(covered());
  SlaveNodes& n = now();
  n.locked = n.own_locked;
  update_own_gap(n.locked, nullptr);
  n.part = n.participates;
  n.carrier.assign(num_nodes(), 1);
  n.weight = n.own_weight;
  n.cover = n.own_cover;
  n.gap.assign(num_nodes(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < num_nodes(); ++i)
    if (n.part[i])
      n.gap[i] = n.weighted_gap[i] / n.cover[i];
}

GapAndSlip MortarGeometry::evaluate_at(std::span<const double> u)
{
  if (_joined)
    return _joined->evaluate_at(_member, u);
  const Elsewhere elsewhere({this});
  update_alone(u);
  return {now().gap, slip()};
}

std::vector<double> MortarGeometry::gap_on_the_way(double fraction)
{
  std::vector<double> u(now().u);
  for (std::size_t i = 0; i < u.size(); ++i)
    u[i] = increment.start[i] + fraction * (u[i] - increment.start[i]);
  std::vector<double> out;
  {
    const Elsewhere elsewhere({this});
    update_alone(u);
    out = now().gap;
  }
  surface::move(_slave, now().u.data());
  if (_joined)
    _joined->forget(); // its states elsewhere are these, too
  return out;
}

// --- slips, rows and forces ------------------------------------------------------------------------------------------

std::vector<double> MortarGeometry::moved() const
{
  const std::size_t owned = std::size_t(map()->size_local()) * gdim();
  std::vector<double> out(owned);
  for (std::size_t i = 0; i < owned; ++i)
    out[i] = now().u[i] - increment.start[i];
  return out;
}

std::vector<double> MortarGeometry::ahead() const
{
  return remaining_motion({gdim(), _prescribed, increment.driven, 0.0}, _nodes.nodes, now().u, increment.start);
}

std::vector<double> MortarGeometry::jump(std::span<const double> moved) const
{
  if (_joined)
    return _joined->jump(_member, moved);
  const SlaveNodes& n = now();
  std::vector<double> out = weighted_jump(moved);
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = n.part[k / gdim()] ? out[k] / n.cover[k / gdim()] : 0.0;
  return out;
}

std::vector<double> MortarGeometry::slip() const
{
  return slip_of(jump(moved()));
}

std::vector<double> MortarGeometry::motion_of_master() const
{
  const std::size_t g = gdim();
  std::vector<double> out(num_nodes() * g);
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = increment.displacement[k % g] - increment.start_displacement[k % g];
  if (!turns())
    return out;
  const gap::Matrix3 back = gap::turn_between(increment.rotation, increment.start_rotation);
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    gap::Vector3 arm{};
    for (std::size_t c = 0; c < g; ++c)
      arm[c] = reference_point(nodes()[i])[c] + increment.start[std::size_t(nodes()[i]) * g + c] -
               obstacle()->centre[c] - increment.start_displacement[c];
    const gap::Vector3 turned = gap::times(back, arm);
    for (std::size_t c = 0; c < g; ++c)
      out[i * g + c] -= turned[c];
  }
  return out;
}

std::vector<double> MortarGeometry::slip_of(std::vector<double> jump) const
{
  const std::vector<double> carried = motion_of_master();
  for (std::size_t k = 0; k < jump.size(); ++k)
    jump[k] -= carried[k];
  return tangential(gdim(), now().normal, jump);
}

gap::MasterRows MortarGeometry::master_rows(std::span<const std::int32_t> rows) const
{
  return _joined ? _joined->master_rows(_member, rows) : weighted_rows(rows, now().weight);
}

std::vector<double> MortarGeometry::joined_forces(std::span<const double> traction) const
{
  return _joined ? _joined->forces(_member, traction) : forces(traction);
}

Mat MortarGeometry::springs(std::span<const std::int32_t> rows, std::span<const double> blocks) const
{
  std::vector<std::int32_t> nodes;
  for (std::int32_t i : rows)
    nodes.push_back(_nodes.nodes[i]);
  operators::CooMatrix out;
  gap::assign_springs(*map(), gdim(), nodes, master_rows(rows), blocks, out);
  Mat matrix = out.matrix();
  check(PetscObjectReference(reinterpret_cast<PetscObject>(matrix)), "a matrix is kept");
  return matrix;
}

std::array<std::vector<double>, 2> MortarGeometry::diagonal_stiffness(Mat K) const
{
  const std::size_t owned = map()->size_local(), g = gdim();
  Vec diagonal = nullptr;
  check(MatCreateVecs(K, &diagonal, nullptr), "vectors are made");
  check(MatGetDiagonal(K, diagonal), "a diagonal is read");
  std::vector<double> values(owned);
  {
    operators::Entries entries(diagonal);
    if (entries.size() != owned * g)
      throw std::invalid_argument("the tangent has a row for every owned degree of freedom of the space");
    for (std::size_t node = 0; node < owned; ++node)
    {
      double sum = 0.0;
      for (std::size_t c = 0; c < g; ++c)
        sum += std::abs(entries[node * g + c]);
      values[node] = sum / double(g);
    }
  }
  check(VecDestroy(&diagonal), "a vector is destroyed");
  const SlaveNodes& n = now();
  std::array<std::vector<double>, 2> out{std::vector<double>(num_nodes()),
                                         _joined ? _joined->over_master(_member, values) : over_master(values)};
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    out[0][i] = values[_nodes.nodes[i]];
    const double opposite = _joined || n.part[i] ? out[1][i] : 0.0;
    out[1][i] = std::abs(opposite / (n.participates[i] ? n.weight[i] : 1.0));
  }
  return out;
}

std::vector<double> MortarGeometry::rigid_body_jumps(const operators::RigidBodyModes& modes,
                                                     std::span<const std::int32_t> rows) const
{
  const std::size_t g = gdim(), num = modes.num_modes();
  // Bodies that the nodes of this pair may touch.
  std::vector<std::int32_t> touched(modes.num_bodies(), 0);
  const std::vector<const MortarGeometry*> members =
      _joined ? _joined->members() : std::vector<const MortarGeometry*>{this};
  for (const MortarGeometry* member : members)
    for (const surface::Facets* side : {&member->slave(), member->master()})
      if (side)
        for (std::int32_t node : side->nodes)
          touched[modes.body()[node]] = 1;
  MPI_Allreduce(MPI_IN_PLACE, touched.data(), int(touched.size()), MPI_INT32_T, MPI_MAX, comm());
  std::vector<double> out(rows.size() * g * num, 0.0), mode(num, 0.0);
  for (std::size_t k = 0; k < num; ++k)
  {
    if (!touched[k / modes.per_body()])
      continue;
    mode[k] = 1.0;
    const std::vector<double> jumps = jump(modes.field(mode));
    mode[k] = 0.0;
    for (std::size_t r = 0; r < rows.size(); ++r)
      for (std::size_t a = 0; a < g; ++a)
        out[(r * g + a) * num + k] = jumps[rows[r] * g + a];
  }
  return out;
}

// --- facets around nodes ---------------------------------------------------------------------------------------------

std::vector<double> MortarGeometry::summed_at_nodes(std::vector<double> values) const
{
  const auto nodal_map = map();
  std::vector<double> sums(nodal_map->size_local() + nodal_map->num_ghosts(), 0.0), out(num_nodes());
  for (std::size_t k = 0; k < _slave.nodes.size(); ++k)
    sums[_slave.nodes[k]] += values[k];
  sums = operators::sum_over_ranks(nodal_map, std::move(sums), 1);
  for (std::size_t i = 0; i < num_nodes(); ++i)
    out[i] = sums[_nodes.nodes[i]];
  return out;
}

std::vector<double> MortarGeometry::facet_sizes() const
{
  const std::size_t n = _slave.displacement.num_nodes(), corners = _slave.geometry.num_nodes(), g = gdim();
  std::vector<double> sizes;
  for (std::size_t f = 0; f < _slave.size(); ++f)
  {
    double squared = 0.0;
    for (std::size_t c = 0; c < g; ++c)
    {
      double low = _slave.X_of(f)[c], high = low;
      for (std::size_t i = 1; i < corners; ++i)
      {
        low = std::min(low, _slave.X_of(f)[i * g + c]);
        high = std::max(high, _slave.X_of(f)[i * g + c]);
      }
      squared += (high - low) * (high - low);
    }
    sizes.insert(sizes.end(), n, std::sqrt(squared));
  }
  std::vector<double> out = summed_at_nodes(std::move(sizes));
  const std::vector<double> counts = summed_at_nodes(std::vector<double>(_slave.nodes.size(), 1.0));
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] /= counts[i];
  return out;
}

namespace
{
/// Part of a rim node's length that is in contact, by the ratio r of pressures: polynomial, highest power first, and
/// the most it can be, where the next node begins to touch. Measured on Hertz's line contact between elastic bodies,
/// the edge everywhere between the nodes (13 loads; quadrilaterals, and triangles of degree 2); left is 0.04 of a facet
/// at most.
struct Rim
{
  std::array<double, 3> powers;
  double most;

  double part(double r) const { return std::min((powers[0] * r + powers[1]) * r + powers[2], most); }
};
constexpr Rim corner_of_degree_1{{0.72, 1.0, 0.25}, 1.25}, corner_of_degree_2{{0.0, 1.65, 0.4}, 1.6},
    middle_of_degree_2{{0.0, 1.15, 0.3}, 1.2};
/// On surfaces in space: nodal means of a pressure that falls like the root of the distance from the edge give r =
/// 0.07, 0.28, 0.58 for the edge half a facet before, at, and half a facet behind the node.
constexpr double rim_before = 0.07, rim_length = 0.51;
} // namespace

std::vector<double> MortarGeometry::part_in_contact(std::span<const double> pressure,
                                                    std::span<const std::int8_t> active) const
{
  const auto nodal_map = map();
  const std::size_t size = nodal_map->size_local() + nodal_map->num_ghosts(), n = _slave.displacement.num_nodes();
  if (pressure.size() != num_nodes() || active.size() != num_nodes())
    throw std::invalid_argument("a pressure and a status of every node are needed");
  std::vector<double> known(3 * size, 0.0); // pressure, in contact, known
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    known[3 * _nodes.nodes[i]] = pressure[i];
    known[3 * _nodes.nodes[i] + 1] = active[i];
    known[3 * _nodes.nodes[i] + 2] = 1.0;
  }
  known = operators::from_owners(nodal_map, std::move(known), 3);
  const std::unordered_set<std::int64_t> aside(now().aside.begin(), now().aside.end());
  // Inside the contact the part is 1. At its rim the edge of the contact lies somewhere between the nodes, and the
  // pressure tells where: r is the node's pressure over that of its neighbours further inside.
  std::vector<double> on_rim(_slave.nodes.size(), 0.0), count(on_rim), total(on_rim), middle(on_rim);
  for (std::size_t f = 0; f < _slave.size(); ++f)
  {
    for (std::size_t i = 2; i < n; ++i)
      middle[f * n + i] = 1.0;
    if (aside.contains(_slave.id[f]))
      continue;
    const std::int32_t* nodes = _slave.nodes_of(f);
    const bool rim = std::any_of(nodes, nodes + n, [&](std::int32_t node)
                                 { return known[3 * node + 2] > 0.0 && known[3 * node + 1] == 0.0; });
    // In the plane an end of a facet whose midpoint touches lies further inside.
    const bool inner =
        gdim() == 2 && std::any_of(nodes + 2, nodes + n, [&](std::int32_t node) { return known[3 * node + 1] != 0.0; });
    for (std::size_t i = 0; i < n; ++i)
    {
      on_rim[f * n + i] = rim && !(inner && i < 2);
      for (std::size_t k = 0; k < n; ++k)
        if (known[3 * nodes[k]] > known[3 * nodes[i]])
        {
          count[f * n + i] += 1.0;
          total[f * n + i] += known[3 * nodes[k]];
        }
    }
  }
  on_rim = summed_at_nodes(std::move(on_rim));
  count = summed_at_nodes(std::move(count));
  total = summed_at_nodes(std::move(total));
  middle = summed_at_nodes(std::move(middle));
  std::vector<double> out(num_nodes());
  for (std::size_t i = 0; i < num_nodes(); ++i)
  {
    const double r = pressure[i] * count[i] / (total[i] > 0.0 ? total[i] : 1.0);
    double part = 1.0;
    if (on_rim[i] > 0.0 && total[i] > 0.0)
      part = gdim() == 3                       ? std::clamp((r - rim_before) / rim_length, 0.0, 1.0)
             : middle[i] > 0.0                 ? middle_of_degree_2.part(r)
             : _slave.displacement.degree == 2 ? corner_of_degree_2.part(r)
                                               : corner_of_degree_1.part(r);
    out[i] = active[i] ? part : 0.0;
  }
  return out;
}
} // namespace dolfinx_impact::enforcement
