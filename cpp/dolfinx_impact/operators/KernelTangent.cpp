// SPDX-License-Identifier: MIT
#include "KernelTangent.h"
#include "../common/dolfinx_api.h"
#include "../kernels/check.h"
#include "petsc_check.h"
#include "petsc_communicators.h"
#include <algorithm>
#include <dolfinx/fem/assembler.h>
#include <dolfinx/fem/petsc.h>
#include <dolfinx/la/petsc.h>
#include <stdexcept>

namespace dolfinx_impact::operators
{
namespace
{
/// Empty pattern of a matrix between two spaces.
dolfinx::la::SparsityPattern empty_pattern(const FunctionSpace& rows, const FunctionSpace& columns)
{
  const auto &of_rows = *rows.dofmap(), &of_columns = *columns.dofmap();
  return {rows.mesh()->comm(),
          {of_rows.index_map, of_columns.index_map},
          {of_rows.index_map_bs(), of_columns.index_map_bs()}};
}

/// Integrals whose coefficients are found by name.
std::vector<KernelTangent::Named> by_name(const std::vector<Integral>& integrals, const Coefficients& coefficients)
{
  std::vector<KernelTangent::Named> out;
  for (const Integral& i : integrals)
    out.push_back({i, CellValues::sources(*i.kernel, coefficients, i.history.get())});
  return out;
}

/// Number of the coefficient that stands for the trial function, if there is one.
std::optional<int> direction(const KernelTangent::Named& named)
{
  for (std::size_t i = 0; i < named.sources.size(); ++i)
    if (!named.sources[i].function && named.sources[i].field.empty())
      return int(i);
  return std::nullopt;
}

/// Degrees of freedom that conditions on a space prescribe, owned and ghosts; empty without conditions.
std::vector<std::int8_t> constrained_dofs(const FunctionSpace& V, const KernelTangent::BoundaryConditions& bcs)
{
  std::vector<std::int8_t> marked;
  if (bcs.empty())
    return marked;
  const auto& map = *V.dofmap();
  marked.resize(std::size_t(map.index_map->size_local() + map.index_map->num_ghosts()) * map.index_map_bs(), 0);
  for (const auto& bc : bcs)
    if (V.contains(*bc->function_space()))
      bc->mark_dofs(marked);
  return marked;
}
} // namespace

KernelTangent::Part::Part(const Named& named, const std::array<std::shared_ptr<const FunctionSpace>, 2>& V)
    : kernel(named.integral.kernel), matrix(*kernel, direction(named)),
      values(*kernel, *V[0], named.sources, named.integral.history, matrix.num_cells()),
      entities(named.integral.entities), facets(std::string(kernel->integral_type) == "exterior_facet")
{
  if (std::string(kernel->integral_type) == "interior_facet")
    throw std::invalid_argument(std::string("kernel ") + kernel->name +
                                " is of interior facets: their matrices are assembled by DOLFINx's own kernels");
  for (int a = 0; a < kernel->rank; ++a)
    kernels::check_space(*kernel, kernel->arguments[a], *V[a], a ? "trial space" : "test space");
  if (facets && entities.size() % 2)
    throw std::invalid_argument("facet integrals take pairs (cell, local facet)");
  set_constants(named.integral.constants);
}

void KernelTangent::Part::set_constants(std::span<const double> c)
{
  if (int(c.size()) != kernel->size_c)
    throw std::invalid_argument(std::string("kernel ") + kernel->name + " takes " + std::to_string(kernel->size_c) +
                                " values of constants, found " + std::to_string(c.size()));
  constants.assign(c.begin(), c.end());
}

std::vector<std::int32_t> KernelTangent::Part::cells() const
{
  if (!facets)
    return entities;
  std::vector<std::int32_t> out;
  for (std::size_t i = 0; i < entities.size(); i += 2)
    out.push_back(entities[i]);
  return out;
}

KernelTangent::KernelTangent(const std::array<std::shared_ptr<const FunctionSpace>, 2>& V,
                             const std::vector<Integral>& integrals, const Coefficients& coefficients,
                             std::shared_ptr<const dolfinx::fem::Form<double>> other)
    : KernelTangent(V, by_name(integrals, coefficients), std::move(other))
{
}

KernelTangent::KernelTangent(const std::array<std::shared_ptr<const FunctionSpace>, 2>& V,
                             const std::vector<Named>& integrals,
                             std::shared_ptr<const dolfinx::fem::Form<double>> other)
    : _V(V), _other(std::move(other))
{
  for (const auto& space : V)
    keep_petsc_communicators(*space);
  _parts.reserve(integrals.size());
  for (const Named& integral : integrals)
    _parts.emplace_back(integral, V);
  dolfinx::la::SparsityPattern pattern =
      _other ? dolfinx::fem::create_sparsity_pattern(*_other) : empty_pattern(*V[0], *V[1]);
  for (const Part& part : _parts)
  {
    common::insert_cells(pattern, part.cells(), *V[0]->dofmap(), *V[1]->dofmap());
    const std::size_t size = std::size_t(part.matrix.num_rows()) * part.matrix.num_columns();
    _A.resize(std::max(_A.size(), size));
    _matrices.resize(std::max(_matrices.size(), size * part.matrix.num_cells()));
  }
  pattern.finalize();
  _matrix = dolfinx::la::petsc::create_matrix(V[0]->mesh()->comm(), pattern);
}

KernelTangent::~KernelTangent()
{
  MatDestroy(&_matrix);
}

/// Matrices of some entities, from entity `first` on.
void KernelTangent::compute(Part& part, std::size_t first, std::size_t count)
{
  const std::size_t size = std::size_t(part.matrix.num_rows()) * part.matrix.num_columns();
  std::fill_n(_matrices.begin(), size * part.matrix.num_cells(), 0.0);
  if (part.facets)
    part.values.gather(part.entities[2 * first]);
  else
    part.values.gather(std::span(part.entities).subspan(first, count));
  part.matrix.add(_matrices.data(), part.values.w(), part.constants, part.values.nodes(),
                  part.facets ? part.entities[2 * first + 1] : 0);
}

void KernelTangent::add(Part& part, const std::array<std::vector<std::int8_t>, 2>& constrained)
{
  auto insert = dolfinx::la::petsc::Matrix::set_block_fn(_matrix, ADD_VALUES);
  const auto &rows = *_V[0]->dofmap(), &columns = *_V[1]->dofmap();
  const int num_rows = part.matrix.num_rows(), num_columns = part.matrix.num_columns(), stride = part.facets ? 2 : 1;
  const std::span<double> A(_A.data(), std::size_t(num_rows) * num_columns);
  const std::size_t count = part.entities.size() / stride, together = part.matrix.num_cells();
  for (std::size_t e = 0; e < count; ++e)
  {
    const std::size_t lane = e % together;
    if (lane == 0)
      compute(part, e, std::min(together, count - e));
    for (std::size_t k = 0; k < A.size(); ++k)
      A[k] = _matrices[k * together + lane];
    const std::int32_t cell = part.entities[e * stride];
    const auto dofs = rows.cell_dofs(cell), trial_dofs = columns.cell_dofs(cell);
    if (!constrained[0].empty())
      for (int i = 0; i < num_rows; ++i)
        if (constrained[0][rows.bs() * dofs[i / rows.bs()] + i % rows.bs()])
          std::fill_n(A.begin() + std::ptrdiff_t(i) * num_columns, num_columns, 0.0);
    if (!constrained[1].empty())
      for (int j = 0; j < num_columns; ++j)
        if (constrained[1][columns.bs() * trial_dofs[j / columns.bs()] + j % columns.bs()])
          for (int i = 0; i < num_rows; ++i)
            A[std::size_t(i) * num_columns + j] = 0.0;
    check(insert(dofs, trial_dofs, A), "adding the matrix of a cell");
  }
}

/// Entries that nothing is added to are lost when a matrix is assembled: those of cells without averages, too.
void KernelTangent::assemble_zeros()
{
  auto insert = dolfinx::la::petsc::Matrix::set_block_fn(_matrix, ADD_VALUES);
  const std::vector<double> zeros(_A.size(), 0.0);
  for (const Part& part : _parts)
  {
    const std::size_t size = std::size_t(part.matrix.num_rows()) * part.matrix.num_columns();
    for (const std::int32_t cell : part.cells())
      check(insert(_V[0]->dofmap()->cell_dofs(cell), _V[1]->dofmap()->cell_dofs(cell), std::span(zeros).first(size)),
            "a matrix of zeros");
  }
  if (_other)
  {
    std::vector<double> none;
    const auto insert_zeros = [&insert, &none](auto rows, auto columns, auto values)
    {
      none.assign(values.size(), 0.0);
      return insert(rows, columns, none);
    };
    dolfinx::fem::assemble_matrix(insert_zeros, *_other, common::boundary_conditions(BoundaryConditions{}));
  }
  check(MatAssemblyBegin(_matrix, MAT_FINAL_ASSEMBLY), "a matrix of zeros");
  check(MatAssemblyEnd(_matrix, MAT_FINAL_ASSEMBLY), "a matrix of zeros");
}

void KernelTangent::add_average(AverageTerm term)
{
  if (_averages.empty())
    assemble_zeros();
  term.average->update();
  add(term, {}, true);
  _averages.push_back(std::move(term));
}

/// Constrained rows and columns of the product are zero: they are in its factors.
void KernelTangent::add(AverageTerm& term, const BoundaryConditions& bcs, bool new_entries)
{
  term.force->assemble(bcs);
  term.measure->assemble(bcs);
  Vec scale = nullptr;
  check(MatCreateVecs(term.measure->matrix(), nullptr, &scale), "volumes of nodes");
  double* values = nullptr;
  PetscInt owned = 0;
  check(VecGetLocalSize(scale, &owned), "volumes of nodes");
  check(VecGetArray(scale, &values), "volumes of nodes");
  const std::size_t num_averages = std::size_t(term.average->block_size());
  for (PetscInt i = 0; i < owned; ++i)
    values[i] = term.average->inverse_volumes()[std::size_t(i) / num_averages];
  check(VecRestoreArray(scale, &values), "volumes of nodes");
  check(MatDiagonalScale(term.measure->matrix(), scale, nullptr), "derivative of averages");
  Mat product = nullptr;
  check(MatMatMult(term.force->matrix(), term.measure->matrix(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, &product),
        "derivative by averages");
  check(MatAXPY(_matrix, 1.0, product, new_entries ? DIFFERENT_NONZERO_PATTERN : SUBSET_NONZERO_PATTERN),
        "adding the derivative by averages");
  check(MatDestroy(&product), "derivative by averages");
  check(VecDestroy(&scale), "volumes of nodes");
}

void KernelTangent::assemble(const BoundaryConditions& bcs)
{
  for (const AverageTerm& term : _averages)
    term.average->update();
  MatZeroEntries(_matrix);
  const std::array constrained{constrained_dofs(*_V[0], bcs), constrained_dofs(*_V[1], bcs)};
  for (Part& part : _parts)
    add(part, constrained);
  if (_other)
    dolfinx::fem::assemble_matrix(dolfinx::la::petsc::Matrix::set_block_fn(_matrix, ADD_VALUES), *_other,
                                  common::boundary_conditions(bcs));
  if (!_averages.empty())
  {
    check(MatAssemblyBegin(_matrix, MAT_FINAL_ASSEMBLY), "a matrix");
    check(MatAssemblyEnd(_matrix, MAT_FINAL_ASSEMBLY), "a matrix");
  }
  for (AverageTerm& term : _averages)
    add(term, bcs, false);
  if (!bcs.empty() && _V[0] == _V[1])
  {
    MatAssemblyBegin(_matrix, MAT_FLUSH_ASSEMBLY);
    MatAssemblyEnd(_matrix, MAT_FLUSH_ASSEMBLY);
    dolfinx::fem::set_diagonal(dolfinx::la::petsc::Matrix::set_fn(_matrix, INSERT_VALUES), *_V[0],
                               common::boundary_conditions(bcs));
  }
  MatAssemblyBegin(_matrix, MAT_FINAL_ASSEMBLY);
  MatAssemblyEnd(_matrix, MAT_FINAL_ASSEMBLY);
}
} // namespace dolfinx_impact::operators
