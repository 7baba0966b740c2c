// SPDX-License-Identifier: MIT
#pragma once
#include "stable_step.h"
#include <petscmat.h>
#include <span>

/// The stable step of the assembled bodies, with a lumped mass; docs/explicit/stable_step.md, "eigenvalue".
namespace dolfinx_impact::integrators
{
/// Highest angular frequency of K x = omega^2 M x, to a relative error of 1e-8 of its square, by SLEPc's Krylov-Schur
/// method. Collective.
/// @param[in,out] stiffness K, symmetric; it is scaled by the mass [F/L]
/// @param[in] inverse_mass of owned degrees of freedom, zero where motion is prescribed [1/M]
/// @returns angular frequency [1/T]
/// @throws common::Failure if the eigenvalue solver does not converge
double highest_frequency(Mat stiffness, std::span<const double> inverse_mass);

/// Stable step with damping that differs between cells. Collective.
///
/// At the stable step dt the largest eigenvalue of dt^2/4 K + dt/2 C over the mass is one. Each iteration computes the
/// eigenvector of the largest eigenvalue at the present step, then the step at which this vector's Rayleigh quotient is
/// one. The stable step is the minimum over all vectors, so that the iterates decrease to it.
/// @param[in,out] stiffness K, symmetric; it is scaled by the mass [F/L]
/// @param[in,out] damping C, of which the symmetric part counts; it is scaled by the mass, too [F T/L]
/// @param[in] inverse_mass as above [1/M]
/// @param[in] uniform damping of all cells alike; bulk viscosity takes part in the step of a vector, not in the search
/// for it
/// @param[in] start step that the iteration starts from [T]
/// @returns stable step [T]
/// @throws common::Failure if the eigenvalue solver does not converge
double assembled_step(Mat stiffness, Mat damping, std::span<const double> inverse_mass, const UniformDamping& uniform,
                      double start);
} // namespace dolfinx_impact::integrators
