// SPDX-License-Identifier: MIT
#include "IncrementSolver.h"
#include "../common/dolfinx_api.h"
#include "../common/text.h"
#include "../operators/PetscErrorText.h"
#include "../operators/petsc_check.h"
#include "equilibrium.h"
#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

using dolfinx_impact::operators::check;

namespace dolfinx_impact::solve
{
namespace
{
constexpr double linear_step = 1e-3; // relative tolerance of the linear step to prescribed values
constexpr int most_rounds = 10;      // calls of PETSc's method whose tolerance is that of another state
// The name of the package's own method in options for Python: there SNES calls methods that are not PETSc's so.
constexpr const char* own_in_python = "python";

Vec make_vector(MPI_Comm comm, std::size_t num_owned)
{
  Vec out = nullptr;
  check(VecCreate(comm, &out), "a vector is made");
  check(VecSetSizes(out, PetscInt(num_owned), PETSC_DETERMINE), "a vector is made");
  check(VecSetUp(out), "a vector is made");
  return out;
}
} // namespace

IncrementSolver::IncrementSolver(std::shared_ptr<const EquilibriumProblem> problem, const NewtonOptions& options,
                                 NewtonEvents events)
    : _problem(std::move(problem)), _options(options.with_database(_problem->linear_solver->prefix())),
      _events(std::move(events))
{
  try
  {
    set_up();
  }
  catch (...) // all ranks read the same options
  {
    free();
    throw;
  }
}

/// Make the SNES and read its options. Collective.
void IncrementSolver::set_up()
{
  const MPI_Comm comm = _problem->comm();
  const std::string prefix = _problem->linear_solver->prefix();
  check(SNESCreate(comm, &_snes), "a solver is made");
  check(SNESSetOptionsPrefix(_snes, prefix.c_str()), "a solver is made");
  check(SNESSetType(_snes, SNESSHELL), "a solver is made");
  check(SNESShellSetSolve(_snes, &IncrementSolver::solve_own), "a solver is made");
  check(SNESShellSetContext(_snes, this), "a solver is made");
  PetscReal rtol = 0.0, atol = 0.0, stol = 0.0;
  PetscInt iterations = 0;
  check(SNESGetTolerances(_snes, &atol, &rtol, &stol, &iterations, &_max_evaluations), "tolerances are read");
  check(SNESSetTolerances(_snes, _options.atol, _options.rtol, 0.0, _options.max_iterations, _max_evaluations),
        "tolerances are set");
  _F = make_vector(comm, _problem->num_owned());
  _x = make_vector(comm, _problem->num_owned());
  check(SNESSetFunction(_snes, _F, &IncrementSolver::evaluate, this), "a solver is made");
  char type[64] = "";
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsGetString(nullptr, prefix.c_str(), "-snes_type", type, sizeof(type), &given), "options are read");
  if (given && std::strcmp(type, own_in_python) == 0) // the prefix is the problem's own
    check(PetscOptionsSetValue(nullptr, ("-" + prefix + "snes_type").c_str(), SNESSHELL), "options are set");
  {
    const operators::PetscErrorText error;
    if (SNESSetFromOptions(_snes))
      throw std::invalid_argument("PETSc does not take the options of SNES: " + error.text());
  }
  check(SNESGetTolerances(_snes, &atol, &rtol, &stol, &iterations, &_max_evaluations), "tolerances are read");
  _options.rtol = rtol;
  _options.atol = atol;
  _options.max_iterations = int(iterations);
  _step_tolerance = stol;
  _newton = make_newton();
  if (own())
    return;
  if (_newton->has_multipliers())
    throw std::invalid_argument("snes_type is '" + method() +
                                "': Lagrange multipliers need the package's own method, snes_type 'shell'; or take "
                                "Penalty");
  check(SNESMonitorSet(_snes, &IncrementSolver::monitor, this, nullptr), "a solver is made");
}

IncrementSolver::~IncrementSolver()
{
  operators::let_go(PetscObject(_J));
  operators::let_go(PetscObject(_F));
  operators::let_go(PetscObject(_x));
  operators::let_go(PetscObject(_snes));
}

