// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/owned.h"
#include "../solve/EquilibriumProblem.h"

namespace dolfinx_impact::rolling
{
/// Tangent of bodies and contacts by penalty at the present state, with ones in the rows of supports and without what
/// contacts by multipliers hold [F/L]. Collective.
operators::OwnedMatrix held_tangent(const solve::EquilibriumProblem& problem);

/// Whether a steady state is beyond its critical speed: number of negative eigenvalues of the tangent, stiffness minus
/// W, by the inertia of its factors (Sylvester's law). Collective.
int negative_directions(const solve::EquilibriumProblem& problem);

/// Factor on all rates at which stiffness minus W becomes singular; the stiffness stays as it is. The smallest f with
/// (K - f^2 W) x = 0: 1/f^2 is the largest eigenvalue of W x = (1/f^2) K x. Collective.
/// @param[in] problem whose bodies include W, held against rigid motion
/// @param[in] W at the present rates, zero at supports [F/L]
/// @returns the factor, infinite without a flow [1]
/// @throws common::Failure if the eigensolver found none
double critical_factor(const solve::EquilibriumProblem& problem, Mat W);
} // namespace dolfinx_impact::rolling
