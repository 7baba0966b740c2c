// SPDX-License-Identifier: MIT
#include "check.h"
#include "../common/dolfinx_api.h"
#include <basix/finite-element.h>
#include <dolfinx/fem/DofMap.h>
#include <dolfinx/fem/FiniteElement.h>
#include <dolfinx/mesh/cell_types.h>
#include <stdexcept>

namespace dolfinx_impact::kernels
{
namespace
{
[[noreturn]] void refuse(const impact_kernel& kernel, const std::string& what, const std::string& own,
                         const std::string& found)
{
  throw std::runtime_error(std::string("kernel ") + kernel.name + " was compiled for " + what + " " + own +
                           ", but found " + found +
                           ": compile the form for this mesh, or use the kernel on a mesh of its own kind");
}
} // namespace

void check_mesh(const impact_kernel& kernel, const dolfinx::mesh::Mesh<double>& mesh)
{
  const auto& cmap = common::coordinate_element(mesh);
  const std::string cell = dolfinx::mesh::to_string(cmap.cell_shape());
  if (cell != kernel.cell)
    refuse(kernel, "cell type", kernel.cell, cell);
  if (cmap.degree() != kernel.geometry_degree)
    refuse(kernel, "geometry degree", std::to_string(kernel.geometry_degree), std::to_string(cmap.degree()));
  if (mesh.geometry().dim() != kernel.gdim)
    refuse(kernel, "geometric dimension", std::to_string(kernel.gdim), std::to_string(mesh.geometry().dim()));
  // Variants place nodes differently from degree 3 on only.
  if (kernel.geometry_degree > 2 && static_cast<int>(cmap.variant()) != kernel.geometry_variant)
    refuse(kernel, "geometry variant", std::to_string(kernel.geometry_variant),
           std::to_string(static_cast<int>(cmap.variant())));
}

void check_space(const impact_kernel& kernel, const impact_element& element,
                 const dolfinx::fem::FunctionSpace<double>& V, const std::string& what)
{
  const auto& e = *V.element();
  if (e.block_size() != element.block_size)
    refuse(kernel, what + " with block size", std::to_string(element.block_size), std::to_string(e.block_size()));
  if (e.space_dimension() != element.num_dofs)
    refuse(kernel, what + " with degrees of freedom per cell", std::to_string(element.num_dofs),
           std::to_string(e.space_dimension()));
  if (element.hash != 0 && e.basix_element().hash() != element.hash)
    refuse(kernel, what + " on", element.description,
           "degree " + std::to_string(e.basix_element().degree()) + " element of family " +
               std::to_string(static_cast<int>(e.basix_element().family())));
  if (e.needs_dof_transformations())
    throw std::runtime_error(
        std::string("kernel ") + kernel.name + ": the " + what +
        " needs transformations of its degrees of freedom; only Lagrange-type spaces are supported");
}

void check_without_outputs(const impact_kernel& kernel)
{
  if (kernel.num_outputs > 0 || kernel.num_sums > 0 || kernel.local_unknowns > 0)
    throw std::runtime_error(std::string("kernel ") + kernel.name +
                             " has internal variables at its points: only InternalForce keeps them; use an elastic law "
                             "for masses, frequencies and matrices of kernels");
}
} // namespace dolfinx_impact::kernels
