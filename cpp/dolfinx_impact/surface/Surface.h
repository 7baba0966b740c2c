// SPDX-License-Identifier: MIT
#pragma once
#include "Facets.h"
#include <dolfinx/fem/FunctionSpace.h>
#include <memory>
#include <span>

namespace dolfinx_impact::surface
{
using FunctionSpace = dolfinx::fem::FunctionSpace<double>;

/// This rank's facets of a surface.
/// @param[in] V displacement space: Lagrange of degree 1 or 2, gdim components
/// @param[in] facets local indices of exterior facets; those whose cell another rank owns are left out
/// @returns facets whose nodes number the blocks of V's dofmap (owned, then ghosts), at rest (x = X)
/// @throws std::invalid_argument for another space or cells that are not supported, or a facet inside the body
Facets make_surface(const FunctionSpace& V, std::span<const std::int32_t> facets);
} // namespace dolfinx_impact::surface
