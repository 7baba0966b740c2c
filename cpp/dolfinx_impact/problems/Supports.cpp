// SPDX-License-Identifier: MIT
#include "Supports.h"
#include "../common/OnAllRanks.h"
#include "../common/agree.h"
#include "../common/gather.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dolfinx_impact::problems
{
namespace
{
/// Part of the largest displacement by which u may differ from a prescribed value at the start.
constexpr double start = 1e-12;
} // namespace

std::vector<std::int8_t> prescribed_dofs(const dolfinx::fem::FunctionSpace<double>& V,
                                         const std::vector<PrescribedMotion>& supports)
{
  const auto& map = *V.dofmap()->index_map;
  std::vector<std::int8_t> out((map.size_local() + map.num_ghosts()) * V.dofmap()->index_map_bs(), 0);
  for (const PrescribedMotion& support : supports)
    for (std::int32_t dof : support.bc->dof_indices().first)
      out[dof] = 1;
  return out;
}

Supports::Supports(const dolfinx::fem::Function<double>& u, std::vector<PrescribedMotion> motions,
                   FunctionsOfTime& functions)
    : _motions(std::move(motions)), _mask(u.x()->array().size(), 0), _present(_mask.size(), 0.0)
{
  const auto& dofmap = *u.function_space()->dofmap();
  const MPI_Comm comm = dofmap.index_map->comm();
  const std::int32_t num_owned = dofmap.index_map->size_local() * dofmap.index_map_bs();
  const std::span<const double> now = u.x()->array();
  for (const PrescribedMotion& motion : _motions)
  {
    Part part;
    std::vector<double> values(now.size(), 0.0);
    motion.bc->set(values, std::nullopt, 1.0);
    for (const std::int32_t dof : motion.bc->dof_indices().first)
      if (!_mask[dof])
      {
        _mask[dof] = 1;
        if (dof < num_owned)
          part.dofs.push_back(dof);
      }
    double factor = 1.0;
    if (motion.amplitude)
    {
      common::agree(comm, [&] { factor = motion.amplitude->at(0.0); });
      part.column = functions.add(*motion.amplitude);
    }
    double jump = 0.0, size = 0.0;
    for (const std::int32_t dof : part.dofs)
    {
      part.values.push_back(values[dof]);
      jump = std::max(jump, std::abs(factor * values[dof] - now[dof]));
      size = std::max(size, std::abs(factor * values[dof]));
    }
    for (const double value : now)
      size = std::max(size, std::abs(value));
    if (common::largest(comm, jump) > start * common::largest(comm, size))
      throw common::BadValue("a prescribed displacement jumps at the start: let u have its value, or use "
                             "PrescribedMotion with an amplitude that begins where u is");
    _parts.push_back(std::move(part));
  }
}

void Supports::check()
{
  for (std::size_t i = 0; i < _parts.size(); ++i)
  {
    _motions[i].bc->set(_present, std::nullopt, 1.0);
    for (std::size_t k = 0; k < _parts[i].dofs.size(); ++k)
      if (const double value = _present[_parts[i].dofs[k]];
          value != _parts[i].values[k] && !(std::isnan(value) && std::isnan(_parts[i].values[k])))
        throw std::invalid_argument(
            "the value of a Dirichlet condition was changed after the problem was made, which goes on with the old "
            "one: give PrescribedMotion(bc, amplitude), a function of time, before the problem is made");
  }
}
} // namespace dolfinx_impact::problems
