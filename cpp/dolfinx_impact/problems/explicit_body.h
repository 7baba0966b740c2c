// SPDX-License-Identifier: MIT
#pragma once
#include "DynamicMaterial.h"
#include "ExplicitBody.h"
#include <dolfinx/mesh/MeshTags.h>
#include <optional>
#include <vector>

namespace dolfinx_impact::problems
{
struct ExplicitBodyOptions
{
  Lumping lumping = Lumping::automatic;
  double alpha = 0.0;                      ///< Rayleigh: factor of the mass [1/T]
  double beta = 0.0;                       ///< Rayleigh: factor of the stiffness [T]
  std::array<double, 2> bulk_viscosity{};  ///< linear and quadratic factor, for example 0.06 and 1.2 [1]
  std::optional<double> mass_scaling = {}; ///< step to which that of cells is raised by added mass [T]
};

/// Bodies of materials whose kernels are in the table (kernels::find). Collective.
/// @param[in] u displacement that the kernels read
/// @param[in] tags of cells, for materials that name theirs; null: there is one material
/// @throws std::runtime_error if there are no kernels for this mesh, degree and hypothesis
/// @throws std::invalid_argument if a constant is missing, materials with and without internal variables are mixed
/// @throws common::BadValue on all ranks for cells or nodes without mass
ExplicitBody explicit_body(const std::shared_ptr<dolfinx::fem::Function<double>>& u,
                           const std::vector<DynamicMaterial>& materials, const ExplicitBodyOptions& options = {},
                           const dolfinx::mesh::MeshTags<std::int32_t>* tags = nullptr);
} // namespace dolfinx_impact::problems
