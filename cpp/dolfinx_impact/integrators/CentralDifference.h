// SPDX-License-Identifier: MIT
#pragma once
#include "ContactForces.h"
#include "DeformationWatch.h"
#include "EnergyBalance.h"
#include "ForceTerm.h"
#include "History.h"
#include "Loads.h"
#include "NodalFields.h"
#include "PrescribedMotion.h"
#include "RunState.h"
#include "update.h"
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

/// Eighth stage: time stepping.
namespace dolfinx_impact::integrators
{
using operators::FunctionSpace;

/// Explicit integration with lumped mass; docs/explicit/scheme.md has the equations. A step is: exchange ghosts,
/// kernels, contact, exchange forces, update. Cells without ghosts are computed while ghosts are exchanged.
class CentralDifference
{
public:
  /// @param[in] V displacement space
  /// @param[in] internal internal force
  /// @param[in] linear the internal energy is u . F/2; else it is the work of the internal force. Materials with
  ///   internal variables have elastic and plastic energies instead.
  /// @param[in] mass per degree of freedom, owned and ghosts [M]
  /// @param[in] alpha factor of mass-proportional damping [1/T]
  /// @throws std::invalid_argument for a mass of another size, an operator that is null, a name that none of its
  ///   kernels has
  CentralDifference(const std::shared_ptr<const FunctionSpace>& V, FormForces internal, bool linear,
                    std::span<const double> mass, double alpha, Scheme scheme);

  // --- set-up, before `start` -----------------------------------------------------------------------------------

  /// A force whose work counts to an energy of its own: damping and viscosity resist, external forces act.
  /// @throws std::invalid_argument as the constructor
  void add_term(FormForces forces, WorkKind kind);
  /// See Loads.
  void add_load(std::span<const std::int32_t> dofs, std::span<const double> values, int amplitude);
  void set_load(std::size_t i, std::span<const double> values);
  /// See PrescribedMotion.
  void prescribe(std::span<const std::int32_t> dofs, std::span<const double> values, int amplitude);
  /// See ContactForces.
  void add_contact(enforcement::NodalPair pair, std::array<int, 3> columns, std::array<int, 3> rotation = {-1, -1, -1});
  void add_rigid_body_contact(enforcement::NodalPair pair, std::shared_ptr<RigidBody> body);
  void add_body(std::shared_ptr<RigidBody> body) { _contact.add_body(std::move(body)); }
  void add_rigid_contact(std::shared_ptr<RigidContact> contact) { _contact.add(std::move(contact)); }
  void set_body_loads(const RigidBody& body, std::array<int, 3> force, std::array<int, 3> torque)
  {
    _contact.set_body_loads(body, force, torque);
  }
  void set_contact_step(double dt) { _contact.set_step(dt); }
  double contact_step() const { return _contact.step(); }
  /// The step that led to the present time level; 0 at the start [T].
  double last_step() const { return _last_step; }
  /// Look now and then whether owned cells have deformed so far that the stable step may have changed; a run stops
  /// after the step in which one has.
  /// @param[in] nodes, nodes_per_cell see DeformationWatch
  void add_watch(std::span<const std::int32_t> nodes, int nodes_per_cell)
  {
    _watch.emplace(nodes, nodes_per_cell, _fields.bs, _fields.stride);
  }

  // --- the run ----------------------------------------------------------------------------------------------------

  /// Start from u and v (owned entries) at a time level; works count from here. Collective.
  void start(std::span<const double> u, std::span<const double> v);

  /// Steps of given lengths. Collective.
  /// @param[in] steps lengths [T]
  /// @param[in] table amplitudes before and after each step and one step beyond, (steps + 2) rows
  /// @param[in] columns of the table
  /// @param[out] history rows before each step, see History; or empty
  /// @param[in] asked is called now and then: is this rank asked to stop? If any is, all stop after the same step
  /// @returns steps done: fewer than asked for if the run went unstable, a node went through a contact, or it was asked
  /// to stop (all ranks alike)
  int run(std::span<const double> steps, std::span<const double> table, int columns, std::span<double> history,
          const std::function<bool()>& asked = {});
  /// See DeformationWatch.
  /// @throws std::invalid_argument without a watch
  void set_watch(std::span<const double> u, std::span<const double> allowed);
  std::vector<double> deformations(std::span<const double> u);
  /// Has a cell deformed by more than it is allowed, since the last `set_watch`? The same on all ranks.
  bool deformed() const { return _deformed; }
  /// Did the last run end because a rank was asked to stop, or a cell has deformed? The same on all ranks.
  bool stopped() const { return _stopped; }

