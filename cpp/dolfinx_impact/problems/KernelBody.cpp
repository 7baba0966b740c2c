// SPDX-License-Identifier: MIT
#include "KernelBody.h"
#include "../kernels/KernelTable.h"
#include "../kernels/constants.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <dolfinx/la/petsc.h>
#include <numeric>
#include <string_view>

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
} // namespace

KernelBody::KernelBody(std::shared_ptr<dolfinx::fem::Function<double>> u, const KernelMaterial& material)
    : _u(std::move(u)), _values(_u->function_space()->dofmap()->index_map, _u->function_space()->dofmap()->bs())
{
  const auto V = _u->function_space();
  const auto mesh = V->mesh();
  const int tdim = mesh->topology()->dim();
  std::vector<std::int32_t> cells(mesh->topology()->index_map(tdim)->size_local());
  std::iota(cells.begin(), cells.end(), 0);
  const auto integrals = [&](const char* what)
  {
    std::vector<operators::Integral> out;
    const kernels::Key key{material.name + what, dolfinx::mesh::to_string(mesh->topology()->cell_type()),
                           V->element()->basix_element().degree(), mesh->geometry().cmap().degree(),
                           material.hypothesis};
    for (const impact_kernel* kernel : kernels::find(key))
      out.push_back({kernel, cells, kernels::constants(*kernel, material.constants)});
    return out;
  };
  const auto tangents = integrals(".tangent");
  _linear = std::ranges::none_of(tangents, [](const auto& t) { return reads_displacement(*t.kernel); });
  _force = std::make_unique<operators::InternalForce>(
      mesh, V, integrals(".force"), std::map<std::string, std::shared_ptr<const operators::Function>>{{"u", _u}});
  std::map<std::string, std::shared_ptr<const operators::Function>> read;
  if (!_linear)
    read["u"] = _u;
  _tangent = std::make_unique<operators::Tangent>(std::array{V, V}, tangents, read);
  _loads.assign(_values.array().size(), 0.0);
  _residual = dolfinx::la::petsc::create_vector_wrap(_values);
}

KernelBody::~KernelBody()
{
  VecDestroy(&_residual);
}

Vec KernelBody::residual()
{
  _u->x()->scatter_fwd();
  _force->apply(_values);
  operators::Entries values(_residual); // those of _values; PETSc is told that they change
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] -= _loads[i];
  return _residual;
}

Mat KernelBody::tangent()
{
  _u->x()->scatter_fwd();
  _tangent->assemble();
  return _tangent->matrix();
}
} // namespace dolfinx_impact::problems
