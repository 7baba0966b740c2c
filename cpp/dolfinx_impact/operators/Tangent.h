// SPDX-License-Identifier: MIT
#pragma once
#include "Batches.h"
#include <dolfinx/fem/Constant.h>
#include <dolfinx/fem/DirichletBC.h>
#include <dolfinx/fem/Form.h>
#include <petscmat.h>

namespace dolfinx_impact::operators
{
/// A DOLFINx form of rank 2 made of this project's kernels: matrix assembly, sparsity and boundary conditions are
/// DOLFINx's. From Python, dolfinx.fem.form does the same with FFCx's own C kernels.
/// @param[in] V test and trial space
/// @param[in] integrals kernels that CellMatrix takes, on cells or exterior facets; constants are fixed here
/// @param[in] coefficients by name
dolfinx::fem::Form<double> create_form(const std::array<std::shared_ptr<const FunctionSpace>, 2>& V,
                                       const std::vector<Integral>& integrals,
                                       const std::map<std::string, std::shared_ptr<const Function>>& coefficients);

/// Tangent matrix of a problem, kept in a PETSc matrix that is created once.
class Tangent
{
public:
  Tangent(const std::array<std::shared_ptr<const FunctionSpace>, 2>& V, const std::vector<Integral>& integrals,
          const std::map<std::string, std::shared_ptr<const Function>>& coefficients);
  ~Tangent();
  Tangent(const Tangent&) = delete;
  Tangent& operator=(const Tangent&) = delete;

  /// Assemble at the present coefficients; constrained rows and columns are zeroed, with one on the diagonal.
  void assemble(const std::vector<std::shared_ptr<const dolfinx::fem::DirichletBC<double>>>& bcs = {});

  /// Borrowed PETSc matrix, valid as long as this object.
  Mat matrix() const { return _matrix; }

private:
  dolfinx::fem::Form<double> _form;
  Mat _matrix;
};
} // namespace dolfinx_impact::operators
