// SPDX-License-Identifier: MIT
#pragma once
#include "../gap/RigidMotion.h"
#include "../operators/RigidBodyModes.h"
#include "../state/State.h"
#include "ContactStatus.h"
#include "mortar/Constraints.h"
#include <array>
#include <cstdint>
#include <optional>
#include <petscmat.h>
#include <petscvec.h>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace dolfinx_impact::enforcement
{
class MortarContact;

/// A contact of one pair in equilibrium or in a step of implicit dynamics: what Newton's method asks of it. Arrays are
/// over this rank's contact points or over the degrees of freedom of the displacement space, owned ones, or owned and
/// ghosts where it is said. Forces act on the right-hand side: the residual of equilibrium is internal minus external
/// minus contact forces. Calls are collective but those that say otherwise.
///
/// The calls in one increment: begin_step; per iteration update_gap, add_residual or update_multipliers,
/// update_active_set, violation, update_nodal_stiffness, tangent, closing_forces; after convergence augment, then
/// accept_step, or the saved state is assigned back.
class StaticContact
{
public:
  virtual ~StaticContact() = default;

  /// Name of the pair. Not collective.
  virtual const std::string& name() const = 0;
  /// Whether it is a MultiplierContact. Not collective.
  virtual bool has_multipliers() const { return false; }
  /// The contact by multipliers that this is, or that it adds to; null: it is none. Not collective.
  virtual MortarContact* mortar() { return nullptr; }
  /// Why a converged state is not a solution; empty if it is one. Not collective.
  virtual std::string fault() const { return ""; }

  /// Say how long the increments are that follow; zero: they have no length in time, as in static problems [T]. Not
  /// collective.
  virtual void set_time_step(double) {}

  // --- load steps ------------------------------------------------------------------------------------------------
  /// Refuse parameters that do not fit the problem, before a solution.
  /// @throws std::invalid_argument on all ranks
  virtual void check_parameters() {}
  /// Refuse what needs time, before a static solution.
  /// @throws std::invalid_argument on all ranks
  virtual void check_without_time() const {}
  /// Begin an increment.
  /// @param[in] u displacements, owned and ghosts [L]
  /// @param[in] displacement of a rigid master at the end of the increment; nothing for deformable masters [L]
  /// @param[in] target prescribed displacements at its end, owned and ghosts, of which prescribed entries are read;
  /// empty: they do not change [L]
  virtual void begin_step(std::span<const double> u, const std::optional<std::array<double, 3>>& displacement,
                          std::span<const double> target = {}) = 0;
  /// Turn a rigid master about its centre (gap::Rigid::centre) in the increment that the next begin_step begins;
  /// without this call it does not turn. Not collective.
  /// The argument is the rotation at the end of the increment, since the reference configuration.
  /// @throws std::invalid_argument for a contact whose master cannot turn
  virtual void set_rotation(const gap::Matrix3&)
  {
    throw std::invalid_argument(name() + ": this contact has no rigid master that turns");
  }
  /// Rotation of a rigid master, as reached; nothing for one that cannot turn. Not collective.
  virtual std::optional<gap::Matrix3> rotation() const { return {}; }
  /// Centre about which a rigid master turns, before its displacement [L]. Not collective.
  virtual std::array<double, 3> centre() const { return {}; }
  /// Displacement of a rigid master, as reached; nothing for deformable ones [L]. Not collective.
  virtual std::optional<std::array<double, 3>> displacement() const = 0;
  /// What an increment starts from: copy it before, assign the copy to go back. Not collective.
  virtual state::State state() = 0;
  /// Accept a converged increment: slips, tractions and multipliers become history, totals are updated.
  virtual void accept_step() = 0;
  /// Begin another round after convergence if it is needed: augmented multipliers or new closest points; `fault` says
  /// if further rounds do not help. @returns whether the iteration must continue
  virtual bool augment() { return false; }
  /// Prescribed displacements that cause penetration in a converged state, in words; empty if there are none.
  virtual std::string prescribed_overlap() { return ""; }
  /// Points that have passed through the master since the last converged state and are open on its far side, in words;
  /// empty if there are none.
  virtual std::string passed_through() = 0;

  // --- Newton iterations -----------------------------------------------------------------------------------------
  /// Update candidates, gaps, normals, and tractions that follow from gaps.
  /// @param[in] u displacements, owned and ghosts [L]
  virtual void update_gap(std::span<const double> u) = 0;
  /// Update which points are active and which of them stick.
  /// @param[in] first the increment has just begun: the gaps alone decide
  /// @param[in] last global number of the only node that may change; nothing: all nodes
  /// @returns number of points of all ranks whose state has changed or was wrong
  virtual int update_active_set(bool first, std::optional<std::int64_t> last = {}) = 0;
  /// Nodal contact forces on both bodies, owned [F].
  virtual std::vector<double> contact_forces() const = 0;
  /// Subtract the nodal contact forces from a residual [F].
  virtual void add_residual(Vec b) const = 0;
  /// Update the scale of force per displacement.
  /// @param[in] K tangent of the bodies [F/L]
  virtual void update_nodal_stiffness(Mat K) = 0;
  /// Derivative of minus the contact force at given multipliers, borrowed until the next call; null: it is zero [F/L].
  virtual Mat tangent() = 0;
  /// Whether `tangent` is to be its positive semi-definite part only, with which a step goes down. Not collective.
  virtual void set_convex(bool) {}
  /// Whether the contact has friction. Not collective.
  virtual bool has_friction() const = 0;
  /// Whether forces may grow faster than their tangent tells, so that every Newton step needs a line search. Not
  /// collective.
  virtual bool needs_line_search() const { return false; }
  /// Whether the tangent is symmetric in the present state.
  virtual bool symmetric() const { return true; }
  /// Number of active points of all ranks.
  virtual std::int64_t num_active() const = 0;
  /// Largest violation of the constraints on all ranks, relative to the size of the bodies [1].
  virtual double violation() const { return 0.0; }
  /// Norm of the round-off in the contact forces; zero if the forces are unknowns [F].
  virtual double round_off() const { return 0.0; }
  /// The point with the largest violation, in words; may be empty.
  virtual std::string largest_violation() const { return ""; }
  /// What in the surfaces may keep a solve from converging, in words; may be empty.
  virtual std::string mesh_advice() const { return ""; }
  /// Smallest gap of all ranks; infinite where no point has a master [L].
  virtual double smallest_gap() const = 0;
  /// What a checkpoint holds of the last converged state, values of its own. Not collective.
  virtual state::State saved_state() = 0;
  /// Continue from what `saved_state` of the same contact has returned, on these ranks or others.
  /// @param[in] u displacements of the checkpoint, owned and ghosts [L]
  virtual void resume(const state::State& saved, std::span<const double> u) = 0;
  /// Forget what a checkpoint does not have, candidates of the search and places of matrices, so that the next step is
  /// that of a restored run. Not collective.
  virtual void forget() = 0;

  // --- bodies that are supported by contact alone ----------------------------------------------------------------
  /// Active constraints applied to the rigid body modes: their products, summed over this rank's rows,
  /// [i*num_modes + j]. Two modes with a product of zero for themselves are not constrained.
  virtual std::vector<double> rigid_body_products(const operators::RigidBodyModes& modes) const = 0;
  /// Activate the points nearest to the master if the bodies nearly touch. @returns whether there are any
  virtual bool close_nearest() { return false; }
  /// Forces that close the gaps of the points of close_nearest, to be subtracted from the right-hand side; empty
  /// without such points [F].
  virtual std::vector<double> closing_forces() const { return {}; }

  // --- results, not collective -----------------------------------------------------------------------------------
  /// Present positions of this rank's points, [i*gdim + c] [L].
  virtual std::vector<double> points() const = 0;
  /// Positive if open, infinite without master [L].
  virtual std::vector<double> gap() const = 0;
  /// Unit normals out of the master, [i*gdim + c].
  virtual std::vector<double> normal() const = 0;
  /// Contact pressure per reference area [F/L^2].
  virtual std::vector<double> pressure() const = 0;
  /// Contact traction on the slave per reference area, [i*gdim + c] [F/L^2].
  virtual std::vector<double> traction() const = 0;
  /// Tangential displacement of slave against master since it stuck, [i*gdim + c] [L].
  virtual std::vector<double> slip() const = 0;
  virtual std::vector<ContactStatus> status() const = 0;
  /// Area that belongs to each point; a length in the plane [L^2].
  virtual std::vector<double> weight() const = 0;
  /// Part of each point's area that is in contact [1]. Collective.
  virtual std::vector<double> covered() const = 0;
  /// Force on the slave of all ranks, in the last converged state; nothing before the first [F].
  virtual std::optional<std::array<double, 3>> force() const = 0;
  /// Work of friction so far, of all ranks [F L].
  virtual double dissipated() const = 0;
  /// Energy of the springs of a penalty, of all ranks; zero with multipliers [F L]. Collective.
  virtual double stored_energy() const { return 0.0; }
};

/// A static contact whose normal tractions are unknowns: an active set on the linearised problem. Arrays by node are
/// [i*gdim + c], i over the contact's nodes.
class MultiplierContact : public StaticContact
{
public:
  bool has_multipliers() const override { return true; }
  void update_nodal_stiffness(Mat K) override = 0;

  /// Owned nodes that may have a multiplier. Not collective.
  virtual std::span<const std::int32_t> nodes() const = 0;
  /// Their global numbers. Not collective.
  virtual std::span<const std::int64_t> numbers() const = 0;
  /// Nodes in contact, and those of them that slip. Not collective.
  virtual std::span<const std::int8_t> active() const = 0;
  virtual std::span<const std::int8_t> sliding() const = 0;
  /// Multipliers of the nodes [F/L^2]. Not collective.
  virtual std::span<const double> multiplier() const = 0;
  /// Largest global number of the nodes that the last update_active_set changed, -1 without any. Not collective.
  virtual std::int64_t last_change() const = 0;

  /// Update multipliers from equilibrium.
  /// @param[in] residual nodal, without contact forces, owned [F]
  virtual void update_multipliers(std::span<const double> residual) = 0;
  /// Norm of the forces that close gaps of the size of their round-off [F].
  virtual double gap_round_off() const = 0;
  /// Constrained directions of the active nodes. The linear problem that follows is of this state.
  virtual Constraints constraints() = 0;
  /// Linearised tractions that change with the slip: a matrix [F/L], the caller's own, and forces to be subtracted from
  /// the right-hand side, owned [F]; nothing without any.
  virtual std::optional<std::pair<Mat, std::vector<double>>> friction_springs() = 0;
  /// Friction forces along prescribed directions, owned; empty without any [F].
  virtual std::vector<double> imposed_friction_forces() const = 0;
  /// Update gaps and slips of the linearised problem.
  /// @param[in] increments of displacement since update_gap, owned [L]
  virtual void update_linearised_gap(std::span<const double> increments) = 0;
  /// Changes of gaps [L] and of multipliers [F/L^2] without friction.
  /// @param[in] increments of displacement, owned [L]
  /// @param[in] forces that they cause, owned [F]
  virtual std::pair<std::vector<double>, std::vector<double>>
  linearised_response(std::span<const double> increments, std::span<const double> forces) const = 0;
  /// Second-order correction: add the differences of gaps and slips from the linearised ones.
  /// @param[in] u displacements, owned and ghosts [L]
  virtual void correct_linearisation(std::span<const double> u) = 0;
  /// Set multipliers from the solution of a saddle point.
  /// @param[in] forces along the constrained directions, zero elsewhere, by node [F]
  virtual void set_multipliers(std::span<const double> forces) = 0;
  /// Number of nodes of all ranks whose friction traction is not yet that of the law.
  virtual std::int64_t num_turning() const = 0;
  /// Set the nodes whose normal condition a linear problem has left out, as others of the same nodes imply it.
  /// @param[in] redundant indices of nodes
  virtual void set_redundant(std::span<const std::int32_t> redundant) = 0;
  /// Owned nodes whose normal condition was left out in this increment, as others contradict it.
  virtual std::vector<std::int32_t> over_constrained() const = 0;
  /// Rotate the friction tractions of the last iteration to the present tangent planes.
  virtual void rotate_friction_traction() = 0;

  /// Predict the active set of an increment that has just begun: close the nodes that would overlap by more than a part
  /// of the largest overlap if the bodies moved by increments. Nodes in contact stay so. Contacts with friction, whose
  /// solution may depend on the way, are left as they are. Collective.
  /// @param[in] increments of displacement, owned [L]
  /// @param[in] part of the largest overlap [1]
  virtual void predict_active_set([[maybe_unused]] std::span<const double> increments, [[maybe_unused]] double part) {}

  // --- the active set from responses of the bodies at single nodes (frictionless contacts) -------------------------
  /// Displacements that open a gap of one at a node, owned [L].
  /// @param[in] number global number of the node
  virtual std::vector<double> unit_gap(std::int64_t number) const = 0;
  /// Nodal forces of unit tractions along the normal at one node, on both bodies, owned [F].
  /// @param[in] number global number of the node
  virtual std::vector<double> unit_force(std::int64_t number) const = 0;
  /// Gaps of the linearised problem [L]. Not collective.
  virtual std::span<const double> linearised_gap() const = 0;
  /// Set the active set, gaps of the linearised problem and multipliers, by node. Not collective.
  virtual void set_linearised(std::span<const std::int8_t> active, std::span<const double> gap,
                              std::span<const double> multiplier) = 0;
};
} // namespace dolfinx_impact::enforcement
