// SPDX-License-Identifier: MIT
#pragma once
#include "Batches.h"
#include "CellMatrix.h"
#include "CellValues.h"
#include "NodalAverage.h"
#include <dolfinx/fem/DirichletBC.h>
#include <dolfinx/fem/Form.h>
#include <petscmat.h>

namespace dolfinx_impact::operators
{
/// Matrix of a bilinear form in a PETSc matrix that is made once: kernels of this project, and a form of DOLFINx with
/// FFCx's kernels. Either may be missing.
class KernelTangent
{
public:
  typedef std::vector<std::shared_ptr<const dolfinx::fem::DirichletBC<double>>> BoundaryConditions;

  /// An integral whose coefficients have other names in the kernel than here.
  struct Named
  {
    Integral integral;
    std::vector<CellValues::Source> sources; ///< of the kernel's coefficients, in their order
  };

  /// Collective.
  /// @param[in] V test and trial space
  /// @param[in] integrals kernels that CellMatrix takes, on cells or exterior facets; their histories are read, of the
  ///   last step, and the solution of the local equations of the last evaluation
  /// @param[in] coefficients by name; their values are read anew at every call
  /// @param[in] other form of rank 2 that is added; null: nothing is
  /// @throws std::runtime_error if a kernel is not for this mesh or these spaces (kernels/check.h)
  /// @throws std::invalid_argument if a coefficient, constant or history is missing, or for interior facets
  KernelTangent(const std::array<std::shared_ptr<const FunctionSpace>, 2>& V, const std::vector<Integral>& integrals,
                const Coefficients& coefficients, std::shared_ptr<const dolfinx::fem::Form<double>> other = nullptr);
  /// The same of integrals with the sources of their coefficients.
  KernelTangent(const std::array<std::shared_ptr<const FunctionSpace>, 2>& V, const std::vector<Named>& integrals,
                std::shared_ptr<const dolfinx::fem::Form<double>> other);
  ~KernelTangent();
  KernelTangent(const KernelTangent&) = delete;
  KernelTangent& operator=(const KernelTangent&) = delete;

  /// Assemble at the present coefficients; constrained rows and columns are zeroed, with one on the diagonal.
  /// Collective.
  /// @pre coefficients have up-to-date ghost values
  void assemble(const BoundaryConditions& bcs = {});

  /// What the derivative of forces that read averages at the nodes adds: (force by average) (average by displacement).
  /// It joins nodes that share no cell, but a neighbour.
  struct AverageTerm
  {
    std::shared_ptr<NodalAverage> average;  ///< computed before every assembly
    std::shared_ptr<KernelTangent> force;   ///< derivative of the force by the averages: rows of the test space
    std::shared_ptr<KernelTangent> measure; ///< derivative of what is averaged: columns of the trial space
  };
  /// The matrix has the entries of this product from now on. Collective.
  void add_average(AverageTerm term);

  /// Replace the constants of integral i.
  void set_constants(std::size_t i, std::span<const double> c) { _parts.at(i).set_constants(c); }
  /// Borrowed PETSc matrix, valid as long as this object.
  Mat matrix() const { return _matrix; }

private:
  /// One integral.
  class Part
  {
  public:
    Part(const Named& named, const std::array<std::shared_ptr<const FunctionSpace>, 2>& V);
    void set_constants(std::span<const double> c);
    /// Cells of the entities.
    std::vector<std::int32_t> cells() const;

    const impact_kernel* kernel;
    CellMatrix matrix;
    CellValues values;
    std::vector<std::int32_t> entities;
    std::vector<double> constants;
    bool facets; ///< of exterior facets: entities are pairs
  };

  void add(Part& part, const std::array<std::vector<std::int8_t>, 2>& constrained);
  void compute(Part& part, std::size_t first, std::size_t count);
  void assemble_zeros();
  void add(AverageTerm& term, const BoundaryConditions& bcs, bool new_entries);

  std::array<std::shared_ptr<const FunctionSpace>, 2> _V;
  std::vector<Part> _parts;
  std::shared_ptr<const dolfinx::fem::Form<double>> _other;
  std::vector<AverageTerm> _averages;
  AlignedVector _matrices; ///< of some cells
  std::vector<double> _A;  ///< matrix of a cell
  Mat _matrix = nullptr;
};
} // namespace dolfinx_impact::operators
