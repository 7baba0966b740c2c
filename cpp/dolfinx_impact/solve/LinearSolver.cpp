// SPDX-License-Identifier: MIT
#include "LinearSolver.h"
#include "../common/text.h"
#include "../operators/PetscErrorText.h"
#include "../operators/petsc_check.h"
#include "OtherPins.h"
#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <sstream>
#include <stdexcept>

using dolfinx_impact::operators::check;
using dolfinx_impact::operators::let_go;

namespace dolfinx_impact::solve
{
namespace
{
typedef LinearSolver::Options Options;

// LU by MUMPS, which counts pivots that are round-off of the largest entries: a body that is free to move has such
// pivots. One iteration with factors of its own matrix, some more with those of an earlier one. Flexible GMRES keeps
// the preconditioned vectors, where GMRES would apply the factors once more to find the solution.
const Options direct_options{{"ksp_type", "fgmres"},
                             {"pc_type", "lu"},
                             {"pc_factor_mat_solver_type", "mumps"},
                             {"mat_mumps_icntl_24", "1"},
                             {"mat_mumps_cntl_3", "1e-14"}};
// Conjugate gradients with smoothed aggregation, which needs the rigid motions as near-nullspace. A sweep of symmetric
// Gauss-Seidel takes two thirds of the time of two with the diagonal (130,000 unknowns in space: 39 iterations of 91 ms
// for ten digits instead of 77 of 69 ms).
const Options cg_options{{"ksp_type", "cg"}, {"ksp_max_it", "500"}};
const Options iterative_options{{"ksp_type", "cg"},
                                {"ksp_max_it", "500"},
                                {"pc_type", "gamg"},
                                {"pc_gamg_threshold", "0.01"},
                                {"mg_levels_ksp_type", "chebyshev"},
                                {"mg_levels_ksp_max_it", "1"},
                                {"mg_levels_pc_type", "sor"}};
// Vectors that GMRES keeps before it begins anew. With PETSc's 30 a wheel on a rail of 235,000 unknowns takes 105
// iterations for three digits instead of 65; they take less memory than the matrix.
constexpr int restart = 100;
// Iterations that cost as much as factors of other packages than MUMPS, which do not tell.
constexpr int worth_of_unknown = 10;
// Iterations that cost as much as a multigrid hierarchy (measured: 330,000 unknowns in space).
constexpr int worth_of_hierarchy = 40;
// Operations of a factorisation run this much faster than those of a solution with the factors (measured: 4.5 on meshes
// of the plane, 5.5 in space).
constexpr double blocked = 5.0;
constexpr int most_work_space = 1000; // beyond what MUMPS foresees [%]
// Columns of released factors: entries of all of them, and how many cost as much as a solution with the factors.
constexpr std::int64_t most_column_entries = 50'000'000;
constexpr std::int64_t columns_per_iteration = 6;
// Unknowns with another pin than in the factors that are left out of these: fewer ones take an iteration each.
constexpr int least_left_out = 100;

/// Options of PETSc's database that begin with a prefix, without it. PETSc tells them all in one text.
Options options_with_prefix(const std::string& prefix)
{
  char* text = nullptr;
  check(PetscOptionsGetAll(nullptr, &text), "options are read");
  std::istringstream words(text ? text : "");
  PetscFree(text);
  Options out;
  std::string word, key;
  const std::string start = "-" + prefix;
  while (words >> word)
  {
    const bool is_key = word.size() > 1 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1]));
    if (is_key)
    {
      // Those of problems have a number behind the prefix.
      const bool ours = word.starts_with(start) && word.size() > start.size() &&
                        !std::isdigit(static_cast<unsigned char>(word[start.size()]));
      key = ours ? word.substr(start.size()) : "";
      if (ours)
        out[key] = "";
    }
    else if (!key.empty())
      out[key] += (out[key].empty() ? "" : " ") + word;
  }
  return out;
}

std::string list_of(const Options& options)
{
  std::string out;
  for (const auto& [key, value] : options)
    out += (out.empty() ? "" : ", ") + key + (value.empty() ? "" : " " + value);
  return out;
}

