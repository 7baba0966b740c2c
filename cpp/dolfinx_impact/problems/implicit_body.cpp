// SPDX-License-Identifier: MIT
#include "implicit_body.h"
#include "../common/agree.h"
#include "../common/dolfinx_api.h"
#include "../integrators/newmark/MassRedistribution.h"
#include "../kernels/constants.h"
#include "../operators/CellValues.h"
#include "../operators/InternalForce.h"
#include "../operators/KernelTangent.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <dolfinx/la/Vector.h>
#include <functional>
#include <string_view>

namespace dolfinx_impact::problems
{
namespace
{
using operators::check;
using operators::Integral;
typedef dolfinx::fem::Function<double> Function;
typedef dolfinx::fem::FunctionSpace<double> Space;
using operators::Coefficients;

/// Stiffness-proportional damping by the damping kernels of elastic laws. Its derivative is that of the velocity in it;
/// where the law is nonlinear, that of the displacement is left out, which costs iterations and no accuracy.
class KernelDamping : public integrators::VelocityForce
{
public:
  KernelDamping(const std::shared_ptr<Function>& u, const std::shared_ptr<Function>& v,
                const std::vector<Integral>& forces, const std::vector<Integral>& tangents, double beta, bool linear)
      : _u(u), _v(v), _beta(beta), _linear(linear),
        _forces(u->function_space()->mesh(), u->function_space(), forces, Coefficients{{"u", u}, {"velocity", v}}),
        _tangent({u->function_space(), u->function_space()}, tangents,
                 linear ? Coefficients{} : Coefficients{{"u", u}}),
        _values(u->function_space()->dofmap()->index_map, u->function_space()->dofmap()->bs())
  {
  }

  std::vector<double> forces() override
  {
    _u->x()->scatter_fwd();
    _v->x()->scatter_fwd();
    _forces.apply(_values);
    const std::span<const double> values = common::array(_values);
    const auto& dofmap = *_u->function_space()->dofmap();
    return {values.begin(), values.begin() + dofmap.index_map->size_local() * dofmap.index_map_bs()};
  }
  std::vector<Mat> tangent(Vec factors) override
  {
    _tangent.assemble();
    check(MatScale(_tangent.matrix(), _beta), "a damping matrix is scaled");
    check(MatDiagonalScale(_tangent.matrix(), nullptr, factors), "a damping matrix is scaled");
    return {_tangent.matrix()};
  }
  bool linear() const override { return _linear; }

private:
  std::shared_ptr<Function> _u, _v;
  double _beta;
  bool _linear;
  operators::InternalForce _forces;
  operators::KernelTangent _tangent;
  dolfinx::la::Vector<double> _values;
};

/// Diagonal matrix of owned values. It is the caller's. Collective.
Mat diagonal_matrix(const Space& V, std::span<const double> values)
{
  Mat out = nullptr;
  PetscInt first = 0;
  check(MatCreateAIJ(V.mesh()->comm(), PetscInt(values.size()), PetscInt(values.size()), PETSC_DETERMINE,
                     PETSC_DETERMINE, 1, nullptr, 0, nullptr, &out),
        "a matrix is made");
  check(MatSetBlockSize(out, V.dofmap()->index_map_bs()), "a matrix is made");
  check(MatGetOwnershipRange(out, &first, nullptr), "a matrix is made");
  for (std::size_t i = 0; i < values.size(); ++i)
    check(MatSetValue(out, first + PetscInt(i), first + PetscInt(i), values[i], INSERT_VALUES), "a matrix is set");
  check(MatAssemblyBegin(out, MAT_FINAL_ASSEMBLY), "a matrix is assembled");
  check(MatAssemblyEnd(out, MAT_FINAL_ASSEMBLY), "a matrix is assembled");
  return out;
}

/// Replace the mass matrices M of cells at contact surfaces by T^T M T; see MassRedistribution. Collective.
void redistribute(Mat matrix, const Space& V, const std::vector<Integral>& masses,
                  const integrators::MassRedistribution& surface)
{
  const int bs = V.dofmap()->bs();
  std::vector<PetscInt> dofs;
  for (const Integral& mass : masses)
  {
    operators::CellValues values(*mass.kernel, V, {});
    const impact_tabulate tabulate = kernels::tabulate(*mass.kernel, 1);
    const std::size_t n = mass.kernel->shape[0];
    std::vector<std::int32_t> here;
    std::vector<std::int32_t> cells(mass.entities);
    std::ranges::sort(cells);
    std::ranges::set_intersection(cells, surface.cells(), std::back_inserter(here));
    for (std::int32_t cell : here)
    {
      std::vector<double> M(n * n, 0.0);
      values.gather(cell);
      tabulate(M.data(), values.w(), mass.constants.data(), values.nodes().data(), 0);
      std::vector<double> change = surface.matrix(cell, M);
      for (std::size_t i = 0; i < change.size(); ++i)
        change[i] -= M[i];
      dofs.clear();
      for (std::int32_t node : V.dofmap()->cell_dofs(cell))
        for (int c = 0; c < bs; ++c)
          dofs.push_back(bs * node + c);
      check(MatSetValuesLocal(matrix, PetscInt(n), dofs.data(), PetscInt(n), dofs.data(), change.data(), ADD_VALUES),
            "a mass matrix is changed");
    }
  }
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY), "a mass matrix is assembled");
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY), "a mass matrix is assembled");
}
} // namespace

