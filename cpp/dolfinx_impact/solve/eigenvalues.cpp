// SPDX-License-Identifier: MIT
#include "eigenvalues.h"
#include "../operators/petsc_check.h"
#include <algorithm>
#include <stdexcept>
#include <string>
#ifdef HAS_SLEPC
#include <slepceps.h>
#endif

using dolfinx_impact::operators::check;

namespace dolfinx_impact::solve
{
#ifdef HAS_SLEPC
namespace
{
/// SLEPc's solver, destroyed with this.
class Solver
{
public:
  Solver(Mat A, Mat B, EigenOptions options)
  {
    // Programs that begin with PETSc alone have not begun SLEPc; it ends when PETSc does.
    PetscBool ready = PETSC_FALSE;
    check(SlepcInitialized(&ready), "SLEPc is asked whether it has begun");
    if (!ready)
    {
      check(SlepcInitialize(nullptr, nullptr, nullptr, nullptr), "SLEPc begins");
      check(PetscRegisterFinalize(SlepcFinalize), "SLEPc begins");
    }
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
#endif
} // namespace dolfinx_impact::solve