/// Translations and rotations of all nodes. Collective.
MatNullSpace rigid_motions(const dolfinx::fem::FunctionSpace<double>& V)
{
  const int gdim = V.mesh()->geometry().dim();
  const std::vector<double> x = V.tabulate_dof_coordinates(false);
  const PetscInt num = V.dofmap()->index_map->size_local();
  Vec places = nullptr;
  check(VecCreate(V.mesh()->comm(), &places), "a vector is made");
  check(VecSetSizes(places, gdim * num, PETSC_DETERMINE), "a vector is made");
  check(VecSetBlockSize(places, gdim), "a vector is made");
  check(VecSetType(places, VECSTANDARD), "a vector is made");
  {
    operators::Entries values(places);
    for (PetscInt i = 0; i < num; ++i)
      for (int c = 0; c < gdim; ++c)
        values[i * gdim + c] = x[3 * i + c];
  }
  MatNullSpace out = nullptr;
  check(MatNullSpaceCreateRigidBody(places, &out), "rigid motions are made");
  check(VecDestroy(&places), "a vector is destroyed");
  return out;
}

double norm_of(Vec v)
{
  double out = 0.0;
  check(VecNorm(v, NORM_2, &out), "a norm is taken");
  return out;
}

/// Norm of A x - b.
double residual_norm(LinearSystem& system, Vec b, Vec x)
{
  Vec r = nullptr;
  check(VecDuplicate(b, &r), "a vector is made");
  system.mult(x, r);
  check(VecAXPY(r, -1.0, b), "vectors are added");
  const double out = norm_of(r);
  check(VecDestroy(&r), "a vector is destroyed");
  return out;
}

/// Decimal digits of a tolerance, within sensible bounds.
double digits(double rtol)
{
  return -std::log10(std::min(std::max(rtol, 1e-12), 1e-3));
}
} // namespace

LinearSolver::LinearSolver(const dolfinx::fem::FunctionSpace<double>& V, const Options& options,
                           const std::string& prefix, bool indefinite, LinearSolverLimits limits,
                           std::function<void(const std::string&)> warn)
    : _comm(V.mesh()->comm()), _limits(limits), _warn(std::move(warn)), _product(std::make_unique<Operator>())
{
  if (!_warn)
    _warn = [comm = _comm](const std::string& text) { PetscPrintf(comm, "warning: %s\n", text.c_str()); };
  const std::int64_t size = V.dofmap()->index_map->size_global() * V.dofmap()->index_map_bs();
  // Lines and surfaces have factors as short as meshes of their own dimension.
  const int tdim = V.mesh()->topology()->dim(), gdim = V.mesh()->geometry().dim();
  const bool mixed = V.element()->is_mixed(); // saddle points, or not known to be none
  const Options& preset =
      indefinite || mixed || size <= _limits.largest_direct[tdim] ? direct_options : iterative_options;
  Options chosen = options_with_prefix(prefix);
  chosen.insert(options.begin(), options.end()); // what the command line says takes precedence
  const Options asked = chosen;
  const std::string named = asked.contains("pc_type") ? asked.at("pc_type") : preset.at("pc_type");
  const bool factors = named == "lu" || named == "cholesky";
  Options base = named == preset.at("pc_type") ? preset : factors ? direct_options : cg_options;
  if (mixed && !factors && named != preset.at("pc_type"))
    base["ksp_type"] = "gmres";
  chosen.insert(base.begin(), base.end());
  static int count = 0;
  _prefix = prefix + std::to_string(count++) + "_";
  for (const auto& [key, value] : chosen)
    set_option(key, value);
  for (const auto& [key, value] : asked)
    _asked.push_back(key);
  check(PetscGarbageCleanup(_comm), "memory is given back");
  check(KSPCreate(_comm, &_ksp), "a linear solver is made");
  check(KSPSetOptionsPrefix(_ksp, _prefix.c_str()), "a linear solver is made");
  {
    const operators::PetscErrorText error;
    if (KSPSetFromOptions(_ksp))
    {
      const std::string said = error.text();
      for (const std::string& key : _set)
        PetscOptionsClearValue(nullptr, key.c_str());
      let_go(PetscObject(_ksp));
      throw std::invalid_argument("PETSc does not take the options " + list_of(chosen) + ": " + said);
    }
  }
  if (indefinite && !direct())
    throw std::invalid_argument(
        "pc_type is '" + named +
        "': multipliers with another basis than 'dual', and those of several contacts at the same nodes, stay in a "
        "saddle point, which needs a direct solver (pc_type lu); or take the dual basis, and leave common nodes out of "
        "the tags");
  const int components = V.dofmap()->bs();
  if (components == gdim && V.element()->num_sub_elements() == gdim && !direct())
    _near_nullspace = rigid_motions(V);
  _given_rtol = chosen.contains("ksp_rtol");
  const bool by_size = !asked.contains("ksp_type") && !asked.contains("pc_type");
  _may_factorise = by_size && !direct() && size <= _limits.largest_last_resort[tdim];
  _pins = chosen.at("ksp_type") == "cg";
  // A change of the method forgets its options, so that the user's own length is given again.
  if (_pins)
    _restart = chosen.contains("ksp_gmres_restart") ? std::stoi(chosen.at("ksp_gmres_restart")) : restart;
  // A method of the user's own is taken by the word: no iterations with a preconditioner of an earlier matrix.
  _keeps = chosen.at("ksp_type") == base.at("ksp_type");
  check(KSPGetTolerances(_ksp, nullptr, nullptr, nullptr, &_max_it), "tolerances are read");
  if (_keeps) // the guess may be far worse than none
    check(KSPSetTolerances(_ksp, PETSC_CURRENT, PETSC_CURRENT, 1e30, PETSC_CURRENT), "tolerances are set");
}

