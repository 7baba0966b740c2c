#pragma once
#include "segments.h"

namespace impact::gap
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

/// Mortar integrals of this rank's slave facets, docs/contact.md.
struct Mortar
{
  std::vector<double> psi;   ///< multiplier functions at the points, times the weight: [point*num_nodes + i]
  Entries D, M;              ///< slave x slave, slave x master nodes [L, L^2]
  std::vector<double> gamma; ///< integral of psi_i (x_s - x_m): [(facet*num_nodes + i)*gdim + c] [L^2, L^3]
  std::vector<double> share; ///< integral of phi_i over the whole facet: [facet*num_nodes + i] [L, L^2]
};

/// @param[in] slave, master current positions; the master may be empty (rigid)
/// @param[in] dual biorthogonal multipliers; else the shape functions themselves
/// @param[in] whole points on whole facets (whole_facets), for `share`
/// @throws std::runtime_error if the integrals of a facet are singular
Mortar mortar(const surface::Facets& slave, const surface::Facets& master, const Segments& segments, bool dual,
              const Segments& whole);

/// Mean of the facets' normals at the nodes, turned round so that they point out of the master: this rank's sum, not
/// normalised, for map nodes: [node*gdim + c].
void add_normals(const surface::Facets& slave, std::span<double> normals);

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
Entries turning_tangent(const surface::Facets& slave, std::span<const double> sums, std::span<const double> force);
} // namespace impact::gap
