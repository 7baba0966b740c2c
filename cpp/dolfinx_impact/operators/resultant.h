// SPDX-License-Identifier: MIT
#pragma once
#include <array>
#include <cstdint>
#include <dolfinx/fem/FunctionSpace.h>
#include <span>

namespace dolfinx_impact::operators
{
/// Sum of nodal forces and of their moments about a point.
struct Resultant
{
  std::array<double, 3> force{};  ///< third component zero in the plane [F]
  std::array<double, 3> moment{}; ///< in the plane the third component alone [F L]
};

/// Resultant of the nodal forces on some degrees of freedom, of all ranks, at the deformed positions. Collective.
/// @param[in] V displacement space
/// @param[in] u displacements, owned entries [L]
/// @param[in] forces owned entries [F]
/// @param[in] dofs degrees of freedom that count; those that this rank does not own do not
/// @param[in] point that moments are about [L]
/// @throws std::invalid_argument for fewer values than this rank owns, or a degree of freedom that it does not know
Resultant resultant(const dolfinx::fem::FunctionSpace<double>& V, std::span<const double> u,
                    std::span<const double> forces, std::span<const std::int32_t> dofs,
                    const std::array<double, 3>& point);
} // namespace dolfinx_impact::operators