LinearSolver::~LinearSolver()
{
  PetscBool over = PETSC_FALSE;
  if (PetscFinalized(&over) || over)
    return;
  _updated.reset();
  _released.reset();
  let_go(PetscObject(_bodies));
  let_go(PetscObject(_shell));
  let_go(PetscObject(_released_shell));
  let_go(PetscObject(_ksp));
  let_go(PetscObject(_operator));
  let_go(PetscObject(_matrix));
  let_go(PetscObject(_near_nullspace));
  for (const std::string& key : _set) // else PETSc reports those never read when it ends
    PetscOptionsClearValue(nullptr, key.c_str());
}

void LinearSolver::set_option(const std::string& key, const std::string& value)
{
  const std::string name = "-" + _prefix + key;
  check(PetscOptionsSetValue(nullptr, name.c_str(), value.empty() ? nullptr : value.c_str()), "an option is set");
  if (!std::ranges::count(_set, name))
    _set.push_back(name);
}

bool LinearSolver::direct() const
{
  PC pc = nullptr;
  PCType type = nullptr;
  check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
  check(PCGetType(pc, &type), "a preconditioner is asked for");
  return type && (!std::strcmp(type, PCLU) || !std::strcmp(type, PCCHOLESKY));
}

bool LinearSolver::uses_mumps() const
{
  if (!direct())
    return false;
  PC pc = nullptr;
  MatSolverType package = nullptr;
  check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
  check(PCFactorGetMatSolverType(pc, &package), "a preconditioner is asked for");
  return package && !std::strcmp(package, MATSOLVERMUMPS);
}

int LinearSolver::reason() const
{
  KSPConvergedReason out = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(_ksp, &out), "a linear solver is asked how it ended");
  return int(out);
}

void LinearSolver::warn_of_unused()
{
  std::string unused;
  for (const std::string& key : _asked)
  {
    PetscBool used = PETSC_FALSE;
    check(PetscOptionsUsed(nullptr, (_prefix + key).c_str(), &used), "options are read");
    if (!used)
      unused += (unused.empty() ? "'" : ", '") + key + "'";
  }
  _asked.clear();
  if (unused.empty())
    return;
  PC pc = nullptr;
  PCType pc_type = nullptr;
  KSPType ksp_type = nullptr;
  check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
  check(PCGetType(pc, &pc_type), "a preconditioner is asked for");
  check(KSPGetType(_ksp, &ksp_type), "a linear solver is asked for");
  _warn("nobody has read the PETSc options [" + unused +
        "]: check how they are written, and whether the solver in use (ksp_type " + ksp_type + ", pc_type " + pc_type +
        ") knows them");
}

