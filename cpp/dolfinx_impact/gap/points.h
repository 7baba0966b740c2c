// SPDX-License-Identifier: MIT
#pragma once
#include "../search/closest_point/SurfaceSearch.h"
#include "../search/general/GeneralSearch.h"
#include "Rigid.h"
#include <span>
#include <vector>

namespace dolfinx_impact::gap
{
/// Quadrature points of a slave surface with what is known about the gap there, in flat arrays: facet after facet, the
/// same rule on each.
struct Points
{
  int gdim = 3;
  int per_facet = 0;
  // Fixed by the rule and the reference configuration.
  std::vector<std::int32_t> facet; ///< of the slave
  std::vector<double> xi;          ///< xi[2*q + alpha]
  std::vector<double> weight;      ///< weight of the rule times dA_0, axisymmetric times 2 pi R [L; L^2]
  std::vector<double> margin;      ///< how far beside a facet that they keep, reference coordinates
  // Filled by `update`.
  std::vector<double> x;                        ///< x[q*gdim + c], current position [L]
  std::vector<search::ProjectionStatus> status; ///< `outside`: no master, open
  std::vector<std::int8_t> entity;              ///< edge or vertex of the master's facet
  std::vector<std::int8_t> beside;              ///< is it beside the master's outer rim?
  std::vector<std::int32_t> master;             ///< facet of the master; -1 without one and for rigid masters
  std::vector<double> master_xi;                ///< master_xi[2*q + alpha]
  std::vector<double> gap;                      ///< infinite without master [L]
  std::vector<double> normal;                   ///< normal[q*gdim + c], out of the master
  std::vector<double> hessian; ///< rigid masters: dn/dx, hessian[(q*gdim + a)*gdim + b]; else empty [1/L]

  std::size_t size() const { return facet.size(); }
};

/// @param[in] slave facets; X is used
/// @param[in] points,weights rule on the reference facet, tdim coordinates per point
/// @param[in] axisymmetric x is the radius: weights are for the full circumference
/// @returns points without master yet (gap infinite)
Points make_points(const surface::Facets& slave, std::span<const double> points, std::span<const double> weights,
                   bool axisymmetric);

/// Positions and gaps for a deformable master.
/// @param[in,out] points of make_points for this slave
/// @param[in] slave,master facets as they are now (SurfaceSearch::update called)
/// @param[in] reach search distance [L]
/// @param[in] keep points over a common edge stay on the facet they had (same master facets as in the last update)
void update(Points& points, const surface::Facets& slave, const search::SurfaceSearch& master, double reach, bool keep);

/// Positions and gaps for a surface that may touch itself.
/// @param[in] depth penetrations of the points in the last converged state, zero of open ones [L]
void update(Points& points, const surface::Facets& slave, const search::GeneralSearch& master, double reach, bool keep,
            std::span<const double> depth);

/// Positions and gaps for a rigid master.
void update(Points& points, const surface::Facets& slave, const Rigid& master);
} // namespace dolfinx_impact::gap
