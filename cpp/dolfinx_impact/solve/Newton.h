// SPDX-License-Identifier: MIT
#pragma once
#include "../common/dolfinx_api.h"
#include "ActiveSetIteration.h"
#include "EquilibriumProblem.h"
#include "FieldResiduals.h"
#include "Increment.h"
#include "LinearSystem.h"
#include "SolveSeconds.h"
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::solve
{
struct NewtonOptions
{
  double rtol = 1e-10;     ///< of the free residual, relative to the largest force now or at the increment's start [1]
  double atol = 0.0;       ///< of the free residual [F]
  int max_iterations = 25; ///< largest number of iterations
  double violation =
      1e-11;            ///< largest violation of the contact conditions in a converged state, in sizes of the bodies
  int max_changes = 60; ///< updates of the active set in one linearised problem
  /// Whether active sets of frictionless contacts are updated by responses of the bodies where there are factors
  /// (LinearisedActiveSet), and not by linear solutions alone.
  bool responses = true;

  /// The same options, but for those that PETSc's database has with a prefix: contact_tolerance, contact_max_updates,
  /// contact_responses.
  /// @throws std::invalid_argument for values that are not positive
  NewtonOptions with_database(const std::string& prefix) const;
};

/// Whom Newton's method tells what it does; functions may be empty. They are called on all ranks, and may throw.
struct NewtonEvents
{
  /// A line of the log.
  std::function<void(const std::string&)> log;
  /// What is done at the moment, for a display of progress.
  std::function<void(const std::string&)> progress;
  /// An iteration: its number, norm of the free residual and the force that it is relative to [F], number of active
  /// points, number of points whose status changed.
  std::function<void(int, double, double, std::int64_t, std::int64_t)> iteration;
};

/// Newton's method for equilibrium and contact; seed (3.61)-(3.66), figure 3.5.
///
/// Every iteration linearises the bodies and the geometry of contact about the present displacements, and updates the
/// active set on the linearised problem to convergence. This is a primal-dual active set method with constant
/// stiffness, so that its linear systems differ in few rows and share a preconditioner.
class Newton
{
public:
  Newton(std::shared_ptr<const EquilibriumProblem> problem, NewtonOptions options, NewtonEvents events = {});

  /// Solve from the present displacements to prescribed values. Collective.
  /// @param[in] target displacements, owned and ghosts, of which prescribed entries are read [L]
  /// @returns iterations; their `fault` says why they did not converge
  Increment run(std::span<const double> target);

  /// What a solution of the linearised problem has come to.
  struct LinearisedSolution
  {
    std::string fault;        ///< what went wrong; empty if nothing did
    std::int64_t changes = 0; ///< of the active set
    std::int64_t wrong = 0;   ///< nodes that were still wrong
  };
  /// Solve the linearised problem with updates of its active set, and update the displacements. Collective.
  /// @param[in] K stiffness of the bodies [F/L]
  /// @param[in] residual without contact forces of multipliers, owned [F]
  /// @param[in] jump increments of the prescribed displacements, by `prescribed` [L]
  /// @param[in] rtol of the linear solution [1]
  /// @param[in] unsettled linearised problems of this increment whose active set did not converge
  LinearisedSolution solve_linearised(Mat K, std::vector<double> residual, std::span<const double> jump, double rtol,
                                      int unsettled = 0);
  /// Bodies that neither supports nor contacts constrain, in words; empty if there are none. Collective.
  std::string unconstrained_modes(Mat K);
  /// Norm of the free entries of tangent times displacement: the size of internal forces that balance each other [F].
  /// Collective.
  double tangent_force(Mat K);
  /// Norm of the round-off in the residual [F]. Collective.
  double round_off(Mat K);
  /// Whether the equation of each field of a mixed space holds; true for others. Collective.
  bool fields_balance(Mat K, std::span<const double> residual);
  /// Norm over all ranks. Collective.
  double norm(std::span<const double> values) const;

  /// Owned degrees of freedom that are prescribed.
  std::span<const std::int32_t> prescribed() const { return _prescribed; }
  bool has_multipliers() const { return !_multipliers.empty(); }
  SolveSeconds seconds;
  NewtonEvents events; ///< may be exchanged between runs

private:
  struct OneSolution
  {
    std::string fault;
    std::vector<double> moved;  ///< displacement increments, owned [L]
    std::vector<double> forces; ///< their product with the stiffness of bodies and contacts, owned [F]
    std::int64_t changes = 0;   ///< of the active set that they contain
  };
  /// Matrices of one linearised problem.
  struct Stiffness
  {
    Mat K;                      ///< of the bodies
    std::vector<Mat> penalties; ///< tangents of contacts by penalty
    std::vector<Mat> geometric; ///< tangents of contacts by multipliers at given multipliers
    bool symmetric;             ///< whether all are
    double mean;                ///< mean diagonal entry of K [F/L]
  };

  OneSolution solve_once(const Stiffness& stiffness, std::vector<double> residual, std::span<const double> guess,
                         double rtol);
  void update_by_responses(CondensedSystem& system, std::shared_ptr<enforcement::Condensation> condensed, Mat factors,
                           std::span<const double> residual, std::span<const Mat> matrices, OneSolution& found);
  std::string lost_contact(std::span<const std::int8_t> closed);
  std::string over_constrained() const;
  Increment did_not_converge(Increment result, bool moved, bool small, std::int64_t pending, double violation);
  std::pair<std::int64_t, std::int64_t> update_active_sets(std::span<const double> residual, bool first);
  void predict_active_sets(std::span<const double> jump);
  double free_norm(std::span<const double> residual);
  std::unique_ptr<enforcement::Condensation> condensation();
  std::vector<double> product(std::span<const Mat> matrices, std::span<const double> values) const;
  std::vector<double> moved_from_origin() const;
  Mat stiffness();
  void correct(std::span<const double> moved);
  void set_multipliers(double unit);
  double round_off_of_bodies(Mat K);
  double round_off_of_contact() const;
  double gap_round_off() const;
  void forget_factors(Mat K);
  void backtrack(std::span<const double> start, double norm);
  void descend(Mat K, std::span<const double> start, std::span<const double> residual, double digits);
  std::vector<double> free_residual();
  double residual_norm();
  void log(const std::string& text) const;

  std::span<double> u() const { return common::array(*_problem->u->x()); }

  std::shared_ptr<const EquilibriumProblem> _problem;
  NewtonOptions _options;
  MPI_Comm _comm;
  std::size_t _num_owned;
  int _gdim;
  std::vector<std::int32_t> _prescribed;
  std::vector<enforcement::StaticContact*> _contacts;
  std::vector<enforcement::MultiplierContact*> _multipliers;
  bool _saddle, _inelastic;
  bool _rough;        ///< kinks where points close, slip or change facets, or yielding: line searches help
  bool _conservative; ///< the residual is the gradient of an energy, or nearly so
  int _plain;         ///< iterations without a line search
  double _margin;     ///< linear solutions are more accurate than asked for by this factor
  std::optional<FieldResiduals> _fields;
  std::pair<Mat, PetscObjectState> _factorised{}; ///< matrix that factors are of, with several fields
  Mat _K = nullptr;                               ///< tangent of the present increment
  std::vector<double> _sizes;                     ///< diameter of the smallest cell at each degree of freedom [L]
  std::unique_ptr<enforcement::SaddlePoint> _rows;
  std::vector<double> _forces, _start; ///< of multipliers in a saddle point, now and when the linear problem began
};
} // namespace dolfinx_impact::solve