void LinearSolver::set_near_nullspace(Mat A) const
{
  if (_near_nullspace)
    check(MatSetNearNullSpace(A, _near_nullspace), "rigid motions are told");
}

void LinearSolver::reset()
{
  forget_matrix();
  _own = 0;
  _spent = 0;
}

void LinearSolver::begin_problem()
{
  _updated.reset(); // columns of another problem's nodes
  _spent = 0;
}

/// Forget the multipliers of the system that the factors were made of. Collective.
void LinearSolver::forget_condensation()
{
  _released.reset();
  _condensation.reset();
  check(MatDestroy(&_bodies), "a matrix is given back");
}

void LinearSolver::forget_matrix()
{
  _updated.reset();
  forget_condensation();
  if (!_matrix)
    return;
  PC pc = nullptr;
  check(MatDestroy(&_matrix), "a matrix is destroyed");
  check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
  check(PCReset(pc), "a preconditioner is reset");
}

std::string LinearSolver::solve(LinearSystem& system, Vec b, Vec x, double rtol)
{
  choose_method(system.symmetric() ? KSPCG : KSPGMRES);
  if (norm_of(b) == 0.0) // from another guess a solver comes near zero, which no relative tolerance takes for an answer
    check(VecSet(x, 0.0), "a vector is set");
  check(KSPSetInitialGuessNonzero(_ksp, _keeps ? PETSC_TRUE : PETSC_FALSE), "a guess is set");
  if (!_given_rtol)
    check(KSPSetTolerances(_ksp, std::pow(10.0, -digits(rtol)), PETSC_CURRENT, PETSC_CURRENT, PETSC_CURRENT),
          "tolerances are set");
  if (_keeps && _matrix && solved(system, b, x, rtol))
    return "";
  if (_keeps && serves(system, rtol))
  {
    run(system, b, x);
    PetscInt iterations = 0;
    check(KSPGetIterationNumber(_ksp, &iterations), "iterations are counted");
    _spent += std::max<int>(int(iterations) - 1, 0);
    if (reason() > 0 && fault(system, b, x).empty())
      return "";
  }
  if (!std::isfinite(norm_of(x)))
    check(VecSet(x, 0.0), "a vector is set");
  prepare(system);
  run(system, b, x);
  while (reason() < 0 && short_of_work_space())
  {
    check(VecSet(x, 0.0), "a vector is set");
    prepare(system);
    run(system, b, x);
  }
  if (_pins && reason() == KSP_DIVERGED_INDEFINITE_PC)
  {
    // Where the stiffness jumps by orders of magnitude and a material is nearly incompressible, multigrid may be
    // indefinite. Conjugate gradients end there; GMRES goes on with it.
    choose_method(KSPGMRES);
    run(system, b, x);
  }
  std::string found = fault(system, b, x);
  if (!found.empty() && !direct() && !_given_rtol)
  {
    // Preconditioned residuals say little where a body hangs on a few points: once more, and to the end.
    check(KSPSetTolerances(_ksp, 1e-10, PETSC_CURRENT, PETSC_CURRENT, PETSC_CURRENT), "tolerances are set");
    run(system, b, x);
    found = fault(system, b, x);
  }
  judge(rtol);
  if (!found.empty() && _may_factorise && std::isfinite(norm_of(b)))
  {
    factorise(found);
    check(VecSet(x, 0.0), "a vector is set");
    return solve(system, b, x, rtol);
  }
  return found;
}

/// From now on solve by factors: the iterations that were chosen by size do not converge. Collective.
void LinearSolver::factorise(const std::string& fault)
{
  _warn("conjugate gradients with multigrid do not solve the linear system (" + fault +
        "): it is factorised, as those that follow are, which takes more memory and time; options choose another "
        "solver");
  _may_factorise = _pins = false;
  check(MatNullSpaceDestroy(&_near_nullspace), "rigid motions are forgotten");
  reset();
  for (const auto& [key, value] : direct_options)
    set_option(key, value);
  check(KSPReset(_ksp), "a linear solver is reset");
  check(KSPSetFromOptions(_ksp), "options of a linear solver are read");
  check(KSPSetNormType(_ksp, KSP_NORM_DEFAULT), "a norm is chosen");
}

