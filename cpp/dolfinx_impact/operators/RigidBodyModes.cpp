// SPDX-License-Identifier: MIT
#include "RigidBodyModes.h"
#include "../common/gather.h"
#include <algorithm>
#include <cmath>
#include <numeric>

namespace dolfinx_impact::operators
{
namespace
{
/// Sets that are united (disjoint-set forest). The root of a set is its least member.
class DisjointSets
{
public:
  explicit DisjointSets(std::size_t size) : _parent(size) { std::iota(_parent.begin(), _parent.end(), 0); }

  std::int32_t root(std::int32_t i)
  {
    while (_parent[i] != i)
      i = _parent[i] = _parent[_parent[i]];
    return i;
  }

  void unite(std::int32_t i, std::int32_t j)
  {
    i = root(i);
    j = root(j);
    _parent[std::max(i, j)] = std::min(i, j);
  }

private:
  std::vector<std::int32_t> _parent;
};

/// Coordinate axes that rotation k of a body turns: from the first towards the second.
std::array<int, 2> turned_axes(int gdim, int k)
{
  static constexpr std::array<std::array<int, 2>, 3> in_space{{{1, 2}, {2, 0}, {0, 1}}};
  return gdim == 2 ? std::array{0, 1} : in_space[k];
}
} // namespace

Bodies bodies(const dolfinx::fem::FunctionSpace<double>& V)
{
  const MPI_Comm comm = V.mesh()->comm();
  const auto map = V.dofmap()->index_map;
  const std::int32_t num_owned = map->size_local(), num_ghosts = map->num_ghosts();
  const auto dofs = V.dofmap()->map();
  DisjointSets here(num_owned + num_ghosts);
  for (std::size_t cell = 0; cell < dofs.extent(0); ++cell)
    for (std::size_t i = 1; i < dofs.extent(1); ++i)
      here.unite(dofs(cell, 0), dofs(cell, i));
  // A part of a rank is named by the global number of its first node, its root. The owner of a ghost node may have it
  // in another part: both belong to one body.
  std::vector<std::int64_t> name(num_owned + num_ghosts);
  std::vector<std::int32_t> roots(num_owned + num_ghosts);
  for (std::size_t i = 0; i < roots.size(); ++i)
    roots[i] = here.root(std::int32_t(i));
  map->local_to_global(roots, name);
  std::vector<std::int64_t> shared; // pairs: name here, ghost node; a rank's own parts with themselves
  for (std::size_t i = 0; i < roots.size(); ++i)
    if (roots[i] == std::int32_t(i))
      shared.insert(shared.end(), {name[i], name[i]});
  for (std::int32_t i = 0; i < num_ghosts; ++i)
    shared.insert(shared.end(), {name[num_owned + i], map->ghosts()[i]});
  const std::vector<std::int64_t> asked = common::gather(comm, shared);
  // Every rank answers for the nodes that it owns.
  const auto [low, high] = map->local_range();
  std::vector<std::int64_t> edges;
  for (std::size_t i = 0; i < asked.size(); i += 2)
    if (low <= asked[i + 1] && asked[i + 1] < high)
      edges.insert(edges.end(), {asked[i], name[asked[i + 1] - low]});
  edges = common::gather(comm, edges);
  std::vector<std::int64_t> names(edges);
  for (std::size_t i = 0; i < asked.size(); i += 2)
    names.push_back(asked[i]);
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  const auto place = [&](std::int64_t n) { return std::int32_t(std::ranges::lower_bound(names, n) - names.begin()); };
  DisjointSets parts(names.size());
  for (std::size_t i = 0; i < edges.size(); i += 2)
    parts.unite(place(edges[i]), place(edges[i + 1]));
  std::vector<std::int32_t> number(names.size());
  Bodies out;
  for (std::size_t i = 0; i < names.size(); ++i)
    number[i] = parts.root(std::int32_t(i)) == std::int32_t(i) ? out.count++ : number[parts.root(std::int32_t(i))];
  out.number.resize(roots.size());
  for (std::size_t i = 0; i < roots.size(); ++i)
    out.number[i] = number[place(name[i])];
  return out;
}

std::vector<std::int32_t> nodes_of_bodies(const dolfinx::fem::FunctionSpace<double>& V,
                                          std::span<const std::int32_t> nodes)
{
  const Bodies all = bodies(V);
  std::vector<std::int8_t> wanted(all.count, 0);
  for (std::int32_t node : nodes)
    wanted[all.number[node]] = 1;
  MPI_Allreduce(MPI_IN_PLACE, wanted.data(), all.count, MPI_INT8_T, MPI_MAX, V.mesh()->comm());
  std::vector<std::int32_t> out;
  for (std::size_t i = 0; i < all.number.size(); ++i)
    if (wanted[all.number[i]])
      out.push_back(std::int32_t(i));
  return out;
}

RigidBodyModes::RigidBodyModes(const dolfinx::fem::FunctionSpace<double>& V, std::span<const double> u,
                               bool axisymmetric)
    : _comm(V.mesh()->comm()), _gdim(V.mesh()->geometry().dim()), _axisymmetric(axisymmetric),
      _num_owned(V.dofmap()->index_map->size_local()), _bodies(bodies(V))
{
  const std::vector<double> rest = V.tabulate_dof_coordinates(false);
  _x.assign(u.begin(), u.end());
  for (std::size_t i = 0; i < _x.size(); ++i)
    _x[i] += rest[3 * (i / _gdim) + i % _gdim];
  const int count = _bodies.count;
  std::vector<double> sums(count * (_gdim + 1), 0.0);
  for (std::int32_t i = 0; i < _num_owned; ++i)
  {
    double* sum = sums.data() + _bodies.number[i] * (_gdim + 1);
    for (int c = 0; c < _gdim; ++c)
      sum[c] += _x[i * _gdim + c];
    sum[_gdim] += 1.0;
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), int(sums.size()), MPI_DOUBLE, MPI_SUM, _comm);
  _centres.resize(count * _gdim);
  for (int b = 0; b < count; ++b)
    for (int c = 0; c < _gdim; ++c)
      _centres[b * _gdim + c] = sums[b * (_gdim + 1) + c] / sums[b * (_gdim + 1) + _gdim];
  _size.assign(count, 0.0);
  for (std::int32_t i = 0; i < _num_owned; ++i)
  {
    const std::int32_t b = _bodies.number[i];
    double squares = 0.0;
    for (int c = 0; c < _gdim; ++c)
      squares += std::pow(_x[i * _gdim + c] - _centres[b * _gdim + c], 2);
    _size[b] = std::max(_size[b], std::sqrt(squares));
  }
  MPI_Allreduce(MPI_IN_PLACE, _size.data(), count, MPI_DOUBLE, MPI_MAX, _comm);
  static constexpr std::array<const char*, 3> axes{"x", "y", "z"};
  for (int a = axisymmetric ? 1 : 0; a < _gdim; ++a)
    _names.push_back(std::string("move along ") + axes[a]);
  for (int k = 0; k < (axisymmetric ? 0 : 2 * _gdim - 3); ++k)
  {
    const auto [a, b] = turned_axes(_gdim, k);
    _names.push_back(std::string("turn about ") + axes[3 - a - b]);
  }
}