void IncrementSolver::free()
{
  check(MatDestroy(&_J), "a matrix is destroyed");
  check(SNESDestroy(&_snes), "a solver is destroyed");
  check(VecDestroy(&_F), "a vector is destroyed");
  check(VecDestroy(&_x), "a vector is destroyed");
}

std::unique_ptr<Newton> IncrementSolver::make_newton() const
{
  NewtonEvents events = _events;
  // SNES's monitors are told of the iterations first, so that its options act on the package's own method.
  events.iteration = [snes = _snes, then = _events.iteration](int iteration, double norm, double scale,
                                                              std::int64_t size, std::int64_t changes)
  {
    check(SNESMonitor(snes, iteration, norm), "an iteration is monitored");
    if (then)
      then(iteration, norm, scale, size, changes);
  };
  return std::make_unique<Newton>(_problem, _options, std::move(events));
}

std::string IncrementSolver::method() const
{
  SNESType type = nullptr;
  check(SNESGetType(_snes, &type), "a solver is asked for its type");
  return type ? type : "";
}

bool IncrementSolver::own() const
{
  return method() == SNESSHELL;
}

void IncrementSolver::forget()
{
  const SolveSeconds seconds = _newton->seconds;
  _newton = make_newton();
  _newton->seconds = seconds;
  if (!_J)
    return;
  check(MatDestroy(&_J), "a matrix is destroyed");
  KSP ksp = nullptr;
  check(SNESGetKSP(_snes, &ksp), "a solver is asked for its linear solver");
  check(KSPReset(ksp), "a linear solver is reset");
}

void IncrementSolver::tell_nobody()
{
  _events = {};
  _newton->events = {};
}

Increment IncrementSolver::run(std::span<const double> target)
{
  if (!own())
    return run_other(target);
  _target = target;
  _result = {};
  copy_from_u();
  call_petsc();
  return _result;
}

template <typename F>
PetscErrorCode IncrementSolver::kept(const F& act)
{
  try
  {
    act();
    return PETSC_SUCCESS;
  }
  catch (...)
  {
    _thrown = std::current_exception();
    return PETSC_ERR_USER;
  }
}

/// Call SNESSolve, and throw what functions that PETSc has called have thrown. Collective.
void IncrementSolver::call_petsc()
{
  _thrown = nullptr;
  std::optional<operators::PetscErrorText> error; // the package's own method returns no errors to PETSc
  if (!own())
    error.emplace();
  const PetscErrorCode code = SNESSolve(_snes, nullptr, _x);
  if (_thrown)
    std::rethrow_exception(std::exchange(_thrown, nullptr));
  if (code)
    throw std::runtime_error("SNES of type " + method() + " has failed" + (error ? ": " + error->text() : ""));
}

/// The package's own method, for SNES of type "shell". What it throws is no error for PETSc, whose handlers would tell
/// it in their own words.
PetscErrorCode IncrementSolver::solve_own(SNES snes, Vec x)
{
  void* context = nullptr;
  PetscCall(SNESShellGetContext(snes, &context));
  auto& self = *static_cast<IncrementSolver*>(context);
  const PetscErrorCode code = self.kept(
      [&]
      {
        self._result = self._newton->run(self._target);
        operators::Entries values(x);
        std::copy_n(self._problem->u->x()->array().begin(), values.size(), &values[0]);
        const bool converged = self._result.fault.empty();
        check(SNESSetIterationNumber(snes, self._result.iterations), "iterations are counted");
        check(SNESSetConvergedReason(snes, converged ? SNES_CONVERGED_FNORM_RELATIVE : SNES_DIVERGED_MAX_IT),
              "convergence is told");
      });
  return code ? SNESSetConvergedReason(snes, SNES_DIVERGED_FUNCTION_DOMAIN) : PETSC_SUCCESS;
}

// --- PETSc's methods -------------------------------------------------------------------------------------------------

void IncrementSolver::copy_from_u()
{
  operators::Entries values(_x);
  std::copy_n(_problem->u->x()->array().begin(), values.size(), &values[0]);
}

