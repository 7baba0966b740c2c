// SPDX-License-Identifier: MIT
#pragma once
#include "LinearSystem.h"
#include "ReleasedFactors.h"
#include "UpdatedFactors.h"
#include <array>
#include <dolfinx/fem/FunctionSpace.h>
#include <functional>
#include <map>
#include <memory>
#include <petscksp.h>
#include <string>
#include <vector>

namespace dolfinx_impact::solve
{
/// Which systems are factorised, by the topological dimension of the mesh, and whether factors are kept.
struct LinearSolverLimits
{
  /// Above these numbers of unknowns factors cost more than iterations (measured: 108,000 unknowns in space,
  /// factorisation 10 s, conjugate gradients 3 s). Factors of lines are band matrices, at any size.
  std::array<std::int64_t, 4> largest_direct{0, 4'000'000, 400'000, 40'000};
  /// Up to these numbers of unknowns a system whose iterations do not converge is factorised after all. Factors in
  /// space take some 2 GB at 200,000 unknowns, and grow with the power 4/3.
  std::array<std::int64_t, 4> largest_last_resort{0, 4'000'000, 4'000'000, 400'000};
  /// Factors and hierarchies serve later systems as long as they need few iterations.
  bool keep_preconditioner = true;
  /// Iterations that factors of an earlier system may take for a solution; 0: as many as cost as much as new ones. For
  /// systems whose factors are not their own, and factors that more than solutions are made of.
  int patience = 0;
};

/// A KSP of PETSc with options of its own: chosen by size, its factors (or multigrid hierarchy) kept while they serve,
/// every solution checked.
class LinearSolver
{
public:
  typedef std::map<std::string, std::string> Options;

  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] options PETSc options without prefix; without any the method is chosen by size
  /// @param[in] prefix what the command line says of it goes first; a number is added to it, so that the options of one
  /// problem are not those of the next
  /// @param[in] indefinite the systems are saddle points: a direct solver is the default at any size
  /// @param[in] warn is called on all ranks with a sentence; empty: sentences are printed on rank 0
  /// @throws std::invalid_argument for options that PETSc does not take, or that choose an iterative solver for saddle
  /// points
  LinearSolver(const dolfinx::fem::FunctionSpace<double>& V, const Options& options, const std::string& prefix,
               bool indefinite = false, LinearSolverLimits limits = {},
               std::function<void(const std::string&)> warn = {});
  ~LinearSolver();
  LinearSolver(const LinearSolver&) = delete;
  LinearSolver& operator=(const LinearSolver&) = delete;

  /// Solve a linear system. Factors of an earlier system serve as preconditioner as long as that needs few iterations;
  /// then the present one is factorised. Collective.
  /// @param[in,out] x a guess, becomes the solution
  /// @param[in] rtol of the residual, for tolerances that the options do not set [1]
  /// @returns what is wrong with the solution; empty if nothing is
  std::string solve(LinearSystem& system, Vec b, Vec x, double rtol = 1e-10);
  /// Make the preconditioner of a system now: the next solution does not look for an earlier one. Collective.
  void set_up(LinearSystem& system);
  /// Factors of the system that was factorised last; null if there are none.
  Mat factors() const;
  /// Factors of a system, if it is the one that was factorised last; else null.
  Mat factors(const LinearSystem& system) const;
  /// Pivots of these factors that are round-off: motions that nothing resists. Zero if the solver does not count them.
  int null_pivots() const;
  /// Take factors that are updated for other active sets: they go as the factors go. A system for which they are
  /// selected is solved with them.
  void set_updated(std::unique_ptr<UpdatedFactors> updated) { _updated = std::move(updated); }
  /// Those factors; null if there are none.
  UpdatedFactors* updated() { return _updated.get(); }
  /// Keep the preconditioner, and forget what it has served for: from here on solutions depend on nothing else that
  /// came before. For another problem of the same bodies.
  void begin_problem();
  /// Forget the preconditioner and give back its memory: the next solution does not depend on earlier systems.
  /// Collective.
  void reset();
  /// Does it factorise?
  bool direct() const;
  /// After a solution: warn, once, of options that were asked for and that nobody has read.
  void warn_of_unused();
  /// Set the rigid motions as near-nullspace of a matrix, if preconditioners need it. Collective.
  void set_near_nullspace(Mat A) const;

  KSP ksp() const { return _ksp; }
  /// Prefix of its options.
  const std::string& prefix() const { return _prefix; }
  /// Preconditioners made so far, and iterations of all solutions.
  int num_set_ups() const { return _num_set_ups; }
  int num_iterations() const { return _num_iterations; }

private:
  struct Operator
  {
    LinearSystem* system = nullptr; ///< that products are taken with
  };
  static PetscErrorCode multiply(Mat A, Vec x, Vec y);
  template <auto factors>
  static PetscErrorCode apply(PC pc, Vec r, Vec z);

  void set_option(const std::string& key, const std::string& value);
  void forget_matrix();
  void choose_method(const char* method);
  bool uses_updated(const LinearSystem& system) const;
  bool leaves_out_pins(const LinearSystem& system) const;
  bool releases(const LinearSystem& system) const;
  bool may_release(const LinearSystem& system) const;
  bool select_released(LinearSystem& system, int left);
  void forget_condensation();
  bool solved(LinearSystem& system, Vec b, Vec x, double rtol) const;
  bool serves(LinearSystem& system, double rtol);
  std::int64_t num_other_pins(const LinearSystem& system, std::span<const std::int8_t> pinned, bool coupled) const;
  void judge(double rtol);
  int worth_of_factors() const;
  void prepare(LinearSystem& system);
  void set_operators(LinearSystem& system);
  bool short_of_work_space();
  void run(LinearSystem& system, Vec b, Vec x);
  std::string fault(LinearSystem& system, Vec b, Vec x) const;
  void factorise(const std::string& fault);
  bool uses_mumps() const;
  int reason() const;

  MPI_Comm _comm;
  LinearSolverLimits _limits;
  std::function<void(const std::string&)> _warn;
  std::string _prefix;
  KSP _ksp = nullptr;
  MatNullSpace _near_nullspace = nullptr; ///< of preconditioners; null for direct solvers
  Mat _operator = nullptr;                ///< products with the present system; one for all
  std::unique_ptr<Operator> _product;     ///< its context
  Mat _matrix = nullptr;                  ///< that the preconditioner was made of
  std::unique_ptr<UpdatedFactors> _updated;
  /// Of the system that the factors were made of; null: it had no multipliers.
  std::shared_ptr<enforcement::Condensation> _condensation;
  Mat _bodies = nullptr; ///< stiffness of that system, until it has been read for `_released`
  std::unique_ptr<ReleasedFactors> _released;
  PC _shell = nullptr;              ///< applies updated factors
  PC _released_shell = nullptr;     ///< applies released factors
  std::uint64_t _own = 0;           ///< number of the system that it was made of
  std::vector<std::int8_t> _pinned; ///< of that system
  std::int64_t _num_other_pins = 0; ///< unknowns of all ranks pinned either there or in the present system, not in both
  std::vector<std::string> _set;    ///< options in PETSc's database
  std::vector<std::string> _asked;  ///< keys of those that were asked for
  bool _given_rtol = false, _may_factorise = false, _pins = false, _keeps = true;
  int _restart = 0;
  PetscInt _max_it = 0;
  double _pace = 1.0;         ///< iterations per digit
  int _worth = 0, _spent = 0; ///< iterations that new factors cost, and that the present ones have taken
  int _num_set_ups = 0, _num_iterations = 0;
};
} // namespace dolfinx_impact::solve
