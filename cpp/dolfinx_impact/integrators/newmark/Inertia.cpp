// SPDX-License-Identifier: MIT
#include "Inertia.h"
#include "../../common/OnAllRanks.h"
#include "../../common/text.h"
#include "../../operators/petsc_check.h"
#include <cmath>
#include <petscksp.h>
#include <stdexcept>

using dolfinx_impact::operators::check;
using dolfinx_impact::operators::Entries;

namespace dolfinx_impact::integrators
{
namespace
{
constexpr double solved = 1e-14; // relative residual that is aimed at: round-off of a well-conditioned matrix
constexpr double enough = 1e-9;  // relative residual that is accepted where round-off does not let it get there
constexpr int most = 2000;       // iterations; meshes whose cells differ by 10^6 in volume need some hundred

void set(Vec x, std::span<const double> values)
{
  Entries entries(x);
  for (std::size_t i = 0; i < entries.size(); ++i)
    entries[i] = values[i];
}

double norm(MPI_Comm comm, std::span<const double> values)
{
  double sum = 0.0;
  for (double v : values)
    sum += v * v;
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm);
  return std::sqrt(sum);
}
} // namespace

Inertia::Inertia(Mat matrix, std::vector<std::int8_t> massless) : _matrix(matrix), _massless(std::move(massless))
{
  check(PetscObjectReference((PetscObject)_matrix), "a mass matrix is kept");
  check(MatCreateVecs(_matrix, &_x, &_y), "vectors of a mass matrix are made");
}

Inertia::~Inertia()
{
  MatDestroy(&_matrix);
  VecDestroy(&_x);
  VecDestroy(&_y);
}

std::vector<double> Inertia::times(std::span<const double> x) const
{
  set(_x, x);
  check(MatMult(_matrix, _x, _y), "a mass matrix is multiplied");
  return operators::values_of(_y);
}

std::vector<double> Inertia::accelerations(std::span<const double> forces, std::span<const std::int8_t> fixed,
                                           std::span<const double> given) const
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)_matrix);
  const std::size_t n = _massless.size();
  PetscInt first = 0;
  check(MatGetOwnershipRange(_matrix, &first, nullptr), "a mass matrix is asked for its rows");
  std::vector<double> a(n, 0.0);
  std::vector<PetscInt> pinned;
  for (std::size_t i = 0; i < n; ++i)
  {
    if (fixed[i])
      a[i] = given[i];
    if (fixed[i] || _massless[i])
      pinned.push_back(first + PetscInt(i));
  }
  const auto missing = [&]
  {
    std::vector<double> out = times(a);
    for (std::size_t i = 0; i < n; ++i)
      out[i] = fixed[i] || _massless[i] ? 0.0 : forces[i] - out[i];
    return out;
  };
  const std::vector<double> rest = missing();
  Mat matrix = nullptr;
  KSP solver = nullptr;
  check(MatDuplicate(_matrix, MAT_COPY_VALUES, &matrix), "a mass matrix is copied");
  check(MatZeroRowsColumns(matrix, PetscInt(pinned.size()), pinned.data(), 1.0, nullptr, nullptr),
        "rows of a mass matrix are pinned");
  check(KSPCreate(comm, &solver), "a solver is made");
  check(KSPSetType(solver, KSPCG), "a solver is chosen");
  PC pc = nullptr;
  check(KSPGetPC(solver, &pc), "a preconditioner is chosen");
  check(PCSetType(pc, PCJACOBI), "a preconditioner is chosen");
  check(KSPSetNormType(solver, KSP_NORM_UNPRECONDITIONED), "a norm is chosen");
  check(KSPSetTolerances(solver, solved, PETSC_CURRENT, PETSC_CURRENT, most), "tolerances are set");
  check(KSPSetOperators(solver, matrix, matrix), "a matrix is given to a solver");
  set(_x, rest);
  check(KSPSolve(solver, _x, _y), "the accelerations at the start are solved for");
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(solver, &iterations), "a solver is asked for its iterations");
  const std::vector<double> found = operators::values_of(_y);
  for (std::size_t i = 0; i < n; ++i)
    if (!fixed[i] && !_massless[i])
      a[i] += found[i];
  KSPDestroy(&solver);
  MatDestroy(&matrix);
  const double left = norm(comm, missing()), all = norm(comm, rest);
  if (!(left <= enough * all))
    throw common::Failure("the accelerations at the start were not found in " + std::to_string(iterations) +
                          " iterations: the residual is " + common::text("%.1e", left) + ", the forces " +
                          common::text("%.1e", all));
  return a;
}
} // namespace dolfinx_impact::integrators