std::array<double, 3> RigidBodyModes::displacement(std::int32_t body, int k, const double* x) const
{
  std::array<double, 3> out{};
  const int first = _axisymmetric ? 1 : 0, translations = _gdim - first;
  if (k < translations)
    out[first + k] = 1.0;
  else
  {
    const auto [a, b] = turned_axes(_gdim, k - translations);
    const double size = std::max(_size[body], 1e-300);
    out[a] = -(x[b] - _centres[body * _gdim + b]) / size;
    out[b] = (x[a] - _centres[body * _gdim + a]) / size;
  }
  return out;
}

void RigidBodyModes::add_work(std::int32_t body, const double* x, const double* vector, double factor,
                              std::span<double> row) const
{
  for (int k = 0; k < per_body(); ++k)
  {
    const std::array<double, 3> moved = displacement(body, k, x);
    double work = 0.0;
    for (int c = 0; c < _gdim; ++c)
      work += moved[c] * vector[c];
    row[body * per_body() + k] += factor * work;
  }
}

std::vector<double> RigidBodyModes::field(std::span<const double> mode) const
{
  std::vector<double> out(std::size_t(_num_owned) * _gdim, 0.0);
  for (std::int32_t i = 0; i < _num_owned; ++i)
    for (int k = 0; k < per_body(); ++k)
    {
      const std::int32_t b = _bodies.number[i];
      const std::array<double, 3> moved = displacement(b, k, _x.data() + std::size_t(i) * _gdim);
      for (int c = 0; c < _gdim; ++c)
        out[std::size_t(i) * _gdim + c] += mode[b * per_body() + k] * moved[c];
    }
  return out;
}
} // namespace dolfinx_impact::operators
