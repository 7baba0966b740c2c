// SPDX-License-Identifier: MIT
#include "SpinningBody.h"
#include "../common/dolfinx_api.h"
#include "../kernels/KernelTable.h"
#include "../kernels/constants.h"
#include "../operators/InternalForce.h"
#include <dolfinx/la/Vector.h>
#include <stdexcept>

namespace dolfinx_impact::problems
{
namespace
{
using operators::check;

/// Integrals of a form of a spin with a rate of one.
std::vector<operators::Integral> integrals(const std::string& name, const operators::FunctionSpace& V,
                                           const rolling::Motion& motion, const SpinningMaterial& material)
{
  const rolling::Spin* spin = motion.spin();
  if (!spin)
    throw std::invalid_argument("the motion of a SpinningBody is no Spin");
  const auto& mesh = *V.mesh();
  const std::size_t gdim = mesh.geometry().dim();
  std::vector<double> axis(spin->axis.begin(), spin->axis.end());
  if (gdim == 2)
    axis = {spin->axis[2]};
  const std::map<std::string, std::vector<double>> values{
      {"spin", axis}, {"centre", {spin->point.begin(), spin->point.begin() + gdim}}, {"density", {material.density}}};
  const kernels::Key key{name, dolfinx::mesh::to_string(mesh.topology()->cell_type()),
                         V.element()->basix_element().degree(), common::coordinate_element(mesh).degree(),
                         material.hypothesis};
  std::vector<operators::Integral> out;
  for (const impact_kernel* kernel : kernels::find(key))
    out.push_back({kernel, material.cells, kernels::constants(*kernel, values)});
  return out;
}
} // namespace

SpinningBody::SpinningBody(std::shared_ptr<dolfinx::fem::Function<double>> u, std::shared_ptr<solve::Body> body,
                           const rolling::Motion& spin, const SpinningMaterial& material)
    : LoadedBody(std::move(body), std::size_t(u->function_space()->dofmap()->index_map->size_local()) *
                                      u->function_space()->dofmap()->index_map_bs()),
      _u(std::move(u)), _rate(spin.rate)
{
  const auto V = _u->function_space();
  const operators::InternalForce load(V->mesh(), V, integrals("centrifugal_load", *V, spin, material), {});
  dolfinx::la::Vector<double> complete(V->dofmap()->index_map, V->dofmap()->index_map_bs());
  load.apply(complete);
  _load.assign(complete.array().begin(), complete.array().begin() + forces().size());
  _softening = std::make_unique<operators::KernelTangent>(
      std::array<std::shared_ptr<const operators::FunctionSpace>, 2>{V, V},
      integrals("ale_inertia", *V, spin, material), operators::Coefficients{});
  _softening->assemble();
  check(MatCreateVecs(_softening->matrix(), &_displacement, &_product), "vectors are made");
}

SpinningBody::~SpinningBody()
{
  MatDestroy(&_tangent);
  VecDestroy(&_displacement);
  VecDestroy(&_product);
}

Vec SpinningBody::residual()
{
  {
    operators::Entries to(_displacement);
    std::copy_n(_u->x()->array().begin(), to.size(), to.begin());
  }
  check(MatMult(_softening->matrix(), _displacement, _product), "a matrix is multiplied");
  operators::Entries product(_product);
  for (std::size_t i = 0; i < _load.size(); ++i)
    forces()[i] = square() * (_load[i] + product[i]);
  return LoadedBody::residual();
}

Mat SpinningBody::tangent()
{
  Mat K = LoadedBody::tangent();
  if (_tangent)
    check(MatCopy(K, _tangent, SAME_NONZERO_PATTERN), "a matrix is copied");
  else
    check(MatDuplicate(K, MAT_COPY_VALUES, &_tangent), "a matrix is copied");
  check(MatAXPY(_tangent, -square(), _softening->matrix(), UNKNOWN_NONZERO_PATTERN), "matrices are added");
  return _tangent;
}
} // namespace dolfinx_impact::problems
