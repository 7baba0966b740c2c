// SPDX-License-Identifier: MIT
#pragma once
#include "dolfinx_api.h"
#include <dolfinx/fem/utils.h>
#include <optional>

/// A part of the layer over DOLFINx's releases of its own, as few files need it and its header is long.

namespace dolfinx_impact::common
{
/// The space of functions on a mesh with an element of Basix. Collective.
/// @param shape of the values where each component has the element: {3} for vectors in space; empty for scalars, and
/// for elements that have a shape themselves.
template <std::floating_point T>
dolfinx::fem::FunctionSpace<T> create_functionspace(std::shared_ptr<dolfinx::mesh::Mesh<T>> mesh,
                                                    const basix::FiniteElement<T>& element,
                                                    const std::vector<std::size_t>& shape = {})
{
#if IMPACT_DOLFINX_0_10
  const std::optional blocked = shape.empty() ? std::nullopt : std::optional(shape);
  return dolfinx::fem::create_functionspace(mesh,
                                            std::make_shared<const dolfinx::fem::FiniteElement<T>>(element, blocked));
#else
  return dolfinx::fem::create_functionspace(mesh, element, shape);
#endif
}
} // namespace dolfinx_impact::common
