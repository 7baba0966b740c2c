// SPDX-License-Identifier: MIT
#include "NodalFields.h"
#include <algorithm>
#include <utility>

namespace dolfinx_impact::integrators
{
namespace
{
bool on_any_rank(MPI_Comm comm, bool here)
{
  int mine = here, all = 0;
  dolfinx::MPI::check_error(comm, MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_MAX, comm));
  return all != 0;
}
} // namespace

NodalFields::NodalFields(const std::shared_ptr<const dolfinx::common::IndexMap>& map, int bs, bool padded,
                         std::vector<std::int8_t> used)
    : bs(bs), stride(padded ? operators::padded_stride(bs) : bs), owned(std::size_t(map->size_local()) * bs),
      own(owned + std::size_t(map->num_ghosts()) * bs), owned_entries(entry(owned)), own_entries(entry(own)),
      _space_map(map), _used(std::move(used))
{
  if (_used.empty())
    _used.assign(map->num_ghosts(), 1);
  set_halo(std::make_unique<Halo>(map, _used));
  _some_unused = on_any_rank(map->comm(), std::ranges::count(_used, 0) > 0);
}

void NodalFields::use(std::span<const std::int32_t> nodes)
{
  bool more = false;
  const std::int32_t num_owned = _space_map->size_local();
  for (const std::int32_t node : nodes)
    if (node >= num_owned && !std::exchange(_used.at(node - num_owned), std::int8_t(1)))
      more = true;
  if (!on_any_rank(_space_map->comm(), more))
    return;
  set_halo(std::make_unique<Halo>(_space_map, _used));
  _some_unused = on_any_rank(_space_map->comm(), std::ranges::count(_used, 0) > 0);
  refresh_ghosts();
}

void NodalFields::spread(std::span<const double> by_dof, AlignedVector& values) const
{
  if (!is_padded())
  {
    std::ranges::copy(by_dof, values.begin());
    return;
  }
  double* to = values.data();
  for (std::size_t i = 0; i < by_dof.size(); i += 3, to += 4)
    std::copy_n(by_dof.data() + i, 3, to);
}

void NodalFields::collect(std::span<const double> values, std::span<double> by_dof) const
{
  if (!is_padded())
  {
    std::copy_n(values.begin(), by_dof.size(), by_dof.begin());
    return;
  }
  const double* from = values.data();
  for (std::size_t i = 0; i < by_dof.size(); i += 3, from += 4)
    std::copy_n(from, 3, by_dof.data() + i);
}

std::vector<double> NodalFields::owned_values(const AlignedVector& values) const
{
  std::vector<double> out(owned);
  collect(values, out);
  return out;
}

void NodalFields::add_ghosts(const std::vector<std::pair<std::int64_t, int>>& others)
{
  const auto& space = *_space_map;
  std::vector<std::int64_t> nodes(space.ghosts().begin(), space.ghosts().end());
  std::vector<int> owners(space.owners().begin(), space.owners().end());
  for (const auto& [node, owner] : others)
  {
    nodes.push_back(node);
    owners.push_back(owner);
  }
  set_halo(std::make_unique<Halo>(
      std::make_shared<const dolfinx::common::IndexMap>(space.comm(), space.size_local(), nodes, owners)));
  refresh_ghosts();
}

void NodalFields::drop_ghosts(std::span<const std::int32_t> nodes)
{
  if (!_some_unused)
    return;
  std::vector<std::int8_t> used = _used;
  used.resize(halo->map().num_ghosts(), 1); // others are there because contacts need them
  for (const std::int32_t node : nodes)
    if (node >= halo->num_owned())
      used.at(node - halo->num_owned()) = 1;
  const auto map = halo->shared_map();
  set_halo(std::make_unique<Halo>(map, used));
}

void NodalFields::set_halo(std::unique_ptr<Halo> other)
{
  if (halo)
    _traffic += halo->traffic();
  halo = std::move(other);
  const std::size_t size = std::size_t(halo->num_nodes()) * stride;
  for (AlignedVector* values : {&u, &v, &r, &mass, &inverse})
    values->resize(size, 0.0);
  _old_ghosts.resize(size - owned_entries);
}

void NodalFields::refresh_ghosts()
{
  for (AlignedVector* values : {&u, &v, &mass, &inverse})
    halo->forward(*values, bs, stride);
}

void NodalFields::begin_exchange()
{
  halo->forward_begin(u, bs, stride);
  exchanging = true;
}

void NodalFields::end_exchange(double dt)
{
  if (!exchanging)
    return;
  std::copy(u.begin() + owned_entries, u.end(), _old_ghosts.begin());
  halo->forward_end(u, bs, stride);
  update_ghost_velocities(dt);
  exchanging = false;
}

void NodalFields::update_ghost_velocities(double dt)
{
  for (std::size_t i = owned_entries; i < u.size(); ++i)
    v[i] = (u[i] - _old_ghosts[i - owned_entries]) / dt;
}

Halo::Traffic NodalFields::traffic() const
{
  Halo::Traffic out = _traffic;
  out += halo->traffic();
  return out;
}
} // namespace dolfinx_impact::integrators
