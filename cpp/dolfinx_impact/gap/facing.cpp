// SPDX-License-Identifier: MIT
#include "facing.h"
#include "../common/dolfinx_api.h"
#include "../common/vectors.h"
#include <cmath>
#include <dolfinx/la/Vector.h>
#include <functional>
#include <stdexcept>

namespace dolfinx_impact::gap
{
using surface::FacetPoint;
using surface::Facets;

namespace
{
/// A facet faces the master within 45 degrees, and faces nothing beyond 60: the sides of a right-angled edge are told
/// apart while a body is turned by less than 30 degrees; turned by more, both count.
constexpr double front = 0.70710678118654752, sideways = 0.5;
/// Facets that meet at more than 30 degrees form a sharp edge, as for smooth surfaces.
constexpr double crease = 0.86602540378443865;

FacetPoint at_centre(const Facets& facets, std::size_t f)
{
  return surface::evaluate(facets, f, facets.x_of(f), facets.geometry.centre().data());
}
} // namespace

std::vector<double> facing(const Facets& slave, const Facets& master, const Segments& segments)
{
  std::vector<double> sums(slave.size(), 0.0), weights(slave.size(), 0.0);
  std::vector<double> cosines(slave.size(), no_master);
  double cosine = 0.0;
  for (std::size_t q = 0; q < segments.weight.size(); ++q)
  {
    const std::int32_t s = segments.slave[q], m = segments.master[q];
    if (q == 0 || s != segments.slave[q - 1] || m != segments.master[q - 1])
      cosine = -dolfinx_impact::dot(at_centre(slave, s).normal, at_centre(master, m).normal, slave.gdim);
    sums[s] += segments.weight[q] * cosine;
    weights[s] += segments.weight[q];
  }
  for (std::size_t f = 0; f < slave.size(); ++f)
    if (weights[f] > 0.0)
      cosines[f] = sums[f] / weights[f];
  return cosines;
}

std::vector<std::int8_t> counting(const std::shared_ptr<const dolfinx::common::IndexMap>& map, const Facets& slave,
                                  std::span<const double> cosines)
{
  if (cosines.size() != slave.size())
    throw std::invalid_argument("a cosine of every facet is needed");
  const int n = slave.displacement.num_nodes(), gdim = slave.gdim;
  // Sums of the normals of facets that face the master, by node.
  dolfinx::la::Vector<double> sums(map, gdim);
  common::fill(sums, 0.0);
  for (std::size_t f = 0; f < slave.size(); ++f)
  {
    if (cosines[f] < front)
      continue;
    const FacetPoint p = at_centre(slave, f);
    for (int i = 0; i < n; ++i)
      for (int c = 0; c < gdim; ++c)
        common::array(sums)[std::size_t(slave.nodes_of(f)[i]) * gdim + c] += p.normal[c];
  }
  sums.scatter_rev(std::plus<double>());
  sums.scatter_fwd();
  std::vector<std::int8_t> out(slave.size() * n, 1);
  for (std::size_t f = 0; f < slave.size(); ++f)
  {
    if (cosines[f] > sideways)
      continue;
    const FacetPoint p = at_centre(slave, f);
    for (int i = 0; i < n; ++i)
    {
      const double* sum = &sums.array()[std::size_t(slave.nodes_of(f)[i]) * gdim];
      const double length = std::sqrt(dolfinx_impact::dot(sum, sum, gdim));
      out[f * n + i] = !(length > 0.0 && dolfinx_impact::dot(sum, p.normal, gdim) < crease * length);
    }
  }
  return out;
}
} // namespace dolfinx_impact::gap
