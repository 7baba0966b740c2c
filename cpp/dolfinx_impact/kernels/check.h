// SPDX-License-Identifier: MIT
#pragma once
#include "Kernel.h"
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/mesh/Mesh.h>
#include <string>

/// DOLFINx 0.9 does not compare a compiled kernel's geometry with the mesh, and then gives wrong numbers without a
/// word. These checks refuse a mesh or a function space that is not the kernel's own.
namespace dolfinx_impact::kernels
{
/// @throws std::runtime_error if cell type, geometry degree, geometry variant or geometric dimension differ
void check_mesh(const impact_kernel& kernel, const dolfinx::mesh::Mesh<double>& mesh);

/// @param[in] what for the message: "test space", "coefficient u"
/// @throws std::runtime_error if element, degree or block size differ, or degrees of freedom need transformations
void check_space(const impact_kernel& kernel, const impact_element& element,
                 const dolfinx::fem::FunctionSpace<double>& V, const std::string& what);

/// @throws std::runtime_error if the kernel writes values at its points, which only operators::Batches has room for
void check_without_outputs(const impact_kernel& kernel);
} // namespace dolfinx_impact::kernels
