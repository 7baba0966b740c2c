// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/RigidMotion.h"
#include "../../operators/Halo.h"
#include "../../state/State.h"
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Least and largest increment of any node, by component; infinite: unknown [L].
struct IncrementRange
{
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> least{-infinity, -infinity, -infinity}, largest{infinity, infinity, infinity};
};

/// State that the explicit integrator passes to contacts: arrays over the nodes of the Halo passed to `number`, entry
/// node*gdim + c.
struct NodalState
{
  std::span<const double> u;            ///< displacements [L]
  std::span<const double> du;           ///< their increments in the last step [L]
  std::span<const double> inverse_mass; ///< zero where prescribed [1/M]
  double dt = 0.0;                      ///< size of the last step [T]
  IncrementRange range = {};            ///< of `du`
};

/// Energies of a contact on this rank; see docs/explicit/energies.md.
struct ContactEnergy
{
  double stored = 0.0;         ///< in springs, now [F L]
  double friction = 0.0;       ///< dissipated so far [F L]
  double normal = 0.0;         ///< work of the normal forces so far, without energy stored in springs [F L]
  double later_friction = 0.0; ///< share of `friction` by the motion after the last forces [F L]
  double later_normal = 0.0;   ///< share of `normal` by that motion [F L]
  double recoverable = 0.0;    ///< absorbed by kinematic contact at nodes that are still closed [F L]
};

/// A slave node that passed through the master too far in one step to be pushed back.
struct Passage
{
  std::int32_t node = -1; ///< number in the space; -1: none
  double facets = 0.0;    ///< depth of the passage in facet diameters (docs/explicit/penalty.md) [1]
  bool pressed = false;   ///< it was held back, but pressed through by a force (general contact)
};

/// Interface of a contact to the explicit integrator: candidates, nodes, energies. It is one direction of a pair: slave
/// nodes against a master, with equal and opposite forces. A contact implements SpringForces as well, or is a
/// KinematicContact: they say how forces act.
class NodalContact
{
public:
  virtual ~NodalContact() = default;

  /// Find candidate facets in the present configuration; remote_nodes() may change. Collective.
  /// @param[in] u displacements of owned nodes [L]
  /// @param[in] du increments of a step, which extend the search distance; empty: at rest [L]
  virtual void search(std::span<const double> u, std::span<const double> du) = 0;
  /// Nodes of other ranks among the candidates: global numbers, ascending, and their owners.
  virtual std::span<const std::int64_t> remote_nodes() const = 0;
  virtual std::span<const int> remote_owners() const = 0;
  /// Nodes that the contact reads or acts on, each once, ascending; call after a search. Collective.
  /// @param[in] all Halo of the nodes of the space and remote_nodes(); its numbering is used
  virtual std::span<const std::int32_t> required_nodes(operators::Halo& all) = 0;
  /// Renumber the nodes that `needs` returned. Collective.
  /// @param[in] halo contains these nodes; a reference is kept and must stay valid until the next call
  /// @param[in] numbers in `halo`, for each node of the Halo passed to `needs`
  /// @param[in] mass of the nodes of `halo`, ghosts valid [M]
  virtual void assign_numbers(operators::Halo& halo, std::span<const std::int32_t> numbers,
                              std::span<const double> mass) = 0;
  /// Largest size of a number that the position of a rigid master is computed from; zero: deformable [L].
  virtual double largest_position() const = 0;
  /// Place and last motion of a rigid master; no effect on deformable masters.
  virtual void set_obstacle(const gap::RigidMotion& motion) = 0;
  /// The same after a restart: the motion is that of the last step, which has been completed.
  virtual void restore_obstacle(const gap::RigidMotion& motion) { set_obstacle(motion); }
  /// Part of the motion allowed by the candidates that is used up two steps from now, or an upper bound of it that is
  /// less than 1; search again from 1 on [1].
  virtual double increment_used(const NodalState& state) const = 0;

  /// Reset the prediction of the search distance, so that runs with and without a restart search alike.
  virtual void forget_search() = 0;

  /// Evaluate the gaps of open nodes for the results: steps update them lazily.
  /// @param[in] u displacements of the Halo's nodes [L]
  virtual void update_gaps(std::span<const double> u) = 0;

  /// Upper bound of what the contact adds to the squared angular frequencies of the bodies, wherever they meet.
  /// Collective [1/T^2].
  /// @param[in] mass of owned nodes of the space [M]
  virtual double added_square_frequency(std::span<const double> mass) const
  {
    (void)mass;
    return 0.0;
  }

  /// Upper bound of the damping over the mass that the contact adds, wherever the bodies meet. Collective [1/T].
  /// @param[in] mass of owned nodes of the space [M]
  virtual double added_damping_rate(std::span<const double> mass) const
  {
    (void)mass;
    return 0.0;
  }
  /// Points of this rank whose local equations were not solved in the last step.
  virtual std::int64_t num_unsolved() const { return 0; }

  virtual ContactEnergy energy() const = 0;
  /// The node of this rank that passed through farthest, since construction or since the last `resume`.
  virtual Passage passage() const = 0;
  /// Sum of the forces on this rank's slave nodes in the last step [F].
  virtual const std::array<double, 3>& force() const = 0;
  /// First moment of these forces about the centre of a rigid master that rotates: the sum of f_a r_b, r from the
  /// centre to the node, row by row; its antisymmetric part is the torque. Zero for other masters [F L].
  virtual gap::Matrix3 force_moment() const { return {}; }

  /// What the next step starts from, values of its own: fields of this rank's slave nodes, its "energies" (in the order
  /// of ContactEnergy) and its "force" [F], as vectors of the rank.
  virtual state::State saved_state() const = 0;
  /// Go on from what `saved_state` has returned, perhaps on other ranks; or from a copy with other values.
  /// @throws std::invalid_argument for the state of other nodes
  virtual void resume(const state::State& saved) = 0;
  /// All nodes become open, energies and histories those of the start.
  virtual void reset() = 0;
};

/// A contact whose forces depend on the present configuration and are part of the residual (penalty).
class SpringForces
{
public:
  virtual ~SpringForces() = default;
  /// Add the forces to f (over the Halo's nodes; the caller sends ghosts on). Called once per step: it updates the
  /// history of friction. No allocation.
  virtual void add_forces(const NodalState& state, std::span<double> f) = 0;
};

/// Predicted step passed to kinematic contacts, which correct it: arrays over the nodes of the Halo, entry node*gdim +
/// c.
struct PredictedStep
{
  std::span<const double> du;           ///< increments of the step as predicted [L]
  std::span<const double> du_before;    ///< increments of the step before; half of the work is done on them [L]
  std::span<const double> inverse_mass; ///< zero where prescribed [1/M]
  double h = 0.0;                       ///< a force f moves a node by h*f/m in the step [T^2]
  double dt = 0.0;                      ///< step [T]
  double release_share = 1.0;           ///< share of the recoverable energy that opening nodes may get back [1]
};
} // namespace dolfinx_impact::enforcement
