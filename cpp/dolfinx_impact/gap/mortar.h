// SPDX-License-Identifier: MIT
#pragma once
#include "segments.h"

namespace dolfinx_impact::gap
{
/// Matrix entries of this rank; rows and columns number nodes as the facets do. Entries at the same place add up.
struct Entries
{
  std::vector<std::int32_t> rows, cols;
  std::vector<double> values;
  void add(std::int32_t i, std::int32_t j, double v)
  {
    rows.push_back(i);
    cols.push_back(j);
    values.push_back(v);
  }
};

/// Functions psi of the multipliers on a facet, one per node.
enum class Multipliers
{
  dual,     ///< biorthogonal to the shape functions over the covered part
  standard, ///< the shape functions
  linear    ///< hat functions of the corners, none at other nodes
};

/// Covered part of a facet below which it counts as not covered.
inline constexpr double least_cover = 1e-2;

/// Integrals of psi_i over the points of each slave facet: [facet*num_nodes + i] [L, L^2]. Zero on facets that count as
/// not covered. Multipliers live at nodes with enough of it (docs/contact.md).
/// @param[in] least part of a facet that must be covered
std::vector<double> cover(const surface::Facets& slave, const Segments& segments, Multipliers basis,
                          double least = least_cover);

/// Mortar integrals of this rank's slave facets, docs/contact.md.
struct Mortar
{
  std::vector<double> psi;   ///< multiplier functions at the points, times the weight: [point*num_nodes + i]
  Entries D, M;              ///< rows: nodes with a multiplier; columns: slave nodes, master nodes [L, L^2]
  std::vector<double> gamma; ///< integral of psi_i (x_s - x_m): [(facet*num_nodes + i)*gdim + c] [L^2, L^3]
};

/// @param[in] slave, master current positions; on points without master (whole_facets) there are neither M nor gamma
/// @param[in] carries by node: not zero where a multiplier lives. Functions of other nodes go in equal parts to those
/// nodes of the same facet that have one: psi then adds up to one wherever a facet has a multiplier at all.
/// @param[in] least part of a facet that must be covered
/// @throws std::runtime_error if the integrals of a facet are singular
Mortar mortar(const surface::Facets& slave, const surface::Facets& master, const Segments& segments, Multipliers basis,
              std::span<const std::int8_t> carries, double least = least_cover);

/// Mean of the facets' normals at the nodes, turned round so that they point out of the master: this rank's sum, not
/// normalised, for map nodes: [node*gdim + c].
/// @param[in] counts which facets count at which of their nodes, [facet*num_nodes + i]; empty: all
void add_normals(const surface::Facets& slave, std::span<double> normals, std::span<const std::int8_t> counts = {});

/// Derivative of minus the contact force by the sliding of points over master facets, at given tractions.
/// @param[in] z traction at slave nodes, [node*gdim + c] [F/L^2]
/// @returns entries whose rows and columns number degrees of freedom, gdim*node + component [F/L]
Entries sliding_tangent(const surface::Facets& slave, const surface::Facets& master, const Segments& segments,
                        const Mortar& mortar, std::span<const double> z);

/// Derivative of minus the contact force by the turning of nodal normals, at given pressures; and that of the gap.
/// @param[in] sums un-normalised sums of add_normals, complete, by node
/// @param[in] force pressure times D of each node: the force along the normal [F]
/// @returns entries (gdim*node + component, gdim*node + component) of the slave's own block, per force on node i:
/// d(force_i n_i)/du, negative
/// @param[in] counts as in add_normals
Entries turning_tangent(const surface::Facets& slave, std::span<const double> sums, std::span<const double> force,
                        std::span<const std::int8_t> counts = {});
} // namespace dolfinx_impact::gap
