// SPDX-License-Identifier: MIT
#include "NodalFields.h"
#include <algorithm>

namespace dolfinx_impact::integrators
{
NodalFields::NodalFields(const std::shared_ptr<const dolfinx::common::IndexMap>& map, int bs)
    : bs(bs), owned(std::size_t(map->size_local()) * bs), own(owned + std::size_t(map->num_ghosts()) * bs),
      _space_map(map)
{
  resize(map);
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
  for (std::vector<double>* values : {&u, &v, &mass, &inverse})
    halo->forward(*values, bs);
}

void NodalFields::resize(const std::shared_ptr<const dolfinx::common::IndexMap>& map)
{
  if (halo)
    _traffic += halo->traffic();
  halo = std::make_unique<Halo>(map);
  const std::size_t size = std::size_t(halo->num_nodes()) * bs;
  for (std::vector<double>* values : {&u, &v, &r, &mass, &inverse})
    values->resize(size, 0.0);
  _old_ghosts.resize(size - owned);
}

void NodalFields::begin_exchange()
{
  halo->forward_begin(u, bs);
  exchanging = true;
}

void NodalFields::end_exchange(double dt)
{
  if (!exchanging)
    return;
  std::copy(u.begin() + owned, u.end(), _old_ghosts.begin());
  halo->forward_end(u, bs);
  update_ghost_velocities(dt);
  exchanging = false;
}

void NodalFields::update_ghost_velocities(double dt)
{
  for (std::size_t i = owned; i < u.size(); ++i)
    v[i] = (u[i] - _old_ghosts[i - owned]) / dt;
}

Halo::Traffic NodalFields::traffic() const
{
  Halo::Traffic out = _traffic;
  out += halo->traffic();
  return out;
}
} // namespace dolfinx_impact::integrators
