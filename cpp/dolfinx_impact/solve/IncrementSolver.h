// SPDX-License-Identifier: MIT
#pragma once
#include "Newton.h"
#include <exception>
#include <memory>
#include <petscsnes.h>
#include <span>
#include <string>

namespace dolfinx_impact::solve
{
/// Solves the increments of a problem by the SNES that PETSc's options choose, with the prefix of its linear solver.
///
/// By default it is the package's own Newton's method, which updates active sets: SNES's type "shell", or "python".
/// Without contact and with contact by penalty the equations are smooth enough for PETSc's methods, too: newtonls,
/// newtontr, ngmres, ... Tolerances, largest number of iterations and monitors are SNES's with any method.
class IncrementSolver
{
public:
  /// Collective.
  /// @param[in] options of Newton's method; -snes_rtol, -snes_atol, -snes_max_it and what NewtonOptions::with_database
  /// reads take precedence
  /// @param[in] events whom the solver tells what it does
  /// @throws std::invalid_argument for options that PETSc does not take, or another method than the package's own for a
  /// problem with multipliers
  IncrementSolver(std::shared_ptr<const EquilibriumProblem> problem, const NewtonOptions& options,
                  NewtonEvents events = {});
  ~IncrementSolver();
  IncrementSolver(const IncrementSolver&) = delete;
  IncrementSolver& operator=(const IncrementSolver&) = delete;

  /// Solve from the present displacements to prescribed ones. Collective.
  /// @param[in] target displacements, owned and ghosts, of which prescribed entries are read [L]
  /// @returns iterations; their `fault` says why they did not converge
  /// @throws std::runtime_error for an error of PETSc's; what events, bodies and contacts throw
  Increment run(std::span<const double> target);
  /// Forget what was kept from earlier increments: start vectors, places of matrices. Collective.
  void forget();
  /// Forget whom the solver tells: their functions are not called any more.
  void tell_nobody();
  /// Give back the memory of PETSc's objects at once; without it, all ranks do so together later on. Nothing else may
  /// be called afterwards. Collective.
  void free();
  const SolveSeconds& seconds() const { return _newton->seconds; }

private:
  static PetscErrorCode solve_own(SNES snes, Vec x);
  static PetscErrorCode evaluate(SNES snes, Vec x, Vec F, void* self);
  static PetscErrorCode linearise(SNES snes, Vec x, Mat J, Mat P, void* self);
  static PetscErrorCode monitor(SNES snes, PetscInt iteration, PetscReal norm, void* self);
  /// Call a function on behalf of PETSc, and keep what it throws: exceptions do not pass through PETSc.
  template <typename F>
  PetscErrorCode kept(const F& act);

  void set_up();
  void call_petsc();
  Increment run_other(std::span<const double> target);
  std::vector<double> residual();
  void copy_from_u();
  void copy_to_u(Vec x);
  std::unique_ptr<Newton> make_newton() const;
  bool own() const;
  std::string method() const;

  std::shared_ptr<const EquilibriumProblem> _problem;
  NewtonOptions _options;
  NewtonEvents _events;
  double _step_tolerance = 0.0;
  SNES _snes = nullptr;
  Vec _F = nullptr, _x = nullptr;
  Mat _J = nullptr;              ///< tangent of PETSc's methods
  PetscInt _max_evaluations = 0; ///< that PETSc's methods may make
  std::unique_ptr<Newton> _newton;
  std::span<const double> _target; ///< of the present increment
  Increment _result;               ///< of it
  double _scale = 0.0;             ///< force that residuals are relative to, with PETSc's methods [F]
  std::int64_t _changes = 0;       ///< of contact status since the last iteration, with PETSc's methods
  std::exception_ptr _thrown;      ///< by a function that PETSc has called
};
} // namespace dolfinx_impact::solve
