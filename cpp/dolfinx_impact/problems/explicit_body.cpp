// SPDX-License-Identifier: MIT
#include "explicit_body.h"
#include "../common/OnAllRanks.h"
#include "../common/agree.h"
#include "../kernels/KernelTable.h"
#include "../kernels/constants.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string_view>

namespace dolfinx_impact::problems
{
namespace
{
using operators::Integral;
typedef dolfinx::fem::Function<double> Function;
using operators::Coefficients;

std::string tangent_name(const KernelMaterial& law)
{
  return law.name.starts_with("j2.finite") ? "elastic_stiffness.finite" : elastic_name(law) + ".tangent";
}

bool reads(const impact_kernel& kernel, std::string_view name)
{
  return std::any_of(kernel.coefficients, kernel.coefficients + kernel.num_coefficients,
                     [&](const impact_coefficient& c) { return c.name == name; });
}

/// Forces of integrals: those of cells without ghost nodes in two halves, and the others.
integrators::FormForces split(const std::shared_ptr<const dolfinx::fem::FunctionSpace<double>>& V,
                              const std::vector<Integral>& integrals, const Coefficients& coefficients)
{
  const auto& dofmap = *V->dofmap();
  const std::int32_t owned = dofmap.index_map->size_local();
  std::vector<Integral> early, outer, late;
  std::string u, v;
  for (const Integral& integral : integrals)
  {
    Integral in{integral.kernel, {}, integral.constants}, out = in, rest = in;
    for (const std::int32_t cell : integral.entities)
      (std::ranges::any_of(dofmap.cell_dofs(cell), [&](std::int32_t node) { return node >= owned; }) ? out : in)
          .entities.push_back(cell);
    if (!out.entities.empty()) // else there is nothing to wait for
    {
      const auto half = in.entities.begin() + std::ptrdiff_t((in.entities.size() + 1) / 2);
      rest.entities.assign(half, in.entities.end());
      in.entities.erase(half, in.entities.end());
    }
    early.push_back(std::move(in));
    outer.push_back(std::move(out));
    late.push_back(std::move(rest));
    u = reads(*integral.kernel, "u") ? "u" : u;
    v = reads(*integral.kernel, "velocity") ? "velocity" : v;
  }
  const auto make = [&](const std::vector<Integral>& part)
  {
    auto force = std::make_shared<operators::InternalForce>(V->mesh(), V, part, coefficients);
    force->set_in_place(true);
    return force;
  };
  return {make(early), make(outer), make(late), u, v};
}

} // namespace

ExplicitBody explicit_body(const std::shared_ptr<Function>& u, const std::vector<DynamicMaterial>& materials,
                           const ExplicitBodyOptions& options, const dolfinx::mesh::MeshTags<std::int32_t>* tags)
{
  const auto V = u->function_space();
  const auto& topology = *V->mesh()->topology();
  const std::int32_t num_cells = topology.index_map(topology.dim())->size_local();
  const std::size_t width = std::size_t(V->dofmap()->bs()) * V->dofmap()->element_dof_layout().num_dofs();
  const KernelFinder kernels(*V);
  const auto velocity = std::make_shared<Function>(V);
  const Coefficients both{{"u", u}, {"velocity", velocity}};
  ExplicitBody body;
  body.damping = {options.alpha, options.beta, options.bulk_viscosity[0]};
  std::vector<Integral> forces, damping, viscosity;
  std::vector<operators::CellBounds::Part> stiffness;
  std::vector<Integral> tangents;
  std::vector<double> masses(std::size_t(num_cells) * width, 0.0);
  ExplicitBody::Elasticity elasticity{std::vector<double>(num_cells), std::vector<double>(num_cells)};
  bool known = true; // the elasticity
  bool linear = true;
  const std::size_t num_plastic =
      std::ranges::count_if(materials, [](const DynamicMaterial& m) { return is_plastic(m.law); });
  if (num_plastic > 0 && num_plastic < materials.size())
    throw std::invalid_argument("materials with and without internal variables: the elastic energy of the latter is "
                                "not known; give all of them internal variables, with a yield stress that is not met");
  const auto add = [&](const DynamicMaterial& material, const std::vector<std::int32_t>& cells)
  {
    const KernelMaterial& law = material.law;
    std::map<std::string, std::vector<double>> constants = law.constants;
    constants["density"] = {material.density};
    constants["beta"] = {options.beta};
    constants["linear"] = {options.bulk_viscosity[0]};
    constants["quadratic"] = {options.bulk_viscosity[1]};
    const auto append = [&](std::vector<Integral>& out, const std::string& name)
    {
      for (const impact_kernel* kernel : kernels.find(name, law.hypothesis))
        out.push_back({kernel, cells, kernels::constants(*kernel, constants)});
    };
    append(forces, law.name + ".force");
    if (options.beta > 0.0)
      append(damping, elastic_name(law) + ".damping");
    if (options.bulk_viscosity != std::array<double, 2>{})
      append(viscosity, elastic_name(law) + ".viscosity");
    const std::size_t first = tangents.size();
    append(tangents, tangent_name(law));
    for (std::size_t i = first; i < tangents.size(); ++i)
    {
      const Integral& tangent = tangents[i];
      const bool varies = reads(*tangent.kernel, "u");
      linear = linear && !varies;
      stiffness.push_back({tangent, varies ? Coefficients{{"u", u}} : Coefficients{}, varies});
    }
    const std::optional<double> modulus = uniaxial_modulus(law);
    known = known && modulus;
    for (const std::int32_t cell : cells)
    {
      elasticity.moduli[cell] = modulus.value_or(0.0);
      elasticity.wave_speeds[cell] = std::sqrt(modulus.value_or(0.0) / material.density);
    }
    const std::vector<double> m = lumped_masses(kernels, *V, material, cells, options.lumping);
    for (std::size_t k = 0; k < cells.size(); ++k)
      std::copy_n(m.begin() + std::ptrdiff_t(k * width), width,
                  masses.begin() + std::ptrdiff_t(std::size_t(cells[k]) * width));
  };
  common::agree(V->mesh()->comm(),
                [&]
                {
                  const auto cells = cells_of(materials, topology, tags);
                  for (std::size_t k = 0; k < materials.size(); ++k)
                    add(materials[k], cells[k]);
                });
  body.internal = split(V, forces, {{"u", u}});
  body.linear = linear && num_plastic == 0;
  if (!damping.empty())
    body.terms.push_back({split(V, damping, both), integrators::WorkKind::damping});
  if (!viscosity.empty())
    body.terms.push_back({split(V, viscosity, both), integrators::WorkKind::viscosity});
  body.frequencies = std::make_shared<integrators::CellFrequencies>(
      V, std::make_shared<operators::CellBounds>(V, std::move(stiffness)), nullptr,
      [m = std::move(masses)] { return m; });
  body.stiffness = [V, u, tangents = std::move(tangents)]
  {
    u->x()->scatter_fwd();
    auto out = std::make_shared<operators::KernelTangent>(std::array{V, V}, tangents, Coefficients{{"u", u}});
    out->assemble();
    return out;
  };
  if (known)
    body.elasticity = std::move(elasticity);
  if (options.mass_scaling)
    body.frequencies->scale_mass(*options.mass_scaling);
  body.mass = body.frequencies->nodal_masses();
  const std::int32_t owned = V->dofmap()->index_map->size_local() * V->dofmap()->index_map_bs();
  double smallest = std::numeric_limits<double>::infinity();
  for (std::int32_t i = 0; i < owned; ++i)
    smallest = std::min(smallest, body.mass[i]);
  MPI_Allreduce(MPI_IN_PLACE, &smallest, 1, MPI_DOUBLE, MPI_MIN, V->mesh()->comm());
  if (!(smallest > 0.0))
    throw common::BadValue("a node has no mass: use Lumping::hrz, and check that every cell has a volume");
  body.kind = {.watched = !linear, .flows = num_plastic > 0};
  return body;
}
} // namespace dolfinx_impact::problems
