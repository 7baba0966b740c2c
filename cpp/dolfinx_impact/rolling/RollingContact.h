// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/mortar/MortarContact.h"
#include "Flow.h"
#include "SteadyFriction.h"
#include "StreamlineDerivative.h"

namespace dolfinx_impact::rolling
{
/// Contact of a pair by multipliers whose bodies flow past each other, with Coulomb's friction against the steady slip
/// velocity; seed (3.58)-(3.60), docs/rolling.md.
///
/// Material points have the velocity V = w + (Grad u) w, taken at the nodes of both surfaces with the derivative from
/// upstream. The slip velocity of a slave node is the mean, over what its multiplier covers, of V of the slave against
/// V of the master, without its normal part: the functional that makes slips of increments in statics. Arrays are by
/// node, vectors [i*gdim + c].
class RollingContact : public enforcement::MortarContact
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] slave this rank's facets (make_surface)
  /// @param[in] fixed mask of prescribed degrees of freedom, owned and ghosts
  /// @param[in] flow of the bodies
  /// @throws std::invalid_argument as MortarContact
  RollingContact(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave, const Master& master,
                 enforcement::MortarOptions options, std::vector<std::int8_t> fixed, std::shared_ptr<const Flow> flow);

  /// Velocity of the surface of a rigid master; load steps run through it [L/T].
  std::array<double, 3>& obstacle_velocity() { return _obstacle_velocity; }
  const std::array<double, 3>& obstacle_velocity() const { return _obstacle_velocity; }
  /// Flow of the bodies.
  const Flow& flow() const { return *_flow; }
  /// Is there friction against the slip velocity?
  bool has_steady_friction() const { return options().has_friction(); }
  /// Coefficients of friction against the slip velocity [1]. Collective where there is a law.
  /// @param[in] slip velocities, vectors [L/T]
  /// @param[in] multipliers vectors [F/L^2]
  std::vector<double> steady_friction(std::span<const double> slip, std::span<const double> multipliers) const;

  // --- velocities ----------------------------------------------------------------------------------------------------
  /// Take over the present rates of the motions. Collective.
  void update_flow();
  /// Gaps, normals, matrices of jumps, slip velocities; friction tractions turn with the surface, keeping their size.
  /// After update_flow. Collective.
  /// @param[in] u displacements, owned and ghosts [L]
  void update(std::span<const double> u);
  /// Refuse bodies that move against each other, or not at all, where they are nearest. Collective.
  /// @param[in] u displacements, owned and ghosts [L]
  /// @throws common::BadValue on all ranks
  void check_directions(std::span<const double> u);
  /// Velocity of slave against master, normal part included [L/T]. After update. Collective.
  /// @param[in] u displacements, owned [L]
  std::vector<double> relative_velocity(std::span<const double> u) const;
  /// Part of it that is not of nodes: of a rigid master, and lateral and spin creep [L/T]. Collective.
  std::vector<double> imposed_velocity() const;
  /// Velocity of the material at the nodes of both surfaces, w elsewhere, owned nodes of the space, [node*gdim + c]
  /// [L/T]. Collective.
  /// @param[in] u displacements, owned [L]
  std::vector<double> material_velocity(std::span<const double> u) const;
  /// Derivative of the slip velocity by the angular velocity of a spin [L]. Collective.
  /// @param[in] u displacements, owned [L]
  std::vector<double> velocity_slope(const Motion& spin, std::span<const double> u) const;
  /// Changes of gaps [L] by displacements. After update. Collective.
  /// @param[in] moved owned [L]
  std::vector<double> gap_change(std::span<const double> moved) const;
  /// Changes of slip velocities [L/T] by displacements. After update. Collective.
  /// @param[in] moved owned [L]
  std::vector<double> slip_change(std::span<const double> moved) const;
  /// Vectors less their parts along the normals and along components in which neither body can move.
  std::vector<double> tangential(std::vector<double> vectors) const;
  /// Largest speed of the material at the surfaces, of all ranks [L/T]. Collective.
  double speed() const;

  /// Matrices over the nodes of the space: displacements of slave against master times the cover [L^2], and the same
  /// of velocities by displacements [L^2/T].
  Mat jump() const { return _jump.get(); }
  Mat velocity_jump() const { return _velocity_jump.get(); }
  /// Components in which neither body can move: there is no slip to speak of.
  const std::vector<std::int8_t>& held() const { return _held; }
  /// Velocity of the slave's material through the mesh [L/T].
  std::vector<double> main_direction() const;
  /// Slip velocity of slave against master [L/T].
  const std::vector<double>& slip_velocity() const { return _slip_velocity; }
  /// Power that friction takes out of the motion, of all ranks [F L/T].
  double friction_power() const { return _friction_power; }

  // --- the law of friction -------------------------------------------------------------------------------------------
  /// Nodes with a multiplier.
  std::vector<std::int8_t> carriers() const;
  /// Nodes of a mask and those that have a facet in common with one of them. Collective.
  std::vector<std::int8_t> with_neighbours(const std::vector<std::int8_t>& chosen) const;
  /// What the law says of gaps [L], slip velocities [L/T] and multipliers, vectors [F/L^2]. Collective.
  SteadyFriction law(std::span<const double> gap, std::span<const double> slip,
                     std::span<const double> multipliers) const;
  /// Largest relative violation of contact and friction in the present state, of all ranks: gap of an active node over
  /// the size of the bodies, slip velocity of a stuck one over the speed, one percent of what tractions are off. [1]
  /// Collective.
  double steady_violation() const;
  /// Set the state of the nodes.
  /// @param[in] multipliers vectors [F/L^2]
  /// @param[in] law which of the nodes touch and slip
  void set_tractions(std::span<const double> multipliers, const SteadyFriction& law);

  // --- what is another one than in statics
  // -----------------------------------------------------------------------------
  state::State state() override;
  state::State saved_state() override;
  void accept_step() override;
  std::vector<double> friction_coefficients() const override { return steady_friction(_slip_velocity, traction()); }
  /// Steady states have a slip velocity, and no slip that adds up: zeros [L].
  std::vector<double> slip() const override;
  std::vector<enforcement::ContactStatus> status() const override;

private:
  std::vector<double> means(Mat matrix, std::span<const double> values) const;
  std::vector<std::int8_t> held_components() const;
  std::vector<double> creepage() const;
  std::vector<double> turn_about_normal(const Motion& spin) const;
  double rate() const;
  void update_geometry(std::span<const double> u);
  void turn_to_normals();
  std::span<const double> owned_flow() const;

  std::shared_ptr<const surface::FunctionSpace> _V;
  std::shared_ptr<const Flow> _flow;
  std::vector<std::int8_t> _fixed; ///< prescribed degrees of freedom, owned and ghosts
  StreamlineDerivative _streamlines;
  std::array<double, 3> _obstacle_velocity{};
  std::vector<double> _w; ///< velocity of the undeformed material at the nodes, owned and ghosts [L/T]
  operators::OwnedMatrix _derivative, _jump, _velocity_jump;
  std::vector<std::int8_t> _held;
  std::vector<double> _slip_velocity;
  double _friction_power = 0.0;
  mutable double _rate = 0.0; ///< velocity jump per displacement, largest; zero: not known yet [1/T]
};
} // namespace dolfinx_impact::rolling
