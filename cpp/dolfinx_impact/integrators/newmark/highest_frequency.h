// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <petscmat.h>
#include <span>

namespace dolfinx_impact::integrators
{
/// Highest angular frequency of K x = omega^2 M x, to a relative error of 1e-6: nobody steps closer to the limit of
/// Newmark's methods with beta < gamma/2. Collective.
/// @param[in] stiffness K, symmetric [F/L]
/// @param[in] mass M, symmetric [M]
/// @param[in] held mask of owned degrees of freedom that do not move: prescribed ones, and those without mass, which
/// follow the others without inertia
/// @returns angular frequency [1/T]
/// @throws common::Failure if the eigenvalue solver does not converge
double highest_frequency(Mat stiffness, Mat mass, std::span<const std::int8_t> held);
} // namespace dolfinx_impact::integrators
