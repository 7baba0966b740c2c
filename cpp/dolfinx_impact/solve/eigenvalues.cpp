// SPDX-License-Identifier: MIT
#include "eigenvalues.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <array>
#include <petscksp.h>
#include <stdexcept>
#include <string>
#ifdef HAS_SLEPC
#include <slepceps.h>
#include <slepcpep.h>
#endif

using dolfinx_impact::operators::check;

namespace dolfinx_impact::solve
{
#ifdef HAS_SLEPC
namespace
{
/// Programs that begin with PETSc alone have not begun SLEPc; it ends when PETSc does.
void begin_slepc()
{
  PetscBool ready = PETSC_FALSE;
  check(SlepcInitialized(&ready), "SLEPc is asked whether it has begun");
  if (!ready)
  {
    check(SlepcInitialize(nullptr, nullptr, nullptr, nullptr), "SLEPc begins");
    check(PetscRegisterFinalize(SlepcFinalize), "SLEPc begins");
  }
}

/// SLEPc's solver, destroyed with this.
class Solver
{
public:
  Solver(Mat A, Mat B, EigenOptions options)
  {
    begin_slepc();
    check(EPSCreate(PetscObjectComm(PetscObject(A)), &_eps), "an eigenvalue solver is made");
    check(EPSSetOperators(_eps, A, B), "an eigenvalue solver is made");
    check(EPSSetProblemType(_eps, B ? EPS_GHEP : EPS_HEP), "an eigenvalue solver is made");
    check(EPSSetTolerances(_eps, options.tolerance, options.max_iterations), "an eigenvalue solver is made");
  }
  ~Solver() { EPSDestroy(&_eps); }
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;
  EPS get() const { return _eps; }

private:
  EPS _eps = nullptr;
};

/// SLEPc's solver of quadratic problems, destroyed with this.
class QuadraticSolver
{
public:
  explicit QuadraticSolver(MPI_Comm comm)
  {
    begin_slepc();
    check(PEPCreate(comm, &_pep), "an eigenvalue solver is made");
  }
  ~QuadraticSolver() { PEPDestroy(&_pep); }
  QuadraticSolver(const QuadraticSolver&) = delete;
  QuadraticSolver& operator=(const QuadraticSolver&) = delete;
  PEP get() const { return _pep; }

private:
  PEP _pep = nullptr;
};

/// Does any rank own no rows of a matrix?
bool has_empty_rank(Mat A)
{
  const PetscInt* ranges = nullptr;
  int size = 0;
  MPI_Comm_size(PetscObjectComm(PetscObject(A)), &size);
  check(MatGetOwnershipRanges(A, &ranges), "a matrix is asked for its rows");
  for (int rank = 0; rank < size; ++rank)
    if (ranges[rank] == ranges[rank + 1])
      return true;
  return false;
}

KSP inner_solver(EPS eps)
{
  ST transform = nullptr;
  KSP ksp = nullptr;
  check(EPSGetST(eps, &transform), "an eigenvalue solver is asked for");
  check(STGetKSP(transform, &ksp), "an eigenvalue solver is asked for");
  return ksp;
}

void factorise(KSP ksp, PCType type)
{
  PC pc = nullptr;
  check(KSPSetType(ksp, KSPPREONLY), "a linear solver is chosen");
  check(KSPGetPC(ksp, &pc), "a preconditioner is asked for");
  check(PCSetType(pc, type), "a preconditioner is chosen");
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), "a preconditioner is chosen");
}
} // namespace

std::optional<std::pair<double, Vec>> largest_eigenvalue(Mat A, Mat B, EigenOptions options)
{
  const Solver solver(A, B, options);
  EPS eps = solver.get();
  check(EPSSetWhichEigenpairs(eps, EPS_LARGEST_REAL), "an eigenvalue solver is made");
  if (B)
  {
    KSP ksp = inner_solver(eps);
    if (options.inner == InnerSolver::cholesky)
      factorise(ksp, PCCHOLESKY);
    else
    {
      PC pc = nullptr;
      check(KSPSetType(ksp, KSPCG), "a linear solver is chosen");
      check(KSPGetPC(ksp, &pc), "a preconditioner is asked for");
      check(PCSetType(pc, PCJACOBI), "a preconditioner is chosen");
      check(KSPSetTolerances(ksp, 1e-10, PETSC_CURRENT, PETSC_CURRENT, 2000), "tolerances are set");
    }
  }
  check(EPSSolve(eps), "an eigenvalue problem is solved");
  PetscInt found = 0;
  check(EPSGetConverged(eps, &found), "eigenvalues are counted");
  if (found == 0)
    return {};
  Vec x = nullptr;
  double value = 0.0;
  check(MatCreateVecs(A, &x, nullptr), "a vector is made");
  check(EPSGetEigenpair(eps, 0, &value, nullptr, x, nullptr), "an eigenvalue is read");
  return std::pair{value, x};
}

