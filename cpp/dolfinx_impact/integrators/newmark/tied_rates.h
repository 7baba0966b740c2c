// SPDX-License-Identifier: MIT
#pragma once
#include "../../enforcement/mortar/Tie.h"
#include "Inertia.h"
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Accelerations or velocities that ties allow, and the multipliers that make them so.
struct TiedRates
{
  std::vector<double> rates;                    ///< owned
  std::vector<std::vector<double>> multipliers; ///< of each tie, by direction: of accelerations [F/L^2]
};

/// Remove from accelerations or velocities what ties forbid: a + M^-1 C^T z with C of it zero, where C M^-1 C^T z = -C
/// a is solved by conjugate gradients; docs/tie.md. Collective.
/// @param[in] fixed mask of prescribed degrees of freedom
/// @param[in] rates owned values
/// @throws common::Failure if the iterations do not converge
TiedRates tied_rates(const Inertia& inertia, std::span<enforcement::Tie* const> ties,
                     std::span<const std::int8_t> fixed, std::span<const double> rates);
} // namespace dolfinx_impact::integrators
