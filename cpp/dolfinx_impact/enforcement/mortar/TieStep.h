// SPDX-License-Identifier: MIT
#pragma once
#include "ExplicitTie.h"
#include "TieSystem.h"
#include <memory>

namespace dolfinx_impact::enforcement
{
/// The forces of all ties of a run in a step, docs/tie.md: with u the displacements that the step has predicted, those
/// it ends with are u + h M^-1 C^T z, and C of them is zero: h S z = -C u.
class TieStep
{
public:
  bool empty() const { return _ties.empty(); }
  void add(ExplicitTie* tie) { _ties.push_back(tie); }
  /// Work arrays for the nodes of a Halo, which is kept; factors when there are none yet. Collective.
  /// @param[in] inverse_mass of owned degrees of freedom of the space, zero where prescribed [1/M]
  void assign_numbers(operators::Halo& halo, std::span<const double> inverse_mass);
  /// Correct a predicted step: displacements, and the forces of the step. Collective. No allocation.
  /// @param[in,out] u displacements by number, ghosts valid [L]
  /// @param[in,out] f forces of corrections, of owned nodes [F]
  void correct(const PredictedStep& step, std::span<double> u, std::span<double> f);
  /// Work that supports at tied nodes do against the ties' forces in the last step, in the half of a step before the
  /// forces and in that after them, of this rank [F L].
  double support_work_before() const { return _before; }
  double support_work_after() const { return _after; }

private:
  std::vector<ExplicitTie*> _ties;
  std::unique_ptr<TieSystem> _system;
  operators::Halo* _halo = nullptr;
  std::vector<double> _force, _b, _z;
  double _before = 0.0, _after = 0.0;
};
} // namespace dolfinx_impact::enforcement
