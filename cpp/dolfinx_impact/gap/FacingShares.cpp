// SPDX-License-Identifier: MIT
#include "FacingShares.h"
#include "../common/dolfinx_api.h"
#include "facing.h"
#include <dolfinx/la/Vector.h>
#include <functional>
#include <stdexcept>

namespace dolfinx_impact::gap
{
FacingShares::FacingShares(const std::shared_ptr<const surface::FunctionSpace>& V, const surface::Facets& slave,
                           MultiplierNodes nodes, const SegmentRule& rule, Multipliers basis, bool axisymmetric)
    : _map(V->dofmap()->index_map), _nodes(std::move(nodes)),
      _integrals(cover(slave, whole_facets(slave, rule, axisymmetric), basis))
{
}

std::vector<double> FacingShares::evaluate(const surface::Facets& slave, const Rigid& obstacle)
{
  const int n = slave.displacement.num_nodes(), gdim = slave.gdim;
  if (slave.size() * n != _integrals.size())
    throw std::invalid_argument("the surface is another one");
  std::vector<double> cosines(slave.size());
  const auto centre = slave.geometry.centre();
  for (std::size_t f = 0; f < slave.size(); ++f)
  {
    const surface::FacetPoint p = surface::evaluate(slave, f, slave.x_of(f), centre.data());
    const RigidPoint there = gap::evaluate(obstacle, {p.x, std::size_t(gdim)});
    cosines[f] = 0.0;
    for (int c = 0; c < gdim; ++c)
      cosines[f] -= p.normal[c] * there.normal[c];
  }
  const std::vector<std::int8_t> counts = counting(_map, slave, cosines);
  dolfinx::la::Vector<double> sums(_map, 1);
  common::fill(sums, 0.0);
  for (std::size_t k = 0; k < _integrals.size(); ++k)
    if (counts[k])
      common::array(sums)[slave.nodes[k]] += _integrals[k];
  sums.scatter_rev(std::plus<double>());
  _aside = gap::aside(slave, counts);
  const std::vector<double> areas = _nodes.counted_area(_map, slave, counts);
  std::vector<double> out(_nodes.nodes.size());
  for (std::size_t i = 0; i < out.size(); ++i)
  {
    // A node at which no counted facet has a share keeps all of them: corners of quadratic triangles.
    const double share = sums.array()[_nodes.nodes[i]];
    out[i] = share > least_share * areas[i] ? share : _nodes.share[i];
  }
  return out;
}
} // namespace dolfinx_impact::gap
