// SPDX-License-Identifier: MIT
#pragma once
#include "../surface/normals.h"
#include <span>
#include <vector>

namespace dolfinx_impact::gap
{
/// Quadrature points on the segments of mortar contact: where a slave facet faces a master facet (docs/contact.md).
/// Points of one slave facet follow each other; facets in their order.
struct Segments
{
  std::vector<std::int32_t> slave, master; ///< facets of each point
  std::vector<double> xi_slave, xi_master; ///< reference coordinates, [point*2 + alpha]
  std::vector<double> weight;              ///< reference area; times 2 pi R if axisymmetric [L, L^2]
  std::vector<double> direction;           ///< normal of the slave facet at its centre, [point*3 + c]
  std::vector<double> covered;             ///< per slave facet: covered part of its reference area, 0..1
};

/// A rule on the reference segment: interval (0, 1) in the plane, triangle in space.
struct SegmentRule
{
  std::span<const double> points;  ///< [point*tdim + alpha]
  std::span<const double> weights; ///< sum 1, or 1/2 on the triangle
};

/// Cut slave facets along the edges of the master facets they face.
/// @param[in] slave, master at their current positions
/// @param[in] pairs candidate master facets of slave facet f: pairs[offsets[f] ... offsets[f+1]-1]
/// @param[in] reach largest distance along the slave's normal [L]
/// @param[in] axisymmetric weights times 2 pi R, R the reference radius
Segments segment(const surface::Facets& slave, const surface::Facets& master, std::span<const std::int32_t> pairs,
                 std::span<const std::int32_t> offsets, const SegmentRule& rule, double reach, bool axisymmetric);

/// The same points on whole slave facets, without a master (-1): for rigid obstacles.
/// @param[in] rule on the reference facet
Segments whole_facets(const surface::Facets& slave, const SegmentRule& rule, bool axisymmetric);
} // namespace dolfinx_impact::gap
