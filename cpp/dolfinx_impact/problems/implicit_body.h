// SPDX-License-Identifier: MIT
#pragma once
#include "../integrators/newmark/Inertia.h"
#include "../integrators/newmark/VelocityForce.h"
#include "../solve/Body.h"
#include "BodyLoads.h"
#include "DynamicMaterial.h"
#include <memory>
#include <optional>
#include <vector>

namespace dolfinx_impact::problems
{
/// Bodies as implicit steps need them: residual and tangent, mass, damping.
struct ImplicitBody
{
  std::shared_ptr<solve::Body> body; ///< without inertia
  std::shared_ptr<const integrators::Inertia> inertia;
  std::vector<double> mass;                                      ///< lumped, per owned degree of freedom [M]
  double alpha = 0.0;                                            ///< factor of mass-proportional damping [1/T]
  std::shared_ptr<integrators::VelocityForce> damping = nullptr; ///< other damping; null: there is none
  BodyLoads loads = {};                                          ///< that the residual of `body` contains
};

struct ImplicitBodyOptions
{
  std::optional<Lumping> lumping = std::nullopt; ///< nothing: consistent mass
  double alpha = 0.0;                            ///< Rayleigh: factor of the mass [1/T]
  double beta = 0.0;                             ///< Rayleigh: factor of the stiffness [T]
  /// Facets of contact surfaces on this rank, whose nodes pass their mass on to the nodes behind them, so that they
  /// neither rattle nor take up kinetic energy at impact; see integrators::MassRedistribution.
  std::vector<std::int32_t> massless_facets = {};
};

/// Bodies of materials whose kernels are in the table (kernels::find). Collective.
/// @param[in] u displacement, the kernels' coefficient of this name
/// @param[in] v velocity, which damping reads; the one that the problem is given. Null: there is no damping by
/// stiffness
/// @param[in] fixed mask of prescribed degrees of freedom, owned and ghosts (prescribed_dofs)
/// @param[in] tags of cells, for materials that name theirs; null: there is one material
/// @throws std::runtime_error if there are no kernels for this mesh, degree and hypothesis
/// @throws std::invalid_argument on all ranks if a constant or a density is missing, or materials do not fit the cells
ImplicitBody implicit_body(const std::shared_ptr<dolfinx::fem::Function<double>>& u,
                           const std::shared_ptr<dolfinx::fem::Function<double>>& v,
                           const std::vector<DynamicMaterial>& materials, std::span<const std::int8_t> fixed,
                           const ImplicitBodyOptions& options = {},
                           const dolfinx::mesh::MeshTags<std::int32_t>* tags = nullptr);
} // namespace dolfinx_impact::problems