/// Set the Krylov method where it is not the user's own, and how its residuals are measured.
void LinearSolver::choose_method(const char* method)
{
  if (_pins)
    check(KSPSetType(_ksp, method), "a linear solver is chosen");
  KSPType type = nullptr;
  check(KSPGetType(_ksp, &type), "a linear solver is asked for");
  // Residuals as they are: preconditioned ones are all displacement where a body hangs on a few points.
  if (!std::strcmp(type, KSPGMRES) || !std::strcmp(type, KSPFGMRES))
  {
    if (_restart)
      check(KSPGMRESSetRestart(_ksp, _restart), "a linear solver is chosen");
    check(KSPSetPCSide(_ksp, PC_RIGHT), "a linear solver is chosen");
  }
  else if (!std::strcmp(type, KSPCG))
  {
    check(KSPSetPCSide(_ksp, PC_LEFT), "a linear solver is chosen");
    check(KSPSetNormType(_ksp, KSP_NORM_UNPRECONDITIONED), "a norm is chosen");
  }
}

Mat LinearSolver::factors(const LinearSystem& system) const
{
  return _own == system.id() ? factors() : nullptr;
}

Mat LinearSolver::factors() const
{
  if (!direct() || !_keeps || !_matrix)
    return nullptr;
  PC pc = nullptr;
  Mat out = nullptr;
  check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
  check(PCFactorGetMatrix(pc, &out), "factors are asked for");
  return out;
}

/// Is the guess good enough? Collective.
bool LinearSolver::solved(LinearSystem& system, Vec b, Vec x, double rtol) const
{
  return residual_norm(system, b, x) <= std::pow(10.0, -digits(rtol)) * norm_of(b);
}

/// May the earlier preconditioner be tried? Sets how many iterations it may take. Collective. At a time it may spend as
/// much as a new one costs, in all twice that.
bool LinearSolver::serves(LinearSystem& system, double rtol)
{
  if (!_matrix || !_limits.keep_preconditioner)
    return false;
  if (_own == system.id()) // new factors would be the same
  {
    check(KSPSetTolerances(_ksp, PETSC_CURRENT, PETSC_CURRENT, PETSC_CURRENT, _max_it), "tolerances are set");
    return true;
  }
  const int worth = direct() ? _worth : int(_pace * digits(rtol)) + worth_of_hierarchy;
  int left = direct() ? std::min(worth, 2 * worth - _spent) : worth;
  if (_limits.patience > 0)
    left = _limits.patience;
  // With factors, every unknown that was pinned and is not, or the other way round, takes an iteration at least. A
  // hierarchy takes hundreds of them in a patch with a dozen more iterations (measured: 330,000 unknowns in space, 618
  // nodes, 33 iterations instead of 21), and making a new one takes as long as 40.
  if (direct())
  {
    int other_size = system.pinned().size() != _pinned.size();
    MPI_Allreduce(MPI_IN_PLACE, &other_size, 1, MPI_INT, MPI_MAX, _comm);
    if (other_size)
      return false;
    if (may_release(system))
    {
      if (!select_released(system, left))
        return false;
    }
    else
    {
      _num_other_pins = num_other_pins(system, _pinned, false);
      const std::int64_t differ = uses_updated(system) ? _updated->num_missing() : _num_other_pins;
      if (differ >= left && (uses_updated(system) || num_other_pins(system, _pinned, true) >= left))
        return false;
    }
  }
  check(KSPSetTolerances(_ksp, PETSC_CURRENT, PETSC_CURRENT, PETSC_CURRENT, left), "tolerances are set");
  return true;
}

