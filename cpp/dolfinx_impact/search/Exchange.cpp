// SPDX-License-Identifier: MIT
#include "Exchange.h"
#include "../common/dolfinx_api.h"
#include "facet_exchange.h"
#include <algorithm>
#include <functional>
#include <stdexcept>

namespace dolfinx_impact::search
{
namespace
{
using dolfinx::common::IndexMap;

void check(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets& master, double reach)
{
  const int gdim = V.mesh()->geometry().dim();
  if (slave.gdim != gdim || master.gdim != gdim || V.dofmap()->index_map_bs() != gdim)
    throw std::invalid_argument("slave, master and displacement space must have the dimension of the mesh");
  if (slave.displacement.degree != master.displacement.degree)
    throw std::invalid_argument("slave and master must be surfaces of one displacement space");
  if (!(reach >= 0.0))
    throw std::invalid_argument("the reach of a search is a distance: zero or more");
}
} // namespace

Exchange::Exchange(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets& master,
                   double reach)
    : _slave(slave)
{
  check(V, slave, master, reach);
  const IndexMap& nodes = *V.dofmap()->index_map;
  const FacetPackets own = pack(nodes, slave);
  FacetPackets candidates = send_to_overlapping(nodes.comm(), pack(nodes, master), slave, reach);

  // Ghosts: nodes of either side that other ranks own, by their global numbers.
  const auto range = nodes.local_range();
  std::vector<std::pair<std::int64_t, int>> found;
  for (const FacetPackets* side : {&own, static_cast<const FacetPackets*>(&candidates)})
    for (std::size_t i = 0; i < side->nodes.size(); ++i)
      if (side->nodes[i] < range[0] || side->nodes[i] >= range[1])
        found.emplace_back(side->nodes[i], side->owners[i]);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<std::int64_t> ghosts;
  std::vector<int> owners;
  for (const auto& [node, owner] : found)
  {
    ghosts.push_back(node);
    owners.push_back(owner);
  }
  const auto localise = [&](const std::vector<std::int64_t>& global, std::vector<std::int32_t>& local)
  {
    local.clear();
    for (std::int64_t node : global)
      if (node >= range[0] && node < range[1])
        local.push_back(std::int32_t(node - range[0]));
      else
      {
        const auto position = std::lower_bound(ghosts.begin(), ghosts.end(), node) - ghosts.begin();
        local.push_back(nodes.size_local() + std::int32_t(position));
      }
  };
  localise(own.nodes, _slave.nodes);
  _master = std::move(candidates.facets);
  localise(candidates.nodes, _master.nodes);
  auto map = std::make_shared<const IndexMap>(nodes.comm(), nodes.size_local(), ghosts, owners);
  _values = std::make_unique<dolfinx::la::Vector<double>>(map, _slave.gdim);
}

void Exchange::forward(std::span<const double> u, std::span<double> values) const
{
  const std::size_t owned = std::size_t(map()->size_local()) * _slave.gdim;
  if (u.size() < owned || values.size() != size())
    throw std::invalid_argument("forward takes a vector of the space and one of the nodal map's size");
  std::copy_n(u.begin(), owned, common::array(*_values).begin());
  _values->scatter_fwd();
  std::copy_n(_values->array().begin(), size(), values.begin());
}

void Exchange::reverse(std::span<const double> values, std::span<double> b) const
{
  const std::size_t owned = std::size_t(map()->size_local()) * _slave.gdim;
  if (b.size() < owned || values.size() != size())
    throw std::invalid_argument("reverse takes a vector of the nodal map's size and one of the space");
  std::copy_n(values.begin(), size(), common::array(*_values).begin());
  _values->scatter_rev(std::plus<double>());
  for (std::size_t i = 0; i < owned; ++i)
    b[i] += _values->array()[i];
}

void Exchange::move(std::span<const double> u)
{
  std::vector<double> values(size());
  forward(u, values);
  surface::move(_slave, values.data());
  surface::move(_master, values.data());
}
} // namespace dolfinx_impact::search
