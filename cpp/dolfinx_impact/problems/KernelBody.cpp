// SPDX-License-Identifier: MIT
#include "KernelBody.h"
#include "../common/dolfinx_api.h"
#include "../kernels/KernelTable.h"
#include "../kernels/constants.h"
#include <algorithm>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace dolfinx_impact::problems
{
namespace
{
/// Whether a kernel reads the displacement.
bool reads_displacement(const impact_kernel& kernel)
{
  for (int i = 0; i < kernel.num_coefficients; ++i)
    if (std::string_view(kernel.coefficients[i].name) == "u")
      return true;
  return false;
}

/// Integrals of one kind of kernel of a material.
std::vector<operators::Integral> integrals(const operators::FunctionSpace& V, const KernelMaterial& material,
                                           const std::string& kind, const std::vector<std::int32_t>& cells)
{
  const auto& mesh = *V.mesh();
  const kernels::Key key{material.name + kind, dolfinx::mesh::to_string(mesh.topology()->cell_type()),
                         V.element()->basix_element().degree(), common::coordinate_element(mesh).degree(),
                         material.hypothesis};
  std::vector<operators::Integral> out;
  for (const impact_kernel* kernel : kernels::find(key))
    out.push_back({kernel, cells, kernels::constants(*kernel, material.constants)});
  return out;
}

std::vector<std::int32_t> owned_cells(const operators::Mesh& mesh)
{
  std::vector<std::int32_t> cells(mesh.topology()->index_map(mesh.topology()->dim())->size_local());
  std::iota(cells.begin(), cells.end(), 0);
  return cells;
}
} // namespace

/// What a body is made of.
struct KernelBody::Made
{
  std::shared_ptr<dolfinx::fem::Function<double>> u;
  Form residual;
  std::shared_ptr<operators::KernelTangent> tangent;
  solve::BodyProperties properties;
  BodyKernels kernels;
};

KernelBody::Made KernelBody::make(std::shared_ptr<dolfinx::fem::Function<double>> u,
                                  const std::vector<MaterialCells>& materials, const Loads& loads)
{
  const auto V = u->function_space();
  const operators::Coefficients read{{"u", u}};
  std::vector<operators::Integral> forces, tangents;
  bool inelastic = false, linear = !loads.tangent;
  // First all forces: their operator makes the histories that the tangents read.
  std::vector<std::size_t> first;
  for (const MaterialCells& m : materials)
  {
    first.push_back(forces.size());
    for (operators::Integral& integral : integrals(*V, m.material, ".force", m.cells))
      forces.push_back(std::move(integral));
  }
  auto force = std::make_shared<operators::InternalForce>(V->mesh(), V, forces, read);
  for (std::size_t i = 0; i < materials.size(); ++i)
    for (operators::Integral& integral : integrals(*V, materials[i].material, ".tangent", materials[i].cells))
    {
      integral.history = force->history(first[i]); // laws have one integral
      inelastic = inelastic || integral.history;
      linear = linear && !reads_displacement(*integral.kernel);
      tangents.push_back(std::move(integral));
    }
  auto tangent = std::make_shared<operators::KernelTangent>(std::array{V, V}, tangents, read, loads.tangent);
  BodyKernels kernels{.forces = {{force}}};
  std::vector<operators::Integral> energies;
  kernels.energy_is_known = !loads.residual;
  for (std::size_t i = 0; i < materials.size() && kernels.energy_is_known; ++i)
    if (!force->history(first[i])) // others sum their elastic energy up with their force
      try
      {
        std::ranges::move(integrals(*V, materials[i].material, ".energy", materials[i].cells),
                          std::back_inserter(energies));
      }
      catch (const std::runtime_error&)
      {
        kernels.energy_is_known = false; // no such kernel
      }
  if (!energies.empty())
    kernels.energies = {{std::make_shared<operators::InternalForce>(V->mesh(), nullptr, energies, read)}};
  // Kinematic hardening with recovery and finite strain make tangents of plastic flow unsymmetric.
  const solve::BodyProperties properties{.linear = linear && !inelastic,
                                         .keeps_tangent = linear && !inelastic,
                                         .symmetric = !inelastic,
                                         .inelastic = inelastic,
                                         .has_springs = loads.has_springs,
                                         .rounds_positions = true};
  return {std::move(u), loads.residual, std::move(tangent), properties, std::move(kernels)};
}

KernelBody::KernelBody(Made made)
    : AssembledBody(std::move(made.u), std::move(made.residual), std::move(made.tangent), made.properties,
                    std::move(made.kernels))
{
}

KernelBody::KernelBody(std::shared_ptr<dolfinx::fem::Function<double>> u, const KernelMaterial& material)
    : KernelBody(make(u, {{material, owned_cells(*u->function_space()->mesh())}}, {}))
{
}

KernelBody::KernelBody(std::shared_ptr<dolfinx::fem::Function<double>> u, const std::vector<MaterialCells>& materials,
                       const Loads& loads)
    : KernelBody(make(std::move(u), materials, loads))
{
}
} // namespace dolfinx_impact::problems