void IncrementSolver::copy_to_u(Vec x)
{
  const double* values = nullptr;
  check(VecGetArrayRead(x, &values), "a vector is read");
  std::copy_n(values, _problem->num_owned(), common::array(*_problem->u->x()).begin());
  check(VecRestoreArrayRead(x, &values), "a vector is read");
  _problem->u->x()->scatter_fwd();
}

/// Internal minus external and contact forces at the present displacements, owned [F]. Contacts are updated, and
/// changes of their status counted. Collective.
std::vector<double> IncrementSolver::residual()
{
  Vec b = _problem->body->residual();
  for (const auto& contact : _problem->contacts)
  {
    contact->update_gap(_problem->u->x()->array());
    contact->add_residual(b);
    _changes += contact->update_active_set(false);
  }
  return operators::values_of(b, _problem->num_owned());
}

PetscErrorCode IncrementSolver::evaluate(SNES, Vec x, Vec F, void* context)
{
  auto& self = *static_cast<IncrementSolver*>(context);
  return self.kept(
      [&]
      {
        self.copy_to_u(x);
        std::vector<double> residual = self.residual();
        for (std::int32_t dof : self._newton->prescribed())
          residual[dof] = 0.0; // prescribed values are there already
        operators::Entries values(F);
        std::ranges::copy(residual, &values[0]);
      });
}

/// Assemble the tangent at x, which need not be where PETSc has evaluated the function last. Collective.
PetscErrorCode IncrementSolver::linearise(SNES snes, Vec x, Mat J, Mat, void* context)
{
  auto& self = *static_cast<IncrementSolver*>(context);
  const EquilibriumProblem& p = *self._problem;
  return self.kept(
      [&]
      {
        self.copy_to_u(x);
        self.residual();
        Mat K = p.body->tangent();
        check(MatZeroEntries(J), "a matrix is assembled");
        check(MatAXPY(J, 1.0, K, SUBSET_NONZERO_PATTERN), "a matrix is assembled");
        for (const auto& contact : p.contacts)
          if (Mat T = contact->tangent())
            check(MatAXPY(J, 1.0, T, DIFFERENT_NONZERO_PATTERN), "a matrix is assembled");
        Vec diagonal = make_vector(p.comm(), p.num_owned());
        double sum = 0.0;
        PetscInt size = 0, first = 0;
        check(MatGetDiagonal(K, diagonal), "a matrix is read");
        check(VecSum(diagonal, &sum), "a vector is summed up");
        check(VecGetSize(diagonal, &size), "a vector is asked for its size");
        check(VecDestroy(&diagonal), "a vector is destroyed");
        check(MatGetOwnershipRange(J, &first, nullptr), "a matrix is asked for its rows");
        std::vector<PetscInt> rows;
        for (std::int32_t dof : self._newton->prescribed())
          rows.push_back(first + dof);
        const double mean = sum != 0.0 ? sum / double(size) : 1.0;
        check(MatZeroRowsColumns(J, PetscInt(rows.size()), rows.data(), mean, nullptr, nullptr),
              "prescribed displacements are set");
        if (!p.contacts.empty()) // PETSc does not always notice that the sparsity pattern has changed
        {
          KSP ksp = nullptr;
          PC pc = nullptr;
          check(SNESGetKSP(snes, &ksp), "a solver is asked for its linear solver");
          check(KSPGetPC(ksp, &pc), "a linear solver is asked for its preconditioner");
          check(PCReset(pc), "a preconditioner is reset");
        }
        p.linear_solver->set_near_nullspace(J);
      });
}

PetscErrorCode IncrementSolver::monitor(SNES, PetscInt iteration, PetscReal norm, void* context)
{
  auto& self = *static_cast<IncrementSolver*>(context);
  return self.kept(
      [&]
      {
        std::int64_t size = 0;
        for (const auto& contact : self._problem->contacts)
          size += contact->num_active();
        const std::int64_t changes = std::exchange(self._changes, 0);
        self._result.add(norm, size, changes);
        if (self._events.iteration)
          self._events.iteration(int(iteration), norm, self._scale, size, changes);
      });
}

