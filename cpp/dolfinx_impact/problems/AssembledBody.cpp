// SPDX-License-Identifier: MIT
#include "AssembledBody.h"
#include "../common/dolfinx_api.h"
#include "../operators/petsc_check.h"
#include "../operators/petsc_communicators.h"
#include <algorithm>
#include <dolfinx/fem/assembler.h>
#include <dolfinx/la/petsc.h>
#include <functional>
#include <utility>

namespace dolfinx_impact::problems
{
AssembledBody::AssembledBody(std::shared_ptr<dolfinx::fem::Function<double>> u, Form residual,
                             std::shared_ptr<operators::KernelTangent> tangent, solve::BodyProperties properties,
                             BodyKernels kernels)
    : Body(properties), _u(std::move(u)), _form(std::move(residual)), _tangent(std::move(tangent)),
      _kernels(std::move(kernels)),
      _values(_u->function_space()->dofmap()->index_map, _u->function_space()->dofmap()->index_map_bs())
{
  operators::keep_petsc_communicators(*_u->function_space());
  // Rows of prescribed degrees of freedom are zeroed and filled again.
  operators::check(MatSetOption(_tangent->matrix(), MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE), "keeping a pattern");
  _loads.assign(_values.array().size(), 0.0);
  _residual = dolfinx::la::petsc::create_vector_wrap(_values);
}

AssembledBody::~AssembledBody()
{
  VecDestroy(&_residual);
}

void AssembledBody::update_ghosts()
{
  _u->x()->scatter_fwd();
  for (const auto& f : _kernels.functions)
    f->x()->scatter_fwd();
}

Vec AssembledBody::residual()
{
  update_ghosts();
  const operators::Entries values(_residual); // those of _values; PETSc is told that they change
  std::span<double> b = common::array(_values);
  std::ranges::copy(_loads, b.begin());
  std::fill(b.begin() + std::ptrdiff_t(values.size()), b.end(), 0.0); // ghosts
  for (const KernelForce& f : _kernels.loads)
    f.assemble(b);
  std::ranges::transform(b, b.begin(), std::negate<double>());
  for (const KernelForce& f : _kernels.forces)
    f.assemble(b);
  if (_form)
    dolfinx::fem::assemble_vector(b, *_form);
  _values.scatter_rev(std::plus<double>());
  return _residual;
}

Mat AssembledBody::tangent()
{
  update_ghosts();
  set_constants(*_tangent, _kernels.tangent_constants);
  _tangent->assemble();
  return _tangent->matrix();
}

std::string AssembledBody::fault()
{
  for (const KernelForce& f : _kernels.forces)
    if (std::string fault = f.force->fault(); !fault.empty())
      return fault;
  return "";
}

void AssembledBody::accept_step()
{
  for (const KernelForce& f : _kernels.forces)
    f.force->commit();
}

void AssembledBody::set_energies(std::vector<KernelForce> energies,
                                 const std::vector<std::shared_ptr<dolfinx::fem::Function<double>>>& functions)
{
  _kernels.functions.insert(_kernels.functions.end(), functions.begin(), functions.end());
  _kernels.energies = std::move(energies);
  _kernels.energy_is_known = true;
}

std::optional<double> AssembledBody::stored_energy()
{
  if (!_kernels.energy_is_known)
    return std::nullopt;
  update_ghosts();
  double sum = 0.0;
  for (const KernelForce& f : _kernels.forces)
    sum += f.force->sum("elastic");
  for (const KernelForce& f : _kernels.energies)
    sum += f.value();
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, _u->function_space()->mesh()->comm());
  return sum;
}

/// Internal variables of each integral that has some.
operators::Histories AssembledBody::histories() const
{
  operators::Histories out;
  for (const KernelForce& f : _kernels.forces)
    for (std::size_t i = 0; i < f.force->num_integrals(); ++i)
      if (const auto& history = f.force->history(i))
        out.push_back(history);
  return out;
}

state::State AssembledBody::state()
{
  state::State out("bodies");
  int number = 0;
  for (const auto& history : histories())
    out.add(history->state("history " + std::to_string(number++)));
  return out;
}

state::State AssembledBody::saved_state()
{
  const auto topology = _u->function_space()->mesh()->topology();
  return operators::saved_history(histories(), topology->index_map(topology->dim())->size_local());
}

void AssembledBody::resume(const state::State& saved)
{
  operators::resume_history(histories(), saved);
}
} // namespace dolfinx_impact::problems