/// Unknowns of all ranks that are pinned either in one of two systems of the same size or in the other. Collective.
/// @param[in] pinned unknowns of the system that the preconditioner was made of
/// @param[in] coupled only those that are free now, or whose equations have free unknowns: a body that is pinned as a
/// whole takes no iterations
std::int64_t LinearSolver::num_other_pins(const LinearSystem& system, std::span<const std::int8_t> pinned,
                                          bool coupled) const
{
  const std::span<const std::int8_t> now = system.pinned();
  std::vector<double> reached(now.size(), 1.0);
  PetscInt rows = 0;
  check(MatGetLocalSize(system.K(), &rows, nullptr), "a matrix is asked for its size");
  int without_rows = std::size_t(rows) != now.size(); // of multipliers
  MPI_Allreduce(MPI_IN_PLACE, &without_rows, 1, MPI_INT, MPI_MAX, _comm);
  if (coupled && !without_rows)
  {
    Vec free = nullptr, product = nullptr;
    check(MatCreateVecs(system.K(), &free, &product), "vectors are made");
    {
      // Numbers that do not cancel in a row, as those of a rigid motion would.
      constexpr double golden = 0.6180339887498949;
      operators::Entries values(free);
      for (std::size_t i = 0; i < now.size(); ++i)
        values[i] = now[i] ? 0.0 : 0.5 + std::fmod(golden * double(i), 1.0);
    }
    check(MatMult(system.K(), free, product), "a matrix is multiplied");
    reached = operators::values_of(product);
    for (Vec* v : {&free, &product})
      check(VecDestroy(v), "a vector is destroyed");
  }
  std::int64_t out = 0;
  for (std::size_t i = 0; i < now.size(); ++i)
    out += bool(now[i]) != bool(pinned[i]) && (!now[i] || reached[i] != 0.0);
  MPI_Allreduce(MPI_IN_PLACE, &out, 1, MPI_INT64_T, MPI_SUM, _comm);
  return out;
}

/// How long the preconditioner that has just solved its own system may serve others.
void LinearSolver::judge(double rtol)
{
  _spent = 0;
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(_ksp, &iterations), "iterations are counted");
  _pace = double(std::max<PetscInt>(iterations, 1)) / digits(rtol);
  _worth = worth_of_factors();
}

/// Iterations that cost as much as the present factors did.
int LinearSolver::worth_of_factors() const
{
  if (!_keeps || !uses_mumps())
    return worth_of_unknown;
  PC pc = nullptr;
  Mat F = nullptr;
  PetscInt told = 0;
  double operations = 0.0;
  check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
  check(PCFactorGetMatrix(pc, &F), "factors are asked for");
  check(MatMumpsGetInfog(F, 29, &told), "MUMPS is asked for the size of its factors");
  check(MatMumpsGetRinfog(F, 3, &operations), "MUMPS is asked for its operations");
  const double entries = told > 0 ? double(told) : -1e6 * double(told); // large numbers are told in millions
  const double worth = operations / (4.0 * entries) / blocked;
  return std::isfinite(worth) ? int(worth) : 0;
}

void LinearSolver::set_up(LinearSystem& system)
{
  choose_method(system.symmetric() ? KSPCG : KSPGMRES);
  do
  {
    prepare(system);
    set_operators(system);
    check(KSPSetUp(_ksp), "a preconditioner is made");
  } while (short_of_work_space());
  PC pc = nullptr;
  check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
  check(PCSetReusePreconditioner(pc, PETSC_TRUE), "a preconditioner is kept");
  _spent = 0;
  if (direct())
    _worth = worth_of_factors();
}

/// Preconditioner of the present system. Collective.
void LinearSolver::prepare(LinearSystem& system)
{
  forget_matrix();
  _matrix = system.assemble();
  set_near_nullspace(_matrix);
  check(KSPSetTolerances(_ksp, PETSC_CURRENT, PETSC_CURRENT, PETSC_CURRENT, _max_it), "tolerances are set");
  PC pc = nullptr;
  check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
  check(PCSetReusePreconditioner(pc, PETSC_FALSE), "a preconditioner is made");
  ++_num_set_ups;
  _pinned.assign(system.pinned().begin(), system.pinned().end());
  _own = system.id();
  if (const auto* const condensed = dynamic_cast<const CondensedSystem*>(&system);
      condensed && condensed->shared_condensation() &&
      ReleasedFactors::num_columns(_comm, *condensed->shared_condensation()) > 0)
  {
    _condensation = condensed->shared_condensation();
    _bodies = system.K();
    check(PetscObjectReference(PetscObject(_bodies)), "a matrix is kept");
  }
}

