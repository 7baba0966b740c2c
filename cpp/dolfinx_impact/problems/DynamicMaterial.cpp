// SPDX-License-Identifier: MIT
#include "DynamicMaterial.h"
#include "../common/dolfinx_api.h"
#include "../operators/lump.h"
#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>

namespace dolfinx_impact::problems
{
KernelFinder::KernelFinder(const dolfinx::fem::FunctionSpace<double>& V)
    : _key{"", dolfinx::mesh::to_string(V.mesh()->topology()->cell_type()), V.element()->basix_element().degree(),
           common::coordinate_element(*V.mesh()).degree()}
{
}

std::vector<const impact_kernel*> KernelFinder::find(const std::string& name, const std::string& hypothesis) const
{
  kernels::Key key = _key;
  key.name = name;
  key.hypothesis = hypothesis;
  return kernels::find(key);
}

const impact_kernel& KernelFinder::one(const std::string& name, const std::string& hypothesis) const
{
  const auto found = find(name, hypothesis);
  if (found.size() != 1)
    throw std::runtime_error("there are " + std::to_string(found.size()) + " kernels " + name + ", one is needed");
  return *found[0];
}

bool is_plastic(const KernelMaterial& law)
{
  return law.name.starts_with("j2.");
}

std::string elastic_name(const KernelMaterial& law)
{
  return is_plastic(law) ? "linear_elastic" : law.name;
}

std::optional<double> uniaxial_modulus(const KernelMaterial& law)
{
  constexpr std::array<std::string_view, 3> hookean{"linear_elastic", "st_venant_kirchhoff", "neo_hookean"};
  if (std::ranges::find(hookean, elastic_name(law)) == hookean.end())
    return {};
  const double E = law.constants.at("E").at(0), nu = law.constants.at("nu").at(0);
  const double lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), mu = E / (2.0 * (1.0 + nu));
  return (law.hypothesis == "plane_stress" ? 2.0 * lambda * mu / (lambda + 2.0 * mu) : lambda) + 2.0 * mu;
}

std::vector<std::vector<std::int32_t>> cells_of(const std::vector<DynamicMaterial>& materials,
                                                const dolfinx::mesh::Topology& topology,
                                                const dolfinx::mesh::MeshTags<std::int32_t>* tags)
{
  const std::int32_t num_cells = topology.index_map(topology.dim())->size_local();
  std::vector<std::int8_t> seen(num_cells, 0);
  std::vector<std::vector<std::int32_t>> out;
  for (const DynamicMaterial& material : materials)
  {
    if (!(material.density > 0.0))
      throw std::invalid_argument("the density of " + material.law.name + " must be positive");
    if (material.tag && !tags)
      throw std::invalid_argument("a material has a tag, but no tags of cells were given");
    std::vector<std::int32_t>& cells = out.emplace_back();
    for (std::int32_t cell = 0; !material.tag && cell < num_cells; ++cell)
      cells.push_back(cell);
    for (std::size_t k = 0; material.tag && k < tags->indices().size(); ++k)
      if (tags->values()[k] == *material.tag && tags->indices()[k] < num_cells)
        cells.push_back(tags->indices()[k]);
    for (std::int32_t cell : cells)
    {
      if (seen[cell])
        throw std::invalid_argument("a cell has two materials");
      seen[cell] = 1;
    }
  }
  if (std::ranges::any_of(seen, [](std::int8_t one) { return !one; }))
    throw std::invalid_argument("a cell has no material");
  return out;
}

std::vector<double> lumped_masses(const KernelFinder& kernels, const dolfinx::fem::FunctionSpace<double>& V,
                                  const DynamicMaterial& material, const std::vector<std::int32_t>& cells,
                                  Lumping lumping)
{
  const std::string& hypothesis = material.law.hypothesis;
  if (lumping == Lumping::automatic)
    lumping = kernels.degree() == 1                                 ? Lumping::row_sum
              : kernels.simplices() || hypothesis == "axisymmetric" ? Lumping::hrz
                                                                    : Lumping::nodal;
  const auto integral = [&](const char* name)
  { return operators::Integral{&kernels.one(name, hypothesis), cells, {material.density}}; };
  if (lumping == Lumping::hrz)
    return operators::cell_masses_hrz(integral("mass"), V);
  return operators::cell_masses_nodal(integral(lumping == Lumping::nodal ? "nodal_mass" : "row_sum"),
                                      integral("row_sum"), V);
}
} // namespace dolfinx_impact::problems
