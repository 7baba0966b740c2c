// SPDX-License-Identifier: MIT
#include "Tangent.h"
#include "../kernels/check.h"
#include "CellMatrix.h"
#include <algorithm>
#include <dolfinx/fem/assembler.h>
#include <dolfinx/fem/petsc.h>
#include <dolfinx/la/petsc.h>
#include <stdexcept>

namespace dolfinx_impact::operators
{
namespace
{
using dolfinx::fem::IntegralType;
typedef dolfinx::fem::integral_data<double, double> IntegralData;
} // namespace

dolfinx::fem::Form<double> create_form(const std::array<std::shared_ptr<const FunctionSpace>, 2>& V,
                                       const std::vector<Integral>& integrals,
                                       const std::map<std::string, std::shared_ptr<const Function>>& coefficients)
{
  std::map<IntegralType, std::vector<IntegralData>> data;
  std::vector<std::shared_ptr<const Function>> functions;
  std::vector<std::string> names;
  int id = 0;
  for (const Integral& integral : integrals)
  {
    const impact_kernel& k = *integral.kernel;
    if (std::string(k.integral_type) == "interior_facet")
      throw std::invalid_argument(std::string("kernel ") + k.name +
                                  " is of interior facets: their matrices are assembled by DOLFINx's own kernels");
    kernels::check_mesh(k, *V[0]->mesh());
    kernels::check_without_outputs(k);
    const auto matrix = std::make_shared<CellMatrix>(k);
    for (int a = 0; a < k.rank; ++a)
      kernels::check_space(k, k.arguments[a], *V[a], a ? "trial space" : "test space");
    if (int(integral.constants.size()) != k.size_c)
      throw std::invalid_argument(std::string("kernel ") + k.name + " takes " + std::to_string(k.size_c) +
                                  " constants");
    // The form packs its coefficients one after the other; a kernel finds its own in that order only if they are the
    // first.
    std::vector<int> active;
    for (int c = 0; c < k.num_coefficients; ++c)
    {
      const std::string name = k.coefficients[c].name;
      auto f = coefficients.find(name);
      if (f == coefficients.end() || !f->second)
        throw std::invalid_argument(std::string("kernel ") + k.name + " needs a coefficient named '" + name + "'");
      kernels::check_space(k, k.coefficients[c].element, *f->second->function_space(), "coefficient " + name);
      auto known = std::find(names.begin(), names.end(), name);
      if (known - names.begin() != c)
        throw std::invalid_argument("the integrals of one form must use the same coefficients in the same order");
      if (known == names.end())
      {
        names.push_back(name);
        functions.push_back(f->second);
      }
      active.push_back(c);
    }
    const bool facets = std::string(k.integral_type) == "exterior_facet";
    auto kernel = [matrix, constants = integral.constants,
                   facets](double* A, const double* w, const double*, const double* x, const int* entity,
                           const std::uint8_t*) { matrix->add(A, w, constants, x, facets ? *entity : 0); };
    data[facets ? IntegralType::exterior_facet : IntegralType::cell].emplace_back(
        id++,
        std::function<void(double*, const double*, const double*, const double*, const int*, const std::uint8_t*)>(
            kernel),
        integral.entities, active);
  }
  const std::vector<std::shared_ptr<const FunctionSpace>> spaces{V[0], V[1]};
  return dolfinx::fem::Form<double>(spaces, data, functions,
                                    std::vector<std::shared_ptr<const dolfinx::fem::Constant<double>>>(), false,
                                    std::map<std::shared_ptr<const Mesh>, std::span<const std::int32_t>>());
}

Tangent::Tangent(const std::array<std::shared_ptr<const FunctionSpace>, 2>& V, const std::vector<Integral>& integrals,
                 const std::map<std::string, std::shared_ptr<const Function>>& coefficients)
    : _form(create_form(V, integrals, coefficients)), _matrix(dolfinx::fem::petsc::create_matrix(_form))
{
}

Tangent::~Tangent()
{
  MatDestroy(&_matrix);
}

void Tangent::assemble(const std::vector<std::shared_ptr<const dolfinx::fem::DirichletBC<double>>>& bcs)
{
  MatZeroEntries(_matrix);
  dolfinx::fem::assemble_matrix(dolfinx::la::petsc::Matrix::set_block_fn(_matrix, ADD_VALUES), _form, bcs);
  MatAssemblyBegin(_matrix, MAT_FLUSH_ASSEMBLY);
  MatAssemblyEnd(_matrix, MAT_FLUSH_ASSEMBLY);
  dolfinx::fem::set_diagonal(dolfinx::la::petsc::Matrix::set_fn(_matrix, INSERT_VALUES), *_form.function_spaces()[0],
                             bcs);
  MatAssemblyBegin(_matrix, MAT_FINAL_ASSEMBLY);
  MatAssemblyEnd(_matrix, MAT_FINAL_ASSEMBLY);
}
} // namespace dolfinx_impact::operators
