// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/points.h"
#include "../../surface/Surface.h"
#include "../../surface/quadrature.h"
#include <cstdint>
#include <petscmat.h>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Penalty from the nodal stiffness per area of the softer surface where its facets are smallest [F/L^3]. Penetrations
/// are then a tenth of the compression of the outermost cells, and the matrix is about as well conditioned as that of
/// elasticity. Collective.
/// @param[in] K tangent of the bodies, without rows of prescribed degrees of freedom being replaced [F/L]
/// @param[in] V displacement space
/// @param[in] slave, master this rank's facets, whose nodes are those of V; no master: it is rigid
/// @param[in] rule of the quadrature points of a facet
/// @param[in] axisymmetric x is the radius
double automatic_penalty(Mat K, const surface::FunctionSpace& V, const surface::Facets& slave,
                         const surface::Facets* master, const surface::QuadratureRule& rule, bool axisymmetric);

/// The same of each body for itself: what a contact between it and a stiffer one has [F/L^3]. Collective.
/// @param[in] facets this rank's facets of all bodies
/// @param[in] body of each facet
/// @param[in] num_bodies of all ranks
/// @returns infinite for bodies without facets
std::vector<double> automatic_penalties(Mat K, const surface::FunctionSpace& V, const surface::Facets& facets,
                                        std::span<const std::int32_t> body, int num_bodies,
                                        const surface::QuadratureRule& rule, bool axisymmetric);

/// Refuse a given penalty that is much larger than the stiffness of the bodies. Not collective.
/// @param[in] name of the pair, for the error
/// @throws std::invalid_argument
void check_penalty(const std::string& name, double given, double automatic);
} // namespace dolfinx_impact::enforcement
