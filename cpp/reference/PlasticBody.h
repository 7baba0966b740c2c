// SPDX-License-Identifier: MIT
#pragma once
#include "Model.h"
#include "plastic_element.h"
#include "solve.h"

namespace impact_reference
{
/// A model some or all of whose cells obey J2 plasticity, with the history of their points. Evaluations are trials from
/// the committed history; only commit and set_history change it.
class PlasticBody
{
public:
  /// Answer of the whole body to displacements.
  struct Trial
  {
    Vector force;                   ///< internal [F]
    Csr tangent;                    ///< empty if not asked for [F/L]
    double energy = 0;              ///< elastic, of all cells [F L]
    double work = 0;                ///< plastic, since the start [F L]
    double dissipation = 0;         ///< of the step [F L]
    std::vector<J2History> history; ///< cell by cell, point by point
    Matrix stress;                  ///< of J2Answer, 3 x 3 in rows; zero in elastic cells (num_points, 9) [F/L^2]
  };

  /// @param model must outlive the body; its materials are linear elastic with the elastic constants of the laws
  /// @param laws by tag; cells with other tags stay elastic
  /// @throws std::invalid_argument for what does not fit
  PlasticBody(const Model& model, const Rule& rule, const std::map<int, J2Parameters>& laws, PlasticStrain strain,
              Dilatation dilatation);

  /// Let `evaluate` average pressures at the nodes from now on (NodalPressure.h), but for a share of 0.1 % that cells
  /// keep to themselves. There is no tangent then, and stresses are those of the cells' own pressure.
  /// @throws std::invalid_argument for cells and hypotheses that this is not for, Hencky's law, a mean dilatation, or
  /// elastic cells
  void average_pressure();

  const Model& model() const { return model_; }
  bool finite_strain() const { return kinematics_.strain != PlasticStrain::small; }
  Trial evaluate(const Vector& u, bool with_tangent) const;

  /// Stiffness of a cell without displacements and history [F/L].
  Matrix stiffness_at_rest(std::int64_t cell) const;

  const std::vector<J2History>& history() const { return history_; }
  void commit(const Trial& trial) { history_ = trial.history; }
  /// @throws std::invalid_argument for another number of points
  void set_history(const std::vector<J2History>& history);

private:
  const Model& model_;
  Sampler sampler_;
  PlasticKinematics kinematics_;
  std::map<int, J2> laws_;
  std::vector<J2History> history_;
  bool averages_pressure_ = false;
};

/// States at the ends of the steps of a static analysis.
struct PlasticStates
{
  Matrix u, force;               ///< internal force (num_steps, num_dofs) [L], [F]
  Vector energy, work;           ///< elastic, plastic since the start [F L]
  std::vector<int> iterations;   ///< of every step, those of cut-backs included
  std::vector<double> residuals; ///< at the end of every step
};

/// Static analysis of a path: Newton's method in every step, which is halved where it fails (up to ten times); commits
/// the history of every step, and of the parts of a halved one. After a failure the body keeps the last good history.
/// @param u0 displacements that belong to the committed history [L]
/// @param values of the fixed degrees of freedom at the ends of the steps (num_steps, num_fixed) [L]
/// @param loads at the ends of the steps (num_steps, num_dofs) [F]
/// @param load0 load that u0 is in equilibrium with, where a halved first step begins [F]
/// @throws std::runtime_error if Newton's method fails
PlasticStates solve_plastic(PlasticBody& body, const std::vector<std::int64_t>& fixed_dofs, const Vector& u0,
                            const Vector& load0, const Matrix& values, const Matrix& loads, double tolerance,
                            int max_iterations);
} // namespace impact_reference