/// Has MUMPS ended because pivots that it put off took more memory than it had foreseen? Then ask for more. Small
/// indefinite matrices do that. Collective.
bool LinearSolver::short_of_work_space()
{
  if (!uses_mumps())
    return false;
  const std::string key = "mat_mumps_icntl_14";
  PetscInt given = 20, status = 0;
  check(PetscOptionsGetInt(nullptr, _prefix.c_str(), ("-" + key).c_str(), &given, nullptr), "an option is read");
  PC pc = nullptr;
  Mat F = nullptr;
  check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
  check(PCFactorGetMatrix(pc, &F), "factors are asked for");
  check(MatMumpsGetInfog(F, 1, &status), "MUMPS is asked how it ended");
  if ((status != -8 && status != -9) || given >= most_work_space)
    return false;
  set_option(key, std::to_string(4 * given));
  return true;
}

PetscErrorCode LinearSolver::multiply(Mat A, Vec x, Vec y)
{
  Operator* self = nullptr;
  PetscFunctionBeginUser;
  PetscCall(MatShellGetContext(A, &self));
  try
  {
    self->system->mult(x, y);
  }
  catch (const std::exception& error) // it must not pass through PETSc's C
  {
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_LIB, "%s", error.what());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

template <auto factors>
PetscErrorCode LinearSolver::apply(PC pc, Vec r, Vec z)
{
  void* context = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &context));
  try
  {
    (static_cast<const LinearSolver*>(context)->*factors)->apply(r, z);
  }
  catch (const std::exception& error) // it must not pass through PETSc's C
  {
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_LIB, "%s", error.what());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Are the factors those of bodies that multipliers press together, and has this system none? The same on all ranks.
bool LinearSolver::may_release(const LinearSystem& system) const
{
  const auto* const condensed = dynamic_cast<const CondensedSystem*>(&system);
  return _condensation && _condensation->symmetric() && uses_mumps() && condensed && !condensed->shared_condensation();
}

/// Are there released factors for this system?
bool LinearSolver::releases(const LinearSystem& system) const
{
  return _released && _own != system.id() && _released->serves(system);
}

/// Release the conditions of the factors for a system without multipliers. Collective.
/// @param[in] left iterations that they may take
/// @returns whether they may serve: no unknown was pinned in the factors that is free now, and few have been pinned
/// since whose equations have free unknowns
bool LinearSolver::select_released(LinearSystem& system, int left)
{
  std::vector<std::int8_t> supported(_pinned);
  int freed = 0;
  for (std::size_t i = 0; i < supported.size(); ++i)
  {
    supported[i] = _pinned[i] && !_condensation->pinned()[i];
    freed = freed || (supported[i] && !system.pinned()[i]);
  }
  MPI_Allreduce(MPI_IN_PLACE, &freed, 1, MPI_INT, MPI_MAX, _comm);
  if (freed || num_other_pins(system, supported, true) >= left)
    return false;
  if (!_released)
  {
    const std::int64_t columns = ReleasedFactors::num_columns(_comm, *_condensation);
    PetscInt rows = 0;
    check(MatGetSize(_matrix, &rows, nullptr), "a matrix is asked for its size");
    // Solutions with many right sides take a sixth of the time of single ones.
    if (columns * std::int64_t(rows) > most_column_entries || columns > columns_per_iteration * std::int64_t(left))
      return false;
    _released = std::make_unique<ReleasedFactors>(factors(), _condensation, _pinned, _bodies);
    check(MatDestroy(&_bodies), "a matrix is given back");
  }
  return _released->select(dynamic_cast<CondensedSystem&>(system));
}

/// Are there factors that were updated for this system?
bool LinearSolver::uses_updated(const LinearSystem& system) const
{
  return _updated && _own != system.id() && _updated->serves(system);
}

