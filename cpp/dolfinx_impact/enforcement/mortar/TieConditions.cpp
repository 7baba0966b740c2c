// SPDX-License-Identifier: MIT
#include "TieConditions.h"
#include "../../common/gather.h"
#include "../../common/text.h"
#include "../../operators/body_size.h"
#include "../../operators/nodal_sums.h"
#include "../../operators/petsc_check.h"
#include "MortarGeometry.h"
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
using operators::check;

namespace
{
/// Places in a message.
constexpr std::size_t places_told = 3;

/// Vectors that fit a square matrix, destroyed with this.
struct TwoVectors
{
  explicit TwoVectors(Mat A) { check(MatCreateVecs(A, &source, &result), "vectors are made"); }
  ~TwoVectors()
  {
    VecDestroy(&source);
    VecDestroy(&result);
  }
  TwoVectors(const TwoVectors&) = delete;
  TwoVectors& operator=(const TwoVectors&) = delete;
  Vec source = nullptr, result = nullptr;
};
} // namespace

TieConditions::TieConditions(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave,
                             surface::Facets master, const TieOptions& options, std::vector<std::int8_t> fixed)
    : _space(std::move(V)), _slave(std::move(slave)), _master(std::move(master)), _options(options),
      _fixed(std::move(fixed)), _size(operators::body_size(*_space->mesh()))
{
  const auto map = _space->dofmap()->index_map;
  const std::size_t all = (map->size_local() + map->num_ghosts()) * std::size_t(gdim());
  if (_fixed.size() != all)
    throw std::invalid_argument("prescribed degrees of freedom are a mask of all owned and ghost ones");
  // Exact for the shape functions on flat, affine facets, with the radius as weight.
  const FacetRule whole(_slave.displacement.shape, 2 * _slave.displacement.degree + 2);
  const FacetRule rule = FacetRule::of_segments(_slave, _master, _options.quadrature_degree);
  auto search = std::make_shared<search::PairSearch>(_space, _slave, _master, _options.search_distance);
  _integrals = std::make_unique<gap::MortarIntegrals>(
      _space, std::move(search),
      gap::multiplier_nodes(*_space, _slave, whole.view(), _options.basis, _options.axisymmetric), rule.view(),
      _options.basis, _options.axisymmetric);
  const std::vector<double> rest(all, 0.0);
  _integrals->update_cover(rest, rest);
  find_nodes();
  leave_out(std::vector<std::int8_t>(std::size_t(map->size_local()) * gdim(), 0));
}

/// Slave nodes that face the master; the others are told, or refused. Collective.
void TieConditions::find_nodes()
{
  const std::size_t g = gdim();
  const std::vector<std::int8_t> covered = _integrals->covered();
  const std::vector<std::int32_t>& candidates = _integrals->nodes().nodes;
  const std::vector<double> x = _space->tabulate_dof_coordinates(false);
  std::vector<double> lost;
  std::vector<std::int64_t> lost_numbers;
  std::vector<std::int32_t> without;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (covered[i])
    {
      _places.push_back(std::int32_t(i));
      _nodes.push_back(candidates[i]);
    }
    else
      without.push_back(candidates[i]);
  const auto map = _space->dofmap()->index_map;
  _numbers.resize(_nodes.size());
  map->local_to_global(_nodes, _numbers);
  for (std::int32_t node : _nodes)
    _points.insert(_points.end(), &x[3 * node], &x[3 * node] + g);
  _num_free = common::sum(comm(), (long long)without.size());
  const long long tied = common::sum(comm(), (long long)_nodes.size());
  if (_num_free == 0 || (_options.partial && tied > 0))
    return;
  without.resize(std::min(without.size(), places_told));
  lost_numbers.resize(without.size());
  map->local_to_global(without, lost_numbers);
  for (std::int32_t node : without)
    lost.insert(lost.end(), &x[3 * node], &x[3 * node] + g);
  std::vector<double> places = common::gather(comm(), lost);
  std::vector<std::int64_t> numbers = common::gather(comm(), lost_numbers);
  places.resize(std::min(places.size(), places_told * g));
  numbers.resize(std::min(numbers.size(), places_told));
  std::vector<std::string> words;
  for (std::int64_t number : numbers)
    words.push_back(std::to_string(number));
  const std::string first =
      "the first at " + common::places(places, int(g)) + " (nodes " + common::joined(words, ", ") + " of all ranks)";
  if (tied == 0)
    throw std::invalid_argument(_options.name + ": none of the " + std::to_string(_num_free) +
                                " slave nodes has a master to be tied to, " + first +
                                ": the surfaces are farther apart than the search distance, or do not face each other");
  throw std::invalid_argument(_options.name + ": " + std::to_string(_num_free) + " of " +
                              std::to_string(_num_free + tied) + " slave nodes have no master to be tied to, " + first +
                              ": exchange slave and master, tag fewer facets, or leave these nodes free with "
                              "partial=True");
}

