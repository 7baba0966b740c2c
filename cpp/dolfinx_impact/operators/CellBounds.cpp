// SPDX-License-Identifier: MIT
#include "CellBounds.h"
#include "../common/OnAllRanks.h"
#include "../common/dolfinx_api.h"
#include "frequency.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/la/Vector.h>
#include <functional>
#include <stdexcept>
#include <string_view>

namespace dolfinx_impact::operators
{
namespace
{
std::string_view type_of(const Integral& integral)
{
  return integral.kernel->integral_type;
}

/// Hash of constants and masses, bit by bit.
std::size_t digest_of(std::span<const double> constants, std::span<const double> masses)
{
  const auto bytes = [](std::span<const double> a)
  { return std::hash<std::string_view>{}({reinterpret_cast<const char*>(a.data()), a.size_bytes()}); };
  return bytes(constants) * 31 + bytes(masses);
}
} // namespace

CellBounds::CellBounds(std::shared_ptr<const FunctionSpace> V, std::vector<Part> parts)
    : _space(std::move(V)), _parts(std::move(parts)), _kept(_parts.size())
{
}

void CellBounds::set_constants(std::size_t i, std::span<const double> c)
{
  std::vector<double>& constants = _parts.at(i).integral.constants;
  if (c.size() != constants.size())
    throw std::invalid_argument("an integral has another number of constants");
  std::ranges::copy(c, constants.begin());
}

bool CellBounds::joins_cells() const
{
  return std::ranges::any_of(_parts, [](const Part& part) { return type_of(part.integral) == "interior_facet"; });
}

std::vector<double> CellBounds::spectra(std::span<const double> masses, CellMask only, bool facets)
{
  const auto& topology = *_space->mesh()->topology();
  const auto map = topology.index_map(topology.dim());
  const int width = _space->dofmap()->bs() * int(_space->dofmap()->element_dof_layout().num_dofs());
  const bool joins = facets && joins_cells();
  // Facets of this rank may touch cells of other ranks.
  std::vector<double> all_masses;
  std::vector<std::int8_t> all_chosen;
  if (joins)
  {
    dolfinx::la::Vector<double> m(map, width);
    std::ranges::copy(masses, common::array(m).begin());
    m.scatter_fwd();
    all_masses.assign(m.array().begin(), m.array().end());
    masses = all_masses;
    if (only)
    {
      dolfinx::la::Vector<std::int8_t> chosen(map, 1);
      std::ranges::copy(*only, common::array(chosen).begin());
      chosen.scatter_fwd();
      all_chosen.assign(chosen.array().begin(), chosen.array().end());
      only = all_chosen;
    }
  }
  dolfinx::la::Vector<double> sums(map, 3);
  common::fill(sums, 0.0);
  const std::span<double> out = common::array(sums);
  const bool some_vary = std::ranges::any_of(_parts, [](const Part& part) { return part.varies; });
  int failed = 0;
  for (std::size_t p = 0; p < _parts.size(); ++p)
  {
    const Part& part = _parts[p];
    const auto type = type_of(part.integral);
    if (!facets && type != "cell")
      continue;
    const int sides = type == "interior_facet" ? 2 : 1, stride = type == "cell" ? 1 : 1 + sides;
    Integral chosen{part.integral.kernel, {}, part.integral.constants};
    std::vector<double> given;
    for (std::size_t e = 0; e < part.integral.entities.size(); e += stride)
    {
      const std::int32_t* entity = part.integral.entities.data() + e;
      if (only && std::none_of(entity, entity + sides, [&](std::int32_t cell) { return (*only)[cell]; }))
        continue;
      chosen.entities.insert(chosen.entities.end(), entity, entity + stride);
      for (int side = 0; side < sides; ++side)
      {
        const auto row = masses.subspan(std::size_t(entity[side]) * width, width);
        given.insert(given.end(), row.begin(), row.end());
      }
    }
    // Linear materials keep their stiffness: most cells of a model with a few that deform a lot.
    const bool keep = !only && some_vary && !part.varies;
    const std::size_t digest = keep ? digest_of(part.integral.constants, given) : 0;
    std::vector<double> found;
    if (keep && _kept[p].digest == digest && _kept[p].spectra.size() == 3 * chosen.entities.size() / stride)
      found = _kept[p].spectra;
    else
      try
      {
        found = cell_spectra(chosen, *_space, part.coefficients, given);
      }
      catch (const std::runtime_error&)
      {
        failed = 1;
        continue;
      }
    for (std::size_t e = 0; e < found.size() / 3; ++e)
      for (int side = 0; side < sides; ++side)
        for (int k = 0; k < 3; ++k)
          out[3 * std::size_t(chosen.entities[e * stride + side]) + k] += found[3 * e + k];
    if (keep)
      _kept[p] = {digest, std::move(found)};
  }
  if (joins)
    sums.scatter_rev(std::plus<double>());
  std::vector<double> result(out.begin(), out.begin() + 3 * std::size_t(map->size_local()));
  if (!std::ranges::all_of(result, [](double x) { return std::isfinite(x); }))
    failed = 1;
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, map->comm());
  if (failed)
    throw common::BadValue("the stiffness of a cell is not a number: check the material, the mesh and the state");
  return result;
}
} // namespace dolfinx_impact::operators