  /// Constants or coefficients of forms have changed: evaluate their forces at the present time level again. Contact
  /// forces stay. Collective.
  void revise();

  // --- the present time level -------------------------------------------------------------------------------------

  /// Energies, sums over ranks. Collective.
  Energies energies();
  /// Velocity (3.75) and acceleration, owned entries; with the forces of kinematic contact of the last step.
  /// Collective.
  void motion(std::span<double> v, std::span<double> a);
  /// Forces of the supports on the bodies at the prescribed degrees of freedom, zero elsewhere, owned entries: what
  /// inertia, damping and internal forces lack to loads and contact forces [F]. Collective.
  std::vector<double> support_forces();
  /// Bring the gaps of all contacts' nodes up to date.
  void update_gaps() { _contact.update_gaps(); }
  /// Owned displacements [L].
  std::vector<double> displacement() const { return _fields.owned_values(_fields.u); }
  /// Owned degree of freedom that moves fastest or is not a number, and its speed: where an unstable run broke.
  std::pair<std::int32_t, double> fastest() const;

  /// What the run goes on from, beside contacts and materials, values of its own. Contact is searched anew in the next
  /// step, as in a run that is restored. Collective.
  state::State saved_state();
  /// A state of that structure, of zeros.
  state::State empty_state() const;
  /// Go on from what `saved_state` has returned; start from its displacement and velocity. Collective.
  /// @throws std::invalid_argument for the state of another problem
  void resume(const state::State& saved);

  // --- figures ----------------------------------------------------------------------------------------------------

  const EnergyGain& gain() const { return _energies.gain(); }
  double gain_limit() const { return _energies.gain_limit(); }
  void set_gain_limit(double limit) { _energies.set_gain_limit(limit); }
  /// See EnergyBalance.
  double released() const { return _energies.released(); }
  double release_limit() const { return _energies.release_limit(); }
  void set_release_limit(double limit) { _energies.set_release_limit(limit); }
  /// See ContactForces.
  std::pair<int, enforcement::Passage> passage() const { return _contact.passage(); }
  std::int64_t num_searches() const { return _contact.num_searches(); }
  /// Wall-clock time that this rank has spent on contact so far: searches, gaps, forces, their energies [s].
  double contact_seconds() const { return _contact.seconds(); }
  /// Nodal values that this rank has sent to its neighbours so far. Not: the one sum over all ranks of every step, what
  /// candidates for contact are searched with.
  Halo::Traffic traffic() const;
  std::size_t row_size() const { return History::row_size(_contact.size()); }

private:
  Coefficients coefficients(double dt) const;
  AlignedVector kinematic_forces();
  std::vector<std::int32_t> entries(std::span<const std::int32_t> dofs) const;
  double uncertainty() const;
  void fields_changed();
  bool evaluate();
  void end_residual_exchange();
  void advance(double dt, const double* amplitudes);
  bool asked_to_stop(const std::function<bool()>& asked);
  bool look();
  bool passed() const;

  operators::NodePositions _positions; ///< of the undeformed mesh, as it is when a run begins
  NodalFields _fields;
  NodeMasses _masses; ///< of `_fields`, as `update` reads them
  FormForces _internal;
  double _alpha;
  Scheme _scheme;
  Loads _loads;
  PrescribedMotion _prescribed;
  std::vector<ForceTerm> _terms;
  ContactForces _contact;
  EnergyBalance _energies;
  double _largest_coordinate = 0.0;             ///< of this rank's undeformed mesh [L]
  std::vector<double> _beyond;                  ///< amplitudes one step on: velocities of prescribed motion now
  double _last_step = 0.0;                      ///< that led here; 0 at the start [T]
  bool _evaluated = false;                      ///< is the residual that of the present time level?
  bool _stop = false, _stopped = false;         ///< this rank is asked to stop; the ranks have agreed on it
  std::chrono::steady_clock::time_point _asked; ///< when `asked` was called last
  std::optional<DeformationWatch> _watch;
  int _unwatched = 0;     ///< steps since the last look at deformations
  bool _far = false;      ///< a cell of this rank has deformed too far
  bool _deformed = false; ///< the ranks have agreed on it
};
} // namespace dolfinx_impact::integrators