/// Which nodes carry a multiplier, by direction: masks over those that may have one.
std::vector<std::vector<std::int8_t>> TieConditions::carriers(std::span<const std::int8_t> taken) const
{
  const std::size_t g = gdim(), num = _integrals->nodes().nodes.size();
  std::vector<std::vector<std::int8_t>> out(_options.normal_only ? 1 : g, std::vector<std::int8_t>(num, 0));
  for (std::size_t i = 0; i < _nodes.size(); ++i)
    for (std::size_t d = 0; d < out.size(); ++d)
    {
      const std::int8_t *held = &taken[_nodes[i] * g], *fixed = &_fixed[_nodes[i] * g];
      out[d][_places[i]] =
          _options.normal_only ? std::none_of(held, held + g, [](auto h) { return h; }) : !held[d] && !fixed[d];
    }
  if (!_options.normal_only)
    return out;
  // A normal with no part along free components cannot be a condition.
  std::vector<std::int8_t> fixed;
  for (std::int32_t node : _nodes)
    fixed.insert(fixed.end(), &_fixed[node * g], &_fixed[node * g] + g);
  const NodalFrames frames = frames_at(int(g), _normal, fixed);
  for (std::size_t i = 0; i < _nodes.size(); ++i)
    out[0][_places[i]] = out[0][_places[i]] && frames.place[i] >= 0;
  return out;
}

