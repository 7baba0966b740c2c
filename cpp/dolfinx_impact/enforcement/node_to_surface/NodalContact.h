// SPDX-License-Identifier: MIT
#pragma once
#include "../../operators/Halo.h"
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// What the explicit integrator shows to contacts: arrays over the nodes of the Halo they were numbered by, entry
/// node*gdim + c.
struct NodalState
{
  const double* u = nullptr;            ///< displacements [L]
  const double* du = nullptr;           ///< their increments in the last step [L]
  const double* inverse_mass = nullptr; ///< zero where prescribed [1/M]
  double dt = 0.0;                      ///< step that led here [T]
};

/// Energies of a contact on this rank; see docs/explicit/energies.md.
struct ContactEnergy
{
  double stored = 0.0;         ///< in springs, now [F L]
  double friction = 0.0;       ///< dissipated so far [F L]
  double normal = 0.0;         ///< work of the normal forces so far, of springs without what is stored [F L]
  double later_friction = 0.0; ///< what the motion after the last forces adds to `friction` [F L]
  double later_normal = 0.0;   ///< and to `normal` [F L]
  double recoverable = 0.0;    ///< taken by kinematic contact from nodes that are still closed [F L]
};

/// A slave node that went through the master in a step too large to be held back.
struct Passage
{
  std::int32_t node = -1; ///< number in the space; -1: none
  double facets = 0.0;    ///< how far it came through the surface in the step, in facets (docs/explicit/penalty.md) [1]
};

/// What the explicit integrator asks of any contact: candidates, the nodes it acts on, energies. Forces are on slave
/// and master nodes, equal and opposite. A contact is a SpringForces or a StepCorrection as well: that is how it acts.
class NodalContact
{
public:
  virtual ~NodalContact() = default;

  /// Find candidates for the present configuration; afterwards remote() may be another list. Collective.
  /// @param[in] u displacements of owned nodes [L]
  /// @param[in] du what they move in a step: fast bodies are looked for farther away; empty: at rest [L]
  virtual void search(std::span<const double> u, std::span<const double> du) = 0;
  /// Nodes of other ranks that the candidates need: global numbers and owners, ascending.
  virtual std::span<const std::int64_t> remote_nodes() const = 0;
  virtual std::span<const int> remote_owners() const = 0;
  /// Which nodes the contact reads and acts on, each once, ascending, after a search. Collective.
  /// @param[in] all a Halo of the space's nodes and those asked for; numbers are those of this one
  virtual std::span<const std::int32_t> needs(operators::Halo& all) = 0;
  /// Take other numbers for the nodes that `needs` told, and what belongs to them. Collective.
  /// @param[in] halo of these nodes, among others. It is kept: it must live until the next call
  /// @param[in] numbers in `halo`, for each node of the Halo that was given to `needs`
  /// @param[in] mass of the nodes of `halo`, ghosts valid [M]
  virtual void number(operators::Halo& halo, std::span<const std::int32_t> numbers, const double* mass) = 0;
  /// Where a rigid master is now, and how far it has moved in the last step (no effect on deformable ones) [L].
  virtual void set_obstacle(const std::array<double, 3>& displacement, const std::array<double, 3>& increment) = 0;
  /// How much of the motion is used up that the candidates allow, looking two steps ahead; at 1 or more search again.
  virtual double used(const NodalState& state) const = 0;

  /// The next searches do not depend on what was before: a run that goes on from a checkpoint makes the same ones.
  virtual void forget_search() = 0;

  /// Evaluate the gaps of open nodes for the results: steps update them lazily.
  /// @param[in] u displacements of the Halo's nodes [L]
  virtual void update_gaps(const double* u) = 0;

  virtual ContactEnergy energy() const = 0;
  /// The node that went through fastest, of this rank, since the contact was made or forgot its history.
  virtual Passage passage() const = 0;
  /// Sum of the forces on this rank's slave nodes in the last step [F].
  virtual const double* force() const = 0;
};

/// A contact that acts by springs: forces in the present configuration, which are part of the residual.
class SpringForces
{
public:
  virtual ~SpringForces() = default;
  /// Add the forces to f (over the Halo's nodes; the caller sends ghosts on). Called once per step: it updates the
  /// history of friction. No allocation.
  virtual void add_forces(const NodalState& state, double* f) = 0;
};

/// What a predicted step shows to contacts that correct it: arrays over the nodes of the Halo, entry node*gdim + c.
struct PredictedStep
{
  const double* du = nullptr;           ///< increments of the step as predicted [L]
  const double* du_before = nullptr;    ///< increments of the step before, which work counts half of [L]
  const double* inverse_mass = nullptr; ///< zero where prescribed [1/M]
  double h = 0.0;                       ///< a force f moves a node by h*f/m in the step [T^2]
  double dt = 0.0;                      ///< step [T]
  double release_share = 1.0;           ///< part of the recoverable energy that nodes which leave may be given back [1]
};

/// A contact that acts by correcting a predicted configuration: kinematic contact.
class StepCorrection
{
public:
  virtual ~StepCorrection() = default;
  /// Collective. No allocation.
  /// @param[in] step as predicted, ghosts valid
  /// @param[in,out] u predicted displacements, ghosts valid; on return corrected, ghosts valid [L]
  /// @param[in,out] f complete on owned nodes: forces are added [F]
  virtual void correct(const PredictedStep& step, double* u, double* f) = 0;
};
} // namespace dolfinx_impact::enforcement