std::vector<double> lowest_eigenvalues(Mat A, Mat B, int count, double shift, EigenOptions options)
{
  const Solver solver(A, B, options);
  EPS eps = solver.get();
  check(EPSSetWhichEigenpairs(eps, EPS_TARGET_MAGNITUDE), "an eigenvalue solver is made");
  check(EPSSetTarget(eps, shift), "an eigenvalue solver is made");
  check(EPSSetDimensions(eps, count, std::max(2 * count, 20), PETSC_DETERMINE), "an eigenvalue solver is made");
  ST transform = nullptr;
  check(EPSGetST(eps, &transform), "an eigenvalue solver is asked for");
  check(STSetType(transform, STSINVERT), "an eigenvalue solver is made");
  factorise(inner_solver(eps), PCLU);
  check(EPSSolve(eps), "an eigenvalue problem is solved");
  PetscInt found = 0;
  check(EPSGetConverged(eps, &found), "eigenvalues are counted");
  if (found < count)
    throw std::runtime_error("SLEPc found " + std::to_string(int(found)) + " of " + std::to_string(count) +
                             " eigenvalues");
  std::vector<double> out(found);
  for (PetscInt i = 0; i < found; ++i)
    check(EPSGetEigenvalue(eps, i, &out[i], nullptr), "an eigenvalue is read");
  std::ranges::sort(out);
  out.resize(count);
  return out;
}

std::vector<QuadraticEigenpair> quadratic_eigenpairs(Mat K, Mat G, Mat M, int count, double shift, EigenOptions options)
{
  const QuadraticSolver solver(PetscObjectComm(PetscObject(K)));
  PEP pep = solver.get();
  std::array<Mat, 3> matrices{K, G, M};
  check(PEPSetOperators(pep, 3, matrices.data()), "an eigenvalue solver is made");
  check(PEPSetProblemType(pep, PEP_GENERAL), "an eigenvalue solver is made");
  check(PEPSetType(pep, PEPTOAR), "an eigenvalue solver is made");
  check(PEPSetScale(pep, PEP_SCALE_SCALAR, PETSC_CURRENT, nullptr, nullptr, PETSC_CURRENT, PETSC_CURRENT),
        "an eigenvalue solver is made");
  if (has_empty_rank(K))
  {
    // SLEPc 3.22 scales the vectors of its default type by LAPACK, which refuses a rank that owns no rows.
    BV vectors = nullptr;
    check(PEPGetBV(pep, &vectors), "an eigenvalue solver is asked for");
    check(BVSetType(vectors, BVVECS), "an eigenvalue solver is made");
  }
  check(PEPSetDimensions(pep, count, PETSC_DETERMINE, PETSC_DETERMINE), "an eigenvalue solver is made");
  check(PEPSetTolerances(pep, options.tolerance, options.max_iterations), "an eigenvalue solver is made");
  check(PEPSetTarget(pep, shift), "an eigenvalue solver is made");
  check(PEPSetWhichEigenpairs(pep, PEP_TARGET_MAGNITUDE), "an eigenvalue solver is made");
  ST transform = nullptr;
  KSP ksp = nullptr;
  check(PEPGetST(pep, &transform), "an eigenvalue solver is asked for");
  check(STSetType(transform, STSINVERT), "an eigenvalue solver is made");
  check(STGetKSP(transform, &ksp), "an eigenvalue solver is asked for");
  factorise(ksp, PCLU);
  check(PEPSolve(pep), "an eigenvalue problem is solved");
  PetscInt found = 0;
  check(PEPGetConverged(pep, &found), "eigenvalues are counted");
  std::vector<QuadraticEigenpair> out;
  for (PetscInt i = 0; i < found; ++i)
  {
    QuadraticEigenpair pair{};
    check(MatCreateVecs(K, &pair.real, nullptr), "a vector is made");
    check(MatCreateVecs(K, &pair.imaginary, nullptr), "a vector is made");
    double real = 0.0, imaginary = 0.0;
    check(PEPGetEigenpair(pep, i, &real, &imaginary, pair.real, pair.imaginary), "an eigenvalue is read");
    pair.value = {real, imaginary};
    out.push_back(pair);
  }
  return out;
}
#else
namespace
{
[[noreturn]] void without_slepc()
{
  throw std::runtime_error("eigenvalues need SLEPc, and DOLFINx was built without it");
}
} // namespace

std::optional<std::pair<double, Vec>> largest_eigenvalue(Mat, Mat, EigenOptions)
{
  without_slepc();
}

std::vector<double> lowest_eigenvalues(Mat, Mat, int, double, EigenOptions)
{
  without_slepc();
}

std::vector<QuadraticEigenpair> quadratic_eigenpairs(Mat, Mat, Mat, int, double, EigenOptions)
{
  without_slepc();
}
#endif

int num_negative_eigenvalues(Mat A)
{
  PC pc = nullptr;
  Mat factors = nullptr;
  check(PCCreate(PetscObjectComm(PetscObject(A)), &pc), "a preconditioner is made");
  check(MatSetOption(A, MAT_SYMMETRIC, PETSC_TRUE), "a matrix is marked as symmetric");
  check(PCSetOperators(pc, A, A), "a preconditioner is made");
  check(PCSetType(pc, PCCHOLESKY), "a preconditioner is chosen");
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), "a preconditioner is chosen");
  check(PCFactorSetUpMatSolverType(pc), "a preconditioner is made");
  check(PCFactorGetMatrix(pc, &factors), "factors are asked for");
  // A root of its own in ScaLAPACK does not count pivots: MUMPS then factorises it on one process.
  check(MatMumpsSetIcntl(factors, 13, 1), "MUMPS is told an option");
  check(MatMumpsSetIcntl(factors, 24, 1), "MUMPS is told an option"); // MatGetInertia asks for null pivots
  check(PCSetUp(pc), "a matrix is factorised");
  PetscInt negative = 0, zero = 0, positive = 0;
  check(MatGetInertia(factors, &negative, &zero, &positive), "factors are asked for their inertia");
  check(PCDestroy(&pc), "a preconditioner is destroyed");
  return int(negative);
}
} // namespace dolfinx_impact::solve