void TieConditions::leave_out(std::span<const std::int8_t> taken)
{
  const std::size_t g = gdim(), num = _nodes.size();
  const auto map = _space->dofmap()->index_map;
  const std::int64_t first = map->local_range()[0];
  if (taken.size() != std::size_t(map->size_local()) * g)
    throw std::invalid_argument("components that other ties hold are a mask of the owned degrees of freedom");
  if (_normal.empty())
  {
    const std::vector<double> sums = _integrals->sums_at_nodes();
    for (std::int32_t i : _places)
    {
      double length = 0.0;
      for (std::size_t c = 0; c < g; ++c)
        length += sums[i * g + c] * sums[i * g + c];
      for (std::size_t c = 0; c < g; ++c)
        _normal.push_back(sums[i * g + c] / std::sqrt(length));
    }
    for (std::int32_t i : _places)
      _area.push_back(_integrals->around[i]);
  }
  const std::vector<std::vector<std::int8_t>> carriers = this->carriers(taken);
  std::vector<std::int8_t> fixed;
  for (std::int32_t node : _nodes)
    fixed.insert(fixed.end(), &_fixed[node * g], &_fixed[node * g] + g);
  const NodalFrames frames = frames_at(int(g), _normal, fixed);

  // Rows of P of every direction; those of one set of carriers are integrated once.
  struct Direction
  {
    gap::MasterRows rows;
    std::vector<double> weight, cover;
  };
  std::vector<Direction> found(carriers.size());
  for (std::size_t d = 0; d < carriers.size(); ++d)
  {
    int differs = d == 0 || carriers[d] != carriers[d - 1];
    MPI_Allreduce(MPI_IN_PLACE, &differs, 1, MPI_INT, MPI_MAX, comm());
    if (!differs)
    {
      found[d] = found[d - 1];
      continue;
    }
    _integrals->integrate(carriers[d]);
    std::vector<std::int32_t> places;
    std::ranges::copy_if(_places, std::back_inserter(places), [&](std::int32_t i) { return carriers[d][i]; });
    found[d].rows = _integrals->master_rows(places);
    for (std::int32_t i : places)
    {
      found[d].weight.push_back(_integrals->weight[i]);
      found[d].cover.push_back(_integrals->cover[i]);
    }
  }

  _rows = Constraints{};
  _rows.gdim = int(g);
  _rows.tied = true;
  _rows.pointers = {0};
  for (std::vector<double>* values : {&_weight, &_cover, &_directions, &_length})
    values->clear();
  std::vector<std::size_t> next(found.size(), 0); // row of each direction
  operators::CooMatrix::Entries entries;
  for (std::size_t i = 0; i < num; ++i)
  {
    std::vector<std::int8_t> constrained(g, 0);
    std::map<std::int64_t, std::array<double, 3>> columns;
    std::array<double, 3> weight{}, cover{};
    for (std::size_t d = 0; d < found.size(); ++d)
    {
      if (!carriers[d][_places[i]])
        continue;
      const std::size_t at = _options.normal_only ? frames.place[i] : d, row = next[d]++;
      constrained[at] = 1;
      weight[at] = found[d].weight[row];
      cover[at] = found[d].cover[row];
      const gap::MasterRows& P = found[d].rows;
      for (std::int64_t k = P.pointers[row]; k < P.pointers[row + 1]; ++k)
        columns[P.columns[k]][at] += P.values[k];
    }
    if (std::ranges::none_of(constrained, [](auto c) { return c; }))
      continue;
    _rows.rows.push_back(std::int32_t(i));
    _rows.nodes.push_back(_nodes[i]);
    _rows.constrained.insert(_rows.constrained.end(), constrained.begin(), constrained.end());
    _rows.normal.push_back(_options.normal_only ? frames.place[i] : 0);
    _weight.insert(_weight.end(), weight.begin(), weight.begin() + g);
    _cover.insert(_cover.end(), cover.begin(), cover.begin() + g);
    for (std::size_t a = 0; a < g; ++a)
      for (std::size_t d = 0; d < g; ++d)
      {
        const double axis = a == d ? 1.0 : 0.0;
        const bool normal = _options.normal_only && std::int32_t(d) == frames.place[i];
        _rows.frames.push_back(_options.normal_only ? frames.frames[(i * g + a) * g + d] : axis);
        _directions.push_back(!_options.normal_only ? axis : normal ? _normal[i * g + a] : 0.0);
        _rows.over.push_back(normal ? _normal[i * g + a] / frames.length[i] : _rows.frames.back());
      }
    for (std::size_t d = 0; d < g; ++d)
      _length.push_back(_options.normal_only && constrained[d] ? frames.length[i] : 1.0);
    for (const auto& [column, values] : columns)
    {
      _rows.columns.push_back(column);
      _rows.values.insert(_rows.values.end(), values.begin(), values.begin() + g);
    }
    _rows.pointers.push_back(std::int64_t(_rows.columns.size()));

    const std::size_t last = _rows.size() - 1;
    for (std::size_t d = 0; d < g; ++d)
    {
      if (!constrained[d])
        continue;
      const PetscInt row = PetscInt((first + _nodes[i]) * g + d);
      for (std::size_t a = 0; a < g; ++a)
      {
        const double along = weight[d] * _directions[(last * g + a) * g + d];
        if (along == 0.0)
          continue;
        entries.add(row, PetscInt((first + _nodes[i]) * g + a), along);
        for (const auto& [column, values] : columns)
          entries.add(row, PetscInt(column * g + a), -values[d] * along);
      }
    }
  }
  _rows.known.assign(_rows.size() * g, 0.0);
  _rows.tilt.assign(_rows.size() * g, 0.0);
  const PetscInt owned = PetscInt(map->size_local() * g);
  _matrix.assign(comm(), owned, owned, 1, std::move(entries));

  const std::vector<double> x = _space->tabulate_dof_coordinates(false);
  std::vector<double> positions;
  for (std::int32_t node = 0; node < map->size_local(); ++node)
    positions.insert(positions.end(), &x[3 * node], &x[3 * node] + g);
  _offset = jump(positions);
}