/// Solve an increment by a method of PETSc's: a linear step to the prescribed values, then its iterations. Collective.
Increment IncrementSolver::run_other(std::span<const double> target)
{
  const EquilibriumProblem& p = *_problem;
  Newton& newton = *_newton;
  _result = {};
  _changes = 0;
  std::vector<double> forces = residual();
  Mat K = p.body->tangent();
  if (!p.contacts.empty())
    if (const std::string loose = newton.unconstrained_modes(K); !loose.empty())
      return _result.failed(loose, true);
  if (!_J)
  {
    check(MatDuplicate(K, MAT_COPY_VALUES, &_J), "a matrix is copied");
    check(MatSetOption(_J, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE), "a matrix is copied");
    check(SNESSetJacobian(_snes, _J, _J, &IncrementSolver::linearise, this), "a solver is made");
  }
  const double first = std::max(newton.norm(forces), newton.tangent_force(K));
  const std::span<double> u = common::array(*p.u->x());
  std::vector<double> jump;
  for (std::int32_t dof : newton.prescribed())
    jump.push_back(target[dof] - u[dof]);
  if (const auto step = newton.solve_linearised(K, std::move(forces), jump, linear_step); !step.fault.empty())
    return _result.failed("the linear solver failed (" + step.fault + "): is the body held against rigid motion?");
  for (std::size_t i = 0; i < u.size(); ++i)
    if (p.fixed[i])
      u[i] = target[i];
  // The forces of the linear step may be those of a state far away: where PETSc's method ends they are found anew.
  const auto tolerance_here = [&]
  {
    forces = residual(); // with the support forces
    K = p.body->tangent();
    _scale = std::max({first, newton.norm(forces), newton.tangent_force(K)});
    return std::max({_options.atol, newton.round_off(K), _options.rtol * _scale});
  };
  for (int round = 0;; ++round)
  {
    double tolerance = tolerance_here();
    check(SNESSetTolerances(_snes, tolerance, 0.0, _step_tolerance, _options.max_iterations, _max_evaluations),
          "tolerances are set");
    copy_from_u();
    call_petsc();
    copy_to_u(_x);
    const double demanded = tolerance;
    tolerance = tolerance_here();
    for (std::int32_t dof : newton.prescribed())
      forces[dof] = 0.0;
    const bool loose = tolerance < demanded && newton.norm(forces) > tolerance && round < most_rounds;
    PetscInt iterations = 0;
    check(SNESGetIterationNumber(_snes, &iterations), "iterations are counted");
    _result.iterations += int(iterations);
    if (const std::string unsolved = p.body->fault(); !unsolved.empty())
      return _result.failed(unsolved);
    SNESConvergedReason reason{};
    check(SNESGetConvergedReason(_snes, &reason), "convergence is asked for");
    if (reason < 0)
      return _result.failed("SNES of type " + method() + " did not converge: PETSc reason " +
                            std::to_string(int(reason)));
    if (loose)
      continue;
    bool again = false;
    std::vector<std::string> faults;
    for (const auto& contact : p.contacts)
      again = contact->augment() || again;
    for (const auto& contact : p.contacts)
      faults.push_back(contact->fault());
    if (const std::string text = common::joined(faults); !text.empty())
      return _result.failed(text, true);
    if (again)
      continue;
    const std::vector<double> bodies = operators::values_of(p.body->residual(), p.num_owned());
    if (!newton.fields_balance(K, bodies))
      return _result.failed(
          "SNES of type " + method() +
              " has converged in one norm of all fields, in which the equation of one does not hold yet: take the "
              "package's own method (leave out snes_type)",
          true);
    const double last = _result.residual_norms.empty() ? 0.0 : _result.residual_norms.back();
    if (const auto missing = out_of_balance(p, bodies, std::max(tolerance, last)))
      return _result.failed(missing->text, true);
    ++_result.iterations; // the linear step to the prescribed values
    return _result.converged();
  }
}
} // namespace dolfinx_impact::solve
