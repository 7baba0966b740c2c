// SPDX-License-Identifier: MIT
#include "TieSystem.h"
#include "../../common/gather.h"
#include "../../operators/PetscErrorText.h"
#include "../../operators/petsc_check.h"
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
using operators::check;

TieSystem::TieSystem(std::vector<const TieConditions*> ties, std::span<const double> inverse_mass)
    : _comm(ties.at(0)->comm()), _ties(std::move(ties)), _inverse_mass(inverse_mass.begin(), inverse_mass.end())
{
  Mat scaled = nullptr, transposed = nullptr, product = nullptr;
  for (const TieConditions* tie : _ties)
    if (!scaled)
      check(MatDuplicate(tie->matrix(), MAT_COPY_VALUES, &scaled), "a matrix is copied");
    else
      check(MatAXPY(scaled, 1.0, tie->matrix(), DIFFERENT_NONZERO_PATTERN), "matrices are added");
  Vec root = nullptr;
  check(MatCreateVecs(scaled, &root, nullptr), "a vector is made");
  PetscInt first = 0;
  check(VecGetOwnershipRange(root, &first, nullptr), "a vector is asked for its rows");
  {
    operators::Entries values(root);
    if (values.size() != _inverse_mass.size())
      throw std::invalid_argument("an inverse mass of every owned degree of freedom is needed");
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = std::sqrt(_inverse_mass[i]);
  }
  check(MatDiagonalScale(scaled, nullptr, root), "a matrix is scaled");
  check(VecDestroy(&root), "a vector is destroyed");
  check(MatTranspose(scaled, MAT_INITIAL_MATRIX, &transposed), "a matrix is transposed");
  check(MatMatMult(scaled, transposed, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &product), "matrices are multiplied");
  check(MatDestroy(&scaled), "a matrix is destroyed");
  check(MatDestroy(&transposed), "a matrix is destroyed");

  for (const TieConditions* tie : _ties)
  {
    const Constraints& rows = tie->rows();
    const PetscInt g = tie->gdim();
    for (std::size_t k = 0; k < rows.size(); ++k)
      for (PetscInt d = 0; d < g; ++d)
        if (rows.constrained[k * g + d])
          _rows.push_back(first + g * rows.nodes[k] + d);
  }
  int size = 0;
  const int mine = int(_rows.size());
  MPI_Comm_size(_comm, &size);
  _counts.resize(size);
  MPI_Allgather(&mine, 1, MPI_INT, _counts.data(), 1, MPI_INT, _comm);
  _starts.assign(size, 0);
  std::partial_sum(_counts.begin(), _counts.end() - 1, _starts.begin() + 1);
  // PETSc takes the rows of a submatrix in ascending order; those of a rank are tie after tie.
  const std::vector<std::int64_t> wide = common::gather(_comm, std::vector<std::int64_t>(_rows.begin(), _rows.end()));
  std::vector<PetscInt> all(wide.begin(), wide.end());
  std::ranges::sort(all);
  for (std::int64_t row : wide)
    _order.push_back(std::size_t(std::ranges::lower_bound(all, PetscInt(row)) - all.begin()));
  for (std::vector<double>* values : {&_received, &_b, &_z})
    values->assign(all.size(), 0.0);

  IS rows = nullptr;
  Mat* parts = nullptr;
  check(ISCreateGeneral(PETSC_COMM_SELF, PetscInt(all.size()), all.data(), PETSC_COPY_VALUES, &rows), "rows are named");
  check(MatCreateSubMatrices(product, 1, &rows, &rows, MAT_INITIAL_MATRIX, &parts), "a matrix is gathered");
  check(MatDestroy(&product), "a matrix is destroyed");
  IS order = nullptr, other = nullptr;
  MatFactorInfo info;
  check(MatFactorInfoInitialize(&info), "factors are made");
  {
    const operators::PetscErrorText error;
    PetscErrorCode code = MatGetFactor(parts[0], MATSOLVERPETSC, MAT_FACTOR_CHOLESKY, &_factors);
    if (!code)
      code = MatGetOrdering(parts[0], MATORDERINGND, &order, &other);
    if (!code)
      code = MatCholeskyFactorSymbolic(_factors, parts[0], order, &info);
    if (!code)
      code = MatCholeskyFactorNumeric(_factors, parts[0], &info);
    MatFactorError fault = MAT_FACTOR_NOERROR;
    if (!code)
      code = MatFactorGetError(_factors, &fault);
    if (code || fault != MAT_FACTOR_NOERROR)
      throw std::runtime_error(
          "the conditions of the ties imply each other: leave common nodes out of one of the tags" +
          (code ? " (" + error.text() + ")" : std::string()));
  }
  check(ISDestroy(&order), "an order is destroyed");
  check(ISDestroy(&other), "an order is destroyed");
  check(ISDestroy(&rows), "rows are destroyed");
  check(MatDestroySubMatrices(1, &parts), "a matrix is destroyed");
  check(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, PetscInt(_b.size()), _b.data(), &_right), "a vector is made");
  check(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, PetscInt(_z.size()), _z.data(), &_solution), "a vector is made");
}

TieSystem::~TieSystem()
{
  VecDestroy(&_right);
  VecDestroy(&_solution);
  MatDestroy(&_factors);
}

void TieSystem::solve(std::span<const double> b, std::span<double> z)
{
  int rank = 0;
  MPI_Comm_rank(_comm, &rank);
  MPI_Allgatherv(b.data(), int(_rows.size()), MPI_DOUBLE, _received.data(), _counts.data(), _starts.data(), MPI_DOUBLE,
                 _comm);
  for (std::size_t k = 0; k < _order.size(); ++k)
    _b[_order[k]] = _received[k];
  check(MatSolve(_factors, _right, _solution), "the forces of ties are solved for");
  for (std::size_t k = 0; k < _rows.size(); ++k)
    z[k] = _z[_order[_starts[rank] + k]];
}

std::vector<double> TieSystem::project(std::span<const double> v)
{
  std::vector<double> b(size()), z(size()), out(v.begin(), v.end());
  const auto for_each = [&](const auto& act)
  {
    std::size_t at = 0;
    for (const TieConditions* tie : _ties)
    {
      const Constraints& rows = tie->rows();
      const int g = tie->gdim();
      std::vector<double> values = tie->jump(v), forces(values.size(), 0.0);
      for (std::size_t k = 0; k < rows.size(); ++k)
        for (int d = 0; d < g; ++d)
          if (rows.constrained[k * g + d])
            act(at++, tie->weight()[k * g + d] * values[rows.rows[k] * g + d], forces[rows.rows[k] * g + d]);
      const std::vector<double> nodal = tie->forces(forces);
      for (std::size_t i = 0; i < out.size(); ++i)
        out[i] -= _inverse_mass[i] * nodal[i];
    }
  };
  for_each([&](std::size_t at, double jump, double&) { b[at] = jump; });
  solve(b, z);
  for_each([&](std::size_t at, double, double& force) { force = z[at]; });
  return out;
}

double TieSystem::largest_jump(std::span<const double> v) const
{
  double here = 0.0;
  for (const TieConditions* tie : _ties)
    for (double jump : tie->jump(v))
      here = std::max(here, std::abs(jump));
  return common::largest(_comm, here);
}
} // namespace dolfinx_impact::enforcement