ImplicitBody implicit_body(const std::shared_ptr<Function>& u, const std::shared_ptr<Function>& v,
                           const std::vector<DynamicMaterial>& materials, std::span<const std::int8_t> fixed,
                           const ImplicitBodyOptions& options, const dolfinx::mesh::MeshTags<std::int32_t>* tags)
{
  if (options.beta > 0.0 && !v)
    throw std::invalid_argument("stiffness-proportional damping reads the velocity: give its function");
  const auto V = u->function_space();
  const auto& dofmap = *V->dofmap();
  const int bs = dofmap.bs();
  const std::size_t owned = std::size_t(dofmap.index_map->size_local()) * bs;
  const KernelFinder kernels(*V);
  std::vector<Integral> masses, damping, tangents;
  dolfinx::la::Vector<double> total(dofmap.index_map, bs), moved(dofmap.index_map, bs);
  common::fill(total, 0.0);
  common::fill(moved, 0.0);
  std::vector<std::vector<std::int32_t>> cells;
  std::optional<integrators::MassRedistribution> surface;
  int any = !options.massless_facets.empty();
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, V->mesh()->comm());
  if (any)
    surface.emplace(V, options.massless_facets);
  const auto add = [&](const DynamicMaterial& material, const std::vector<std::int32_t>& of)
  {
    std::map<std::string, std::vector<double>> constants = material.law.constants;
    constants["density"] = {material.density};
    constants["beta"] = {options.beta};
    const auto append = [&](std::vector<Integral>& out, const std::string& name)
    {
      for (const impact_kernel* kernel : kernels.find(name, material.law.hypothesis))
        out.push_back({kernel, of, kernels::constants(*kernel, constants)});
    };
    append(masses, "mass");
    if (options.beta > 0.0)
    {
      append(damping, elastic_name(material.law) + ".damping");
      append(tangents, elastic_name(material.law) + ".tangent");
    }
    const std::vector<double> lumped =
        lumped_masses(kernels, *V, material, of, options.lumping.value_or(Lumping::automatic));
    const std::size_t width = of.empty() ? 0 : lumped.size() / of.size();
    for (std::size_t k = 0; k < of.size(); ++k)
    {
      const std::span<const double> one(lumped.data() + k * width, width);
      const auto sum = [&](dolfinx::la::Vector<double>& out, std::span<const double> values)
      {
        const auto nodes = dofmap.cell_dofs(of[k]);
        for (std::size_t i = 0; i < width; ++i)
          common::array(out)[bs * nodes[i / bs] + i % bs] += values[i];
      };
      sum(total, one);
      if (surface && options.lumping)
        sum(moved, std::ranges::binary_search(surface->cells(), of[k]) ? surface->lumped(of[k], one)
                                                                       : std::vector<double>(one.begin(), one.end()));
    }
  };
  common::agree(V->mesh()->comm(),
                [&]
                {
                  cells = cells_of(materials, *V->mesh()->topology(), tags);
                  for (std::size_t k = 0; k < materials.size(); ++k)
                    add(materials[k], cells[k]);
                });
  total.scatter_rev(std::plus<double>());
  moved.scatter_rev(std::plus<double>());

  ImplicitBody out;
  out.alpha = options.alpha;
  out.mass.assign(total.array().begin(), total.array().begin() + owned);
  std::vector<std::int8_t> massless(owned, 0);
  for (std::size_t i = 0; surface && i < owned; ++i)
    massless[i] = surface->massless()[i / bs] && !fixed[i];
  Mat matrix = nullptr;
  if (options.lumping)
    matrix = diagonal_matrix(*V, common::array(surface ? moved : total).subspan(0, owned));
  else
  {
    operators::KernelTangent assembled({V, V}, masses, {});
    assembled.assemble();
    check(MatDuplicate(assembled.matrix(), MAT_COPY_VALUES, &matrix), "a mass matrix is copied");
    if (surface)
      redistribute(matrix, *V, masses, *surface);
  }
  out.inertia = std::make_shared<integrators::Inertia>(matrix, std::move(massless));
  MatDestroy(&matrix);
  if (options.beta > 0.0)
  {
    const auto varies = [](const Integral& integral)
    {
      const impact_kernel& k = *integral.kernel;
      return std::any_of(k.coefficients, k.coefficients + k.num_coefficients,
                         [](const impact_coefficient& c) { return std::string_view(c.name) == "u"; });
    };
    out.damping =
        std::make_shared<KernelDamping>(u, v, damping, tangents, options.beta, std::ranges::none_of(tangents, varies));
  }
  std::vector<MaterialCells> laws;
  for (std::size_t k = 0; k < materials.size(); ++k)
    laws.push_back({materials[k].law, cells[k]});
  out.body = std::make_shared<KernelBody>(u, laws, KernelBody::Loads{});
  return out;
}
} // namespace dolfinx_impact::problems