/// Are the unknowns left out of an earlier preconditioner that are pinned in one of the two systems alone? Of factors
/// only where they are many, as those of a body: a few take an iteration each, and motions of bodies that hang on them
/// are better in the factors.
bool LinearSolver::leaves_out_pins(const LinearSystem& system) const
{
  return !direct() || (_num_other_pins >= least_left_out && system.pinned().size() == _pinned.size());
}

/// Products with a system, preconditioned by the present matrix. Collective.
void LinearSolver::set_operators(LinearSystem& system)
{
  if (!_operator)
  {
    PC pc = nullptr;
    PetscInt size = 0;
    check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
    check(MatGetLocalSize(_matrix, &size, nullptr), "a matrix is asked for its size");
    check(MatCreateShell(_comm, size, size, PETSC_DETERMINE, PETSC_DETERMINE, _product.get(), &_operator),
          "an operator is made");
    check(MatShellSetOperation(_operator, MATOP_MULT, reinterpret_cast<void (*)()>(&LinearSolver::multiply)),
          "an operator is made");
    check(PCSetUseAmat(pc, PETSC_FALSE), "a preconditioner is made");
  }
  _product->system = &system;
  check(KSPSetOperators(_ksp, _operator, _matrix), "operators are set");
}

/// Solve with the present preconditioner. Collective.
void LinearSolver::run(LinearSystem& system, Vec b, Vec x)
{
  PC pc = nullptr;
  check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
  check(PetscObjectReference(PetscObject(pc)), "a preconditioner is kept");
  std::optional<OtherPins> others;
  const auto choose_shell = [&](PC& shell, PetscErrorCode (*apply)(PC, Vec, Vec))
  {
    if (!shell)
    {
      check(PCCreate(_comm, &shell), "a preconditioner is made");
      check(PCSetType(shell, PCSHELL), "a preconditioner is made");
      check(PCShellSetContext(shell, this), "a preconditioner is made");
      check(PCShellSetApply(shell, apply), "a preconditioner is made");
    }
    check(KSPSetPC(_ksp, shell), "a preconditioner is chosen");
  };
  if (uses_updated(system))
    choose_shell(_shell, &LinearSolver::apply<&LinearSolver::_updated>);
  else if (releases(system))
    choose_shell(_released_shell, &LinearSolver::apply<&LinearSolver::_released>);
  else if (const auto* const condensed = dynamic_cast<const CondensedSystem*>(&system);
           condensed && _own != system.id() && leaves_out_pins(system))
  {
    others.emplace(pc, *condensed, _pinned);
    check(KSPSetPC(_ksp, others->pc()), "a preconditioner is chosen");
  }
  set_operators(system);
  check(KSPSolve(_ksp, b, x), "a linear system is solved");
  check(KSPSetPC(_ksp, pc), "a preconditioner is chosen");
  check(PCDestroy(&pc), "a preconditioner is given back");
  check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
  check(PCSetReusePreconditioner(pc, PETSC_TRUE), "a preconditioner is kept");
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(_ksp, &iterations), "iterations are counted");
  _num_iterations += int(iterations);
}

int LinearSolver::null_pivots() const
{
  if (!_matrix || !uses_mumps())
    return 0;
  PC pc = nullptr;
  Mat F = nullptr;
  PetscInt out = 0;
  check(KSPGetPC(_ksp, &pc), "a preconditioner is asked for");
  check(PCFactorGetMatrix(pc, &F), "factors are asked for");
  check(MatMumpsGetInfog(F, 28, &out), "MUMPS is asked for pivots");
  return int(out);
}

/// What is wrong with a solution; empty if nothing is. Collective.
std::string LinearSolver::fault(LinearSystem& system, Vec b, Vec x) const
{
  if (reason() < 0)
    return "PETSc reason " + std::to_string(reason());
  if (const int vanishing = null_pivots(); vanishing > 0)
    return std::to_string(vanishing) + " pivots vanish";
  const double error = residual_norm(system, b, x), right = norm_of(b); // not the solver's own word for it
  // Far from any solver's tolerance: a nearly singular matrix, whose solution is round-off.
  if (error <= 2e-2 * right)
    return "";
  return "the residual of the linear system is " + common::text("%.1e", error) + ", its right side " +
         common::text("%.1e", right);
}
} // namespace dolfinx_impact::solve
