// SPDX-License-Identifier: MIT
#include "MortarIntegrals.h"
#include "../operators/nodal_sums.h"
#include "../operators/petsc_check.h"
#include "../search/pairs.h"
#include "facing.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace dolfinx_impact::gap
{
using dolfinx::common::IndexMap;
using operators::check;

namespace
{
std::vector<std::int64_t> global_nodes(const IndexMap& map)
{
  std::vector<std::int32_t> local(map.size_local() + map.num_ghosts());
  for (std::size_t i = 0; i < local.size(); ++i)
    local[i] = std::int32_t(i);
  std::vector<std::int64_t> out(local.size());
  map.local_to_global(local, out);
  return out;
}

/// Vectors that fit a matrix, destroyed with this.
struct Vectors
{
  Vec right = nullptr, left = nullptr;
  explicit Vectors(Mat A) { check(MatCreateVecs(A, &right, &left), "vectors are made"); }
  ~Vectors()
  {
    VecDestroy(&right);
    VecDestroy(&left);
  }
};
} // namespace

MultiplierNodes multiplier_nodes(const surface::FunctionSpace& V, const surface::Facets& slave, const SegmentRule& rule,
                                 Multipliers basis, bool axisymmetric)
{
  const auto map = V.dofmap()->index_map;
  const int n = slave.displacement.num_nodes();
  const Segments whole = whole_facets(slave, rule, axisymmetric);
  const std::vector<double> integrals = cover(slave, whole, basis);
  std::vector<double> areas(slave.size(), 0.0), values(2 * (map->size_local() + map->num_ghosts()), 0.0);
  for (std::size_t q = 0; q < whole.weight.size(); ++q)
    areas[whole.slave[q]] += whole.weight[q];
  for (std::size_t f = 0; f < slave.size(); ++f)
    for (int i = 0; i < n; ++i)
    {
      values[2 * slave.nodes_of(f)[i]] += integrals[f * n + i];
      values[2 * slave.nodes_of(f)[i] + 1] += areas[f];
    }
  values = operators::sum_over_ranks(map, std::move(values), 2);
  MultiplierNodes out;
  for (std::size_t f = 0; f < slave.size(); ++f)
    out.facet_area[slave.id[f]] = areas[f];
  // On quadratic triangles the shares of the corners vanish (on curved ones they are small, of either sign): the
  // multipliers live at the midpoints of the edges; linear ones live at the corners.
  for (std::int32_t node = 0; node < map->size_local(); ++node)
    if (values[2 * node] > least_share * values[2 * node + 1])
    {
      out.nodes.push_back(node);
      out.share.push_back(values[2 * node]);
      out.area.push_back(values[2 * node + 1]);
    }
  return out;
}

std::vector<double> MultiplierNodes::counted_area(const std::shared_ptr<const IndexMap>& map,
                                                  const surface::Facets& slave,
                                                  std::span<const std::int8_t> counts) const
{
  const int n = slave.displacement.num_nodes();
  std::vector<double> sums(map->size_local() + map->num_ghosts(), 0.0), out(nodes.size());
  for (std::size_t f = 0; f < slave.size(); ++f)
    for (int i = 0; i < n; ++i)
      if (counts[f * n + i])
        sums[slave.nodes_of(f)[i]] += facet_area.at(slave.id[f]);
  sums = operators::sum_over_ranks(map, std::move(sums), 1);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    out[i] = sums[nodes[i]];
  return out;
}

std::vector<std::int64_t> aside(const surface::Facets& slave, std::span<const std::int8_t> counts)
{
  const int n = slave.displacement.num_nodes();
  std::vector<std::int64_t> out;
  for (std::size_t f = 0; f < slave.size() && !counts.empty(); ++f)
    if (std::any_of(&counts[f * n], &counts[f * n] + n, [](std::int8_t one) { return !one; }))
      out.push_back(slave.id[f]);
  return out;
}

MortarIntegrals::MortarIntegrals(std::shared_ptr<const surface::FunctionSpace> V,
                                 std::shared_ptr<search::PairSearch> search, MultiplierNodes nodes,
                                 const SegmentRule& rule, Multipliers basis, bool axisymmetric)
    : _space(std::move(V)), _search(std::move(search)), _nodes(std::move(nodes)),
      _points(rule.points.begin(), rule.points.end()), _weights(rule.weights.begin(), rule.weights.end()),
      _basis(basis), _axisymmetric(axisymmetric)
{
}

// PETSc's layouts keep the communicator without duplicating it: that of the search ends with the next exchange, while
// matrices whose places stay the same are kept.
MPI_Comm MortarIntegrals::comm() const
{
  return _space->mesh()->comm();
}

std::vector<double> MortarIntegrals::summed(std::vector<double> values, int block, bool forward_only) const
{
  return forward_only ? operators::from_owners(_map, std::move(values), block)
                      : operators::sum_over_ranks(_map, std::move(values), block);
}

void MortarIntegrals::update_cover(std::span<const double> u, std::span<const double> start)
{
  _search->update(u, start);
  _map = _search->map();
  const surface::Facets &slave = _search->slave(), &master = _search->master();
  const int gdim = slave.gdim, n = slave.displacement.num_nodes();
  const std::size_t size = _map->size_local() + _map->num_ghosts(), num = _nodes.nodes.size();
  const auto near = search::near_facets(slave, master, _search->reach());
  _segments = segment(slave, master, near.pairs, near.offsets, {_points, _weights}, _search->reach(), _axisymmetric);
  _counts = counting(_map, slave, facing(slave, master, _segments));
  for (std::size_t f = 0; f < slave.size(); ++f)
    if (std::any_of(&_counts[f * n], &_counts[f * n] + n, [](std::int8_t counts) { return !counts; }))
      _segments.covered[f] = 0.0;

  std::vector<double> sums(size, 0.0), normals(size * gdim, 0.0);
  const std::vector<double> covers = gap::cover(slave, _segments, _basis, least_cover);
  for (std::size_t i = 0; i < covers.size(); ++i)
    sums[slave.nodes[i]] += covers[i];
  sums = summed(std::move(sums), 1);
  around.resize(num);
  for (std::size_t i = 0; i < num; ++i)
    around[i] = sums[_nodes.nodes[i]];
  _area = _nodes.counted_area(_map, slave, _counts);
  add_normals(slave, normals, _counts);
  _sums = summed(std::move(normals), gdim);
}

std::vector<std::int8_t> MortarIntegrals::covered() const
{
  std::vector<std::int8_t> out(around.size());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = around[i] > least_share * _area[i];
  return out;
}

std::vector<double> MortarIntegrals::sums_at_nodes() const
{
  const int gdim = _search->slave().gdim;
  std::vector<double> out(_nodes.nodes.size() * gdim);
  for (std::size_t i = 0; i < _nodes.nodes.size(); ++i)
    std::copy_n(&_sums[std::size_t(_nodes.nodes[i]) * gdim], gdim, &out[i * gdim]);
  return out;
}

void MortarIntegrals::set_sums(std::span<const double> sums)
{
  const int gdim = _search->slave().gdim;
  if (sums.size() != _nodes.nodes.size() * gdim)
    throw std::invalid_argument("a sum of normals at every node that may carry a multiplier is needed");
  for (std::size_t i = 0; i < _nodes.nodes.size(); ++i)
    std::copy_n(&sums[i * gdim], gdim, &_sums[std::size_t(_nodes.nodes[i]) * gdim]);
  _sums = summed(std::move(_sums), gdim, true);
}

void MortarIntegrals::integrate(std::span<const std::int8_t> carriers)
{
  const surface::Facets &slave = _search->slave(), &master = _search->master();
  const int gdim = slave.gdim;
  const std::size_t size = _map->size_local() + _map->num_ghosts(), num = _nodes.nodes.size();
  if (carriers.size() != num)
    throw std::invalid_argument("a mask of all nodes that may carry a multiplier is needed");
  std::vector<double> carries(size, 0.0);
  participates.assign(carriers.begin(), carriers.end());
  for (std::size_t i = 0; i < num; ++i)
    carries[_nodes.nodes[i]] = participates[i];
  carries = summed(std::move(carries), 1, true);
  const std::vector<std::int8_t> flags(carries.begin(), carries.end());
  _mortar = mortar(slave, master, _segments, _basis, flags, least_cover);

  // By node: diagonal of D, sum of its row (the shape functions add up to one), weighted gap vector, facet normals.
  std::vector<double> sums(size * (2 + gdim), 0.0);
  for (std::size_t k = 0; k < _mortar.D.values.size(); ++k)
  {
    double* at = &sums[_mortar.D.rows[k] * (2 + gdim)];
    at[0] += _mortar.D.rows[k] == _mortar.D.cols[k] ? _mortar.D.values[k] : 0.0;
    at[1] += _mortar.D.values[k];
  }
  for (std::size_t i = 0; i < slave.nodes.size(); ++i)
    for (int c = 0; c < gdim; ++c)
      sums[slave.nodes[i] * (2 + gdim) + 2 + c] += _mortar.gamma[i * gdim + c];
  sums = summed(std::move(sums), 2 + gdim);
  weight.resize(num);
  cover.resize(num);
  _gamma.resize(num * gdim);
  for (std::size_t i = 0; i < num; ++i)
  {
    const double* at = &sums[_nodes.nodes[i] * (2 + gdim)];
    weight[i] = at[0];
    cover[i] = at[1];
    std::copy_n(at + 2, gdim, &_gamma[i * gdim]);
  }

  const auto global = global_nodes(*_map);
  operators::CooMatrix::Entries entries;
  for (std::size_t k = 0; k < _mortar.M.values.size(); ++k)
    entries.add(PetscInt(global[_mortar.M.rows[k]]), PetscInt(global[_mortar.M.cols[k]]), _mortar.M.values[k]);
  // Slave nodes beside the diagonal of D, without a multiplier of their own, stand among the master's.
  for (std::size_t k = 0; k < _mortar.D.values.size(); ++k)
    if (_mortar.D.rows[k] != _mortar.D.cols[k])
      entries.add(PetscInt(global[_mortar.D.rows[k]]), PetscInt(global[_mortar.D.cols[k]]), -_mortar.D.values[k]);
  _mortar_matrix.assign(comm(), _map->size_local(), _map->size_local(), 1, std::move(entries));
}

void MortarIntegrals::update_gap(std::span<const std::int8_t> locked, double symmetry)
{
  const std::size_t num = _nodes.nodes.size();
  const int gdim = _search->slave().gdim;
  normal.resize(num * gdim);
  gap.assign(num, std::numeric_limits<double>::infinity());
  weighted_gap.assign(num, 0.0);
  for (std::size_t i = 0; i < num; ++i)
  {
    double* n = &normal[i * gdim];
    const auto normalise = [&]()
    {
      double length = 0.0;
      for (int c = 0; c < gdim; ++c)
        length += n[c] * n[c];
      for (int c = 0; c < gdim; ++c)
        n[c] /= std::sqrt(length);
    };
    std::copy_n(&_sums[_nodes.nodes[i] * gdim], gdim, n);
    normalise();
    for (int c = 0; c < gdim && !locked.empty(); ++c)
      if (locked[i * gdim + c] && std::abs(n[c]) < symmetry)
        n[c] = 0.0;
    normalise();
    if (!participates[i])
      continue;
    double sum = 0.0;
    for (int c = 0; c < gdim; ++c)
      sum += n[c] * _gamma[i * gdim + c];
    weighted_gap[i] = sum;
    gap[i] = sum / cover[i];
  }
}

Mat MortarIntegrals::jump_matrix()
{
  const auto global = global_nodes(*_map);
  operators::CooMatrix::Entries entries;
  for (std::size_t k = 0; k < _mortar.D.values.size(); ++k)
    entries.add(PetscInt(global[_mortar.D.rows[k]]), PetscInt(global[_mortar.D.cols[k]]), _mortar.D.values[k]);
  for (std::size_t k = 0; k < _mortar.M.values.size(); ++k)
    entries.add(PetscInt(global[_mortar.M.rows[k]]), PetscInt(global[_mortar.M.cols[k]]), -_mortar.M.values[k]);
  _jump.assign(comm(), _map->size_local(), _map->size_local(), 1, std::move(entries));
  return _jump.matrix();
}

std::vector<double> MortarIntegrals::over_master(std::span<const double> values, int block) const
{
  const std::size_t owned = _map->size_local(), num = _nodes.nodes.size();
  if (values.size() < owned * block)
    throw std::invalid_argument("nodal values are those of all owned nodes of the space");
  Vectors v(_mortar_matrix.matrix());
  std::vector<double> out(num * block);
  for (int c = 0; c < block; ++c)
  {
    {
      operators::Entries source(v.right);
      for (std::size_t i = 0; i < owned; ++i)
        source[i] = values[i * block + c];
    }
    check(MatMult(_mortar_matrix.matrix(), v.right, v.left), "M is applied");
    operators::Entries product(v.left);
    for (std::size_t i = 0; i < num; ++i)
      out[i * block + c] = product[_nodes.nodes[i]];
  }
  return out;
}

std::vector<double> MortarIntegrals::weighted_jump(std::span<const double> moved) const
{
  const int gdim = _search->slave().gdim;
  std::vector<double> out = over_master(moved, gdim);
  for (std::size_t i = 0; i < _nodes.nodes.size(); ++i)
    for (int c = 0; c < gdim; ++c)
      out[i * gdim + c] = participates[i] ? weight[i] * moved[_nodes.nodes[i] * gdim + c] - out[i * gdim + c] : 0.0;
  return out;
}

std::vector<double> MortarIntegrals::contact_forces(std::span<const double> traction) const
{
  const int gdim = _search->slave().gdim;
  const std::size_t owned = _map->size_local(), num = _nodes.nodes.size();
  if (traction.size() != num * gdim)
    throw std::invalid_argument("a traction at every node that may carry a multiplier is needed");
  std::vector<double> out(owned * gdim, 0.0);
  Vectors v(_mortar_matrix.matrix());
  for (int c = 0; c < gdim; ++c)
  {
    check(VecZeroEntries(v.left), "a vector is zeroed");
    {
      operators::Entries z(v.left);
      for (std::size_t i = 0; i < num; ++i)
        if (participates[i])
        {
          z[_nodes.nodes[i]] = traction[i * gdim + c];
          out[_nodes.nodes[i] * gdim + c] = weight[i] * traction[i * gdim + c];
        }
    }
    check(MatMultTranspose(_mortar_matrix.matrix(), v.left, v.right), "M is applied");
    operators::Entries product(v.right);
    for (std::size_t i = 0; i < owned; ++i)
      out[i * gdim + c] -= product[i];
  }
  return out;
}

MasterRows MortarIntegrals::master_rows(std::span<const std::int32_t> rows, std::span<const double> weights) const
{
  if (weights.size() != _nodes.nodes.size())
    throw std::invalid_argument("a weight of every node that may carry a multiplier is needed");
  MasterRows out{{0}, {}, {}};
  PetscInt first = 0;
  check(MatGetOwnershipRange(_mortar_matrix.matrix(), &first, nullptr), "M is read");
  for (std::int32_t i : rows)
  {
    const PetscInt row = first + _nodes.nodes[i];
    PetscInt num = 0;
    const PetscInt* columns = nullptr;
    const double* values = nullptr;
    check(MatGetRow(_mortar_matrix.matrix(), row, &num, &columns, &values), "M is read");
    out.columns.insert(out.columns.end(), columns, columns + num);
    for (PetscInt k = 0; k < num; ++k)
      out.values.push_back(values[k] / weights[i]);
    check(MatRestoreRow(_mortar_matrix.matrix(), row, &num, &columns, &values), "M is read");
    out.pointers.push_back(std::int64_t(out.columns.size()));
  }
  return out;
}

Mat MortarIntegrals::tangent(std::span<const double> multiplier, std::span<const double> traction,
                             std::span<const std::int8_t> active)
{
  const surface::Facets &slave = _search->slave(), &master = _search->master();
  const int gdim = slave.gdim;
  const std::size_t size = _map->size_local() + _map->num_ghosts(), num = _nodes.nodes.size();
  if (multiplier.size() != num || traction.size() != num * gdim || active.size() != num)
    throw std::invalid_argument("multiplier, traction and active are arrays of all nodes that may carry a multiplier");
  std::vector<double> z(size * gdim, 0.0), force(size, 0.0);
  std::vector<std::int32_t> rows;
  int any = 0;
  for (std::size_t i = 0; i < num; ++i)
    if (active[i])
    {
      rows.push_back(std::int32_t(i));
      any |= multiplier[i] != 0.0;
      std::copy_n(&traction[i * gdim], gdim, &z[_nodes.nodes[i] * gdim]);
      force[_nodes.nodes[i]] = multiplier[i] * weight[i];
    }
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, _map->comm());
  if (!any)
    return nullptr;
  z = summed(std::move(z), gdim, true);
  force = summed(std::move(force), 1, true);
  const auto global = global_nodes(*_map);
  const PetscInt owned = _map->size_local() * gdim;
  const auto assign = [&](const gap::Entries& in, operators::CooMatrix& out)
  {
    operators::CooMatrix::Entries entries;
    for (std::size_t k = 0; k < in.values.size(); ++k)
      entries.add(PetscInt(gdim * global[in.rows[k] / gdim] + in.rows[k] % gdim),
                  PetscInt(gdim * global[in.cols[k] / gdim] + in.cols[k] % gdim), in.values[k]);
    out.assign(comm(), owned, owned, gdim, std::move(entries));
  };
  assign(sliding_tangent(slave, master, _segments, _mortar, z), _sliding);
  assign(turning_tangent(slave, _sums, force, _counts), _turning);
  // What turns on the slave turns on the master.
  const MasterRows facing = master_rows(rows);
  operators::CooMatrix::Entries jump;
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (int c = 0; c < gdim; ++c)
    {
      const PetscInt row = PetscInt(gdim * global[_nodes.nodes[rows[k]]] + c);
      jump.add(row, row, 1.0);
      for (std::int64_t p = facing.pointers[k]; p < facing.pointers[k + 1]; ++p)
        jump.add(row, PetscInt(gdim * facing.columns[p] + c), -facing.values[p]);
    }
  _facing.assign(comm(), owned, owned, gdim, std::move(jump));
  Mat both = nullptr;
  check(MatTransposeMatMult(_facing.matrix(), _turning.matrix(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, &both),
        "matrices are multiplied");
  _tangent.reset(both, [](Mat m) { MatDestroy(&m); });
  check(MatAXPY(both, 1.0, _sliding.matrix(), DIFFERENT_NONZERO_PATTERN), "matrices are added");
  return both;
}

void assign_springs(const IndexMap& map, int gdim, std::span<const std::int32_t> nodes, const MasterRows& rows,
                    std::span<const double> blocks, operators::CooMatrix& out)
{
  const std::int64_t first = map.local_range()[0];
  operators::CooMatrix::Entries entries;
  std::vector<std::pair<std::int64_t, double>> jump; // nodes and their parts in the jump
  for (std::size_t k = 0; k < nodes.size(); ++k)
  {
    jump.assign(1, {first + nodes[k], 1.0});
    for (std::int64_t p = rows.pointers.empty() ? 0 : rows.pointers[k];
         !rows.pointers.empty() && p < rows.pointers[k + 1]; ++p)
      jump.emplace_back(rows.columns[p], -rows.values[p]);
    for (const auto& [i, a] : jump)
      for (const auto& [j, b] : jump)
        for (int c = 0; c < gdim; ++c)
          for (int d = 0; d < gdim; ++d)
            entries.add(PetscInt(gdim * i + c), PetscInt(gdim * j + d), a * b * blocks[(k * gdim + c) * gdim + d]);
  }
  out.assign(map.comm(), gdim * map.size_local(), gdim * map.size_local(), gdim, std::move(entries));
}
} // namespace dolfinx_impact::gap
