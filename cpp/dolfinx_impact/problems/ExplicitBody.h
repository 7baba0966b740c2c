// SPDX-License-Identifier: MIT
#pragma once
#include "../integrators/CellFrequencies.h"
#include "../integrators/ForceTerm.h"
#include "../integrators/SafeStep.h"
#include "../integrators/stable_step.h"
#include "../operators/KernelTangent.h"
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace dolfinx_impact::problems
{
/// Bodies as explicit steps need them: forces, lumped mass, frequencies of the cells.
struct ExplicitBody
{
  /// A force whose work counts to an energy of its own.
  struct Term
  {
    integrators::FormForces forces;
    integrators::WorkKind kind;
  };

  /// A matrix at the present state, a new one with each call, which the caller may change. Collective.
  typedef std::function<std::shared_ptr<operators::KernelTangent>()> Assemble;

  integrators::FormForces internal;
  bool linear = false; ///< the internal energy is u . F/2
  std::vector<Term> terms;
  std::vector<double> mass; ///< per degree of freedom, owned and ghosts [M]
  std::shared_ptr<integrators::CellFrequencies> frequencies;
  integrators::UniformDamping damping; ///< `alpha` acts; the others are in `terms`, and limit the step
  integrators::SafeStep::Kind kind;    ///< how the stable step may change
  /// Derivatives of the internal force by the displacement [F/L], and of damping that differs between cells by the
  /// velocity, null without [F T/L]; of which the frequencies are.
  Assemble stiffness = {}, cell_damping = {};
  /// Of the undeformed material of each owned cell.
  struct Elasticity
  {
    std::vector<double> moduli;      ///< of uniaxial strain [F/L^2]
    std::vector<double> wave_speeds; ///< of dilatational waves [L/T]
  };
  std::optional<Elasticity> elasticity = {}; ///< nothing: it is not known
};
} // namespace dolfinx_impact::problems