std::vector<double> TieConditions::jump(std::span<const double> u) const
{
  const std::size_t g = gdim();
  if (u.size() < std::size_t(_space->dofmap()->index_map->size_local()) * g)
    throw std::invalid_argument("nodal values are those of all owned nodes of the space");
  TwoVectors v(matrix());
  {
    operators::Entries source(v.source);
    for (std::size_t i = 0; i < source.size(); ++i)
      source[i] = u[i];
  }
  check(MatMult(matrix(), v.source, v.result), "C is applied");
  operators::Entries product(v.result);
  std::vector<double> out(_nodes.size() * g, 0.0);
  for (std::size_t k = 0; k < _rows.size(); ++k)
    for (std::size_t d = 0; d < g; ++d)
      if (_rows.constrained[k * g + d])
        out[_rows.rows[k] * g + d] = product[_rows.nodes[k] * g + d] / _weight[k * g + d];
  return out;
}

std::vector<double> TieConditions::forces(std::span<const double> z) const
{
  const std::size_t g = gdim();
  if (z.size() != _nodes.size() * g)
    throw std::invalid_argument("a multiplier of every slave node and direction is needed");
  TwoVectors v(matrix());
  check(VecZeroEntries(v.source), "a vector is zeroed");
  {
    operators::Entries source(v.source);
    for (std::size_t k = 0; k < _rows.size(); ++k)
      for (std::size_t d = 0; d < g; ++d)
        if (_rows.constrained[k * g + d])
          source[_rows.nodes[k] * g + d] = z[_rows.rows[k] * g + d];
  }
  check(MatMultTranspose(matrix(), v.source, v.result), "C is applied");
  return operators::values_of(v.result);
}

std::vector<double> TieConditions::traction(std::span<const double> z) const
{
  const std::size_t g = gdim();
  std::vector<double> out(_nodes.size() * g, 0.0);
  for (std::size_t k = 0; k < _rows.size(); ++k)
    for (std::size_t a = 0; a < g; ++a)
      for (std::size_t d = 0; d < g; ++d)
        out[_rows.rows[k] * g + a] += _directions[(k * g + a) * g + d] * z[_rows.rows[k] * g + d];
  return out;
}

std::vector<double> TieConditions::rigid_body_products(const operators::RigidBodyModes& modes) const
{
  const int num = modes.num_modes();
  std::vector<std::int32_t> touched(modes.num_bodies(), 0);
  for (const surface::Facets* side : {&_slave, &_master})
    for (std::int32_t node : side->nodes)
      touched[modes.body()[node]] = 1;
  MPI_Allreduce(MPI_IN_PLACE, touched.data(), int(touched.size()), MPI_INT32_T, MPI_MAX, comm());
  std::vector<std::vector<double>> jumps(num);
  std::vector<double> mode(num, 0.0), out(std::size_t(num) * num, 0.0);
  for (int k = 0; k < num; ++k)
    if (touched[k / modes.per_body()])
    {
      mode[k] = 1.0;
      jumps[k] = jump(modes.field(mode));
      mode[k] = 0.0;
    }
  for (int i = 0; i < num; ++i)
    for (int j = 0; j < num; ++j)
      for (std::size_t r = 0; r < jumps[i].size() && r < jumps[j].size(); ++r)
        out[i * num + j] += jumps[i][r] * jumps[j][r];
  return out;
}

std::vector<std::int8_t> TieConditions::marks(bool slave, bool master) const
{
  const auto map = _space->dofmap()->index_map;
  std::vector<double> sums(map->size_local() + map->num_ghosts(), 0.0);
  if (slave)
    for (std::int32_t node : _slave.nodes)
      sums[node] = 1.0;
  if (master)
    for (std::int32_t node : _master.nodes)
      sums[node] = 1.0;
  sums = operators::sum_over_ranks(map, std::move(sums), 1);
  std::vector<std::int8_t> out(sums.size());
  std::ranges::transform(sums, out.begin(), [](double s) { return s > 0.0; });
  return out;
}
} // namespace dolfinx_impact::enforcement
