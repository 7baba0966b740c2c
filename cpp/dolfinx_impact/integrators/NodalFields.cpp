// SPDX-License-Identifier: MIT
#include "NodalFields.h"
#include <algorithm>

namespace dolfinx_impact::integrators
{
NodalFields::NodalFields(const std::shared_ptr<const dolfinx::common::IndexMap>& map, int bs, bool padded)
    : bs(bs), stride(padded ? operators::padded_stride(bs) : bs), owned(std::size_t(map->size_local()) * bs),
      own(owned + std::size_t(map->num_ghosts()) * bs), owned_entries(entry(owned)), own_entries(entry(own)),
      _space_map(map)
{
  resize(map);
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
  resize(std::make_shared<const dolfinx::common::IndexMap>(space.comm(), space.size_local(), nodes, owners));
  for (AlignedVector* values : {&u, &v, &mass, &inverse})
    halo->forward(*values, bs, stride);
}

void NodalFields::resize(const std::shared_ptr<const dolfinx::common::IndexMap>& map)
{
  if (halo)
    _traffic += halo->traffic();
  halo = std::make_unique<Halo>(map);
  const std::size_t size = std::size_t(halo->num_nodes()) * stride;
  for (AlignedVector* values : {&u, &v, &r, &mass, &inverse})
    values->resize(size, 0.0);
  _old_ghosts.resize(size - owned_entries);
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
