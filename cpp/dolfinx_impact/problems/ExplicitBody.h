// SPDX-License-Identifier: MIT
#pragma once
#include "../integrators/CellFrequencies.h"
#include "../integrators/ForceTerm.h"
#include "../integrators/SafeStep.h"
#include "../integrators/stable_step.h"
#include <memory>
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

  integrators::FormForces internal;
  bool linear = false; ///< the internal energy is u . F/2
  std::vector<Term> terms;
  std::vector<double> mass; ///< per degree of freedom, owned and ghosts [M]
  std::shared_ptr<integrators::CellFrequencies> frequencies;
  integrators::UniformDamping damping; ///< `alpha` acts; the others are in `terms`, and limit the step
  integrators::SafeStep::Kind kind;    ///< how the stable step may change
};
} // namespace dolfinx_impact::problems
