// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/InitialPenetration.h"
#include "../ContactTotals.h"
#include "../StaticContact.h"
#include "CoulombFriction.h"
#include "MortarGeometry.h"
#include <variant>

namespace dolfinx_impact::enforcement
{
/// What an increment of a contact by multipliers starts from, by node; vectors [i*gdim + c].
struct MortarState
{
  std::vector<std::int8_t> active, sliding; ///< in contact; of those, slipping
  std::vector<double> direction;            ///< of the friction traction of slipping nodes, unit vectors
  std::vector<double> multiplier;           ///< [F/L^2]
  std::vector<double> friction_traction;    ///< [F/L^2]
  std::vector<double> traction_n;           ///< friction traction of the last converged state [F/L^2]
  std::vector<double> total_slip;           ///< since a node last stuck [L]
  std::vector<double> opening;              ///< gap at the start of the increment of nodes that were open, else 0 [L]
  std::vector<double> coefficient;          ///< of friction [1]
  std::int8_t begun = 0;                    ///< whether there is an `opening`

  MortarState(int gdim, std::size_t num_nodes);
};

/// Contact of a pair by Lagrange multipliers: dual mortar against deformable masters, nodal against rigid ones; a
/// primal-dual active set with Coulomb friction; docs/contact.md. Multipliers are condensed (Condensation) or stay in
/// the system (SaddlePoint). Points are the slave's nodes that this rank owns. Several contacts of a problem are made
/// known to each other by `connect` (shared_nodes.h).
class MortarContact : public MultiplierContact
{
public:
  /// The master: this rank's facets, or an obstacle at rest. Contacts with the same obstacle have the same master.
  typedef std::variant<surface::Facets, std::shared_ptr<const gap::Rigid>> Master;

  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] slave this rank's facets (make_surface)
  /// @param[in] fixed mask of prescribed degrees of freedom, owned and ghosts
  /// @throws std::invalid_argument on all ranks, for bodies that lie inside each other, an obstacle whose surface does
  /// not face the slave, or a basis that it does not take
  MortarContact(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave, const Master& master,
                MortarOptions options, std::vector<std::int8_t> fixed);

  const std::string& name() const override { return _options.name; }
  MortarContact* mortar() override { return this; }
  const MortarOptions& options() const { return _options; }
  MortarGeometry& geometry() { return *_geometry; }
  const MortarGeometry& geometry() const { return *_geometry; }
  const gap::InitialPenetration& initial_penetration() const { return _initial; }
  const ContactTotals& totals() const { return _totals; }
  ContactTotals& totals() { return _totals; }

  /// Coefficient of friction of slips of increments, the largest of those that act at a node [1].
  double friction() const;
  bool has_friction() const override;
  void set_time_step(double dt) override { _time_step = dt; }
  void check_without_time() const override;

  // --- load steps ----------------------------------------------------------------------------------------------------
  void begin_step(std::span<const double> u, const std::optional<std::array<double, 3>>& displacement,
                  std::span<const double> target = {}) override;
  std::optional<std::array<double, 3>> displacement() const override;
  void set_rotation(const gap::Matrix3& rotation) override;
  std::optional<gap::Matrix3> rotation() const override;
  std::array<double, 3> centre() const override;
  state::State state() override;
  void accept_step() override;
  std::string prescribed_overlap() override;
  std::string passed_through() override;
  /// Force, moment, area and work of friction of the present state. Collective.
  void update_totals();

  // --- Newton iterations ---------------------------------------------------------------------------------------------
  void update_gap(std::span<const double> u) override;
  int update_active_set(bool first, std::optional<std::int64_t> last = {}) override;
  std::vector<double> contact_forces() const override { return _geometry->forces(traction()); }
  void add_residual(Vec b) const override;
  void update_nodal_stiffness(Mat K) override;
  Mat tangent() override;
  std::int64_t num_active() const override;
  double violation() const override;
  std::string largest_violation() const override;
  std::string mesh_advice() const override;
  double smallest_gap() const override;
  state::State saved_state() override;
  void resume(const state::State& saved, std::span<const double> u) override;
  void forget() override { _geometry->forget(); }
  std::vector<double> rigid_body_products(const operators::RigidBodyModes& modes) const override;
  bool close_nearest() override;
  /// Open the nodes that are apart, after bodies were moved without a solution; call after update_gap.
  void open_apart();

  // --- multipliers ---------------------------------------------------------------------------------------------------
  std::span<const std::int32_t> nodes() const override { return _geometry->nodes(); }
  std::span<const std::int64_t> numbers() const override { return _geometry->numbers(); }
  std::span<const std::int8_t> active() const override { return _state.active; }
  std::span<const std::int8_t> sliding() const override { return _state.sliding; }
  std::span<const double> multiplier() const override { return _state.multiplier; }
  std::int64_t last_change() const override { return _last_change; }
  void update_multipliers(std::span<const double> residual) override;
  double gap_round_off() const override;
  Constraints constraints() override;
  std::optional<std::pair<Mat, std::vector<double>>> friction_springs() override;
  std::vector<double> imposed_friction_forces() const override;
  void update_linearised_gap(std::span<const double> increments) override;
  std::pair<std::vector<double>, std::vector<double>>
  linearised_response(std::span<const double> increments, std::span<const double> forces) const override;
  void correct_linearisation(std::span<const double> u) override;
  void set_multipliers(std::span<const double> forces) override;
  std::int64_t num_turning() const override;
  void set_redundant(std::span<const std::int32_t> redundant) override;
  std::vector<std::int32_t> over_constrained() const override;
  void rotate_friction_traction() override;
  void predict_active_set(std::span<const double> increments, double part) override;
  std::vector<double> unit_gap(std::int64_t number) const override;
  std::vector<double> unit_force(std::int64_t number) const override;
  std::span<const double> linearised_gap() const override { return _linearised.gap; }
  void set_linearised(std::span<const std::int8_t> active, std::span<const double> gap,
                      std::span<const double> multiplier) override;

  // --- results -------------------------------------------------------------------------------------------------------
  std::vector<double> points() const override { return _geometry->now().points; }
  std::vector<double> gap() const override { return _geometry->now().gap; }
  std::vector<double> normal() const override { return _geometry->now().normal; }
  std::vector<double> pressure() const override;
  std::vector<double> traction() const override;
  std::vector<double> slip() const override { return _state.total_slip; }
  std::vector<ContactStatus> status() const override;
  std::vector<double> weight() const override { return _geometry->now().own_cover; }
  std::vector<double> covered() const override;
  std::optional<std::array<double, 3>> force() const override { return _totals.known_force(); }
  double dissipated() const override { return _totals.dissipated; }

  // --- for those who solve for the multipliers themselves, as rolling does
  /// State of the nodes. Sizes stay as they are.
  MortarState& nodal_state() { return _state; }
  const MortarState& nodal_state() const { return _state; }
  CoulombFriction& coulomb() { return _coulomb; }
  /// Nodes that carry a multiplier and may be moved along the normal.
  const std::vector<std::int8_t>& usable() const { return _usable; }
  /// Stiffness of the bodies at the nodes [F/L].
  const std::vector<double>& nodal_stiffness() const { return _nodal_stiffness; }
  /// Coefficients of this pair's law of friction. Collective.
  /// @param[in] pressure by node [F/L^2]
  /// @param[in] slip_rate [i*gdim + c] [L/T]
  /// @throws common::BadValue where the law returns no finite number, on all ranks
  FrictionCoefficients law_coefficients(std::span<const double> pressure, std::span<const double> slip_rate) const;
  /// Points of the law at all nodes, with normals and fields. Collective where the law reads fields.
  FrictionPoints law_points() const;
  /// Coefficients of friction at the nodes [1]. Collective with a law, in rolling problems.
  virtual std::vector<double> friction_coefficients() const { return coefficients(); }
  /// Gaps of nodes that are open, zero at others [L].
  std::vector<double> opened(std::span<const double> gap) const;

  // --- nodes that belong to several pairs
  /// Another contact with which nodes are joined.
  struct Partner
  {
    MortarContact* contact;
    std::vector<std::int32_t> index; ///< of each node among the partner's, -1 without
  };
  /// Another contact that constrains nodes of this one along another normal.
  struct Edge
  {
    const MortarContact* contact;
    std::vector<std::int32_t> mine, theirs; ///< indices of the nodes among this contact's and among its own
  };
  /// The other contacts of a problem with common nodes; they live as long as this one is used.
  std::vector<Partner> partners;
  std::vector<Edge> edges;

private:
  /// Views of the state of the nodes, with the arrays that are computed for them.
  struct Present
  {
    std::vector<double> stiffness, lock, roughness;
    NodalMultipliers nodes;
  };
  /// Views of the geometry that the linear problem is linearised about.
  struct Linearisation
  {
    std::vector<double> ahead;
    NodalGeometry nodes;
  };
  Present present() const;
  Linearisation linearisation() const;
  bool has_law() const { return _options.friction_law && _options.slip == Slip::of_increments; }
  bool any_law() const;
  double own_friction() const;
  bool has_own_friction() const;
  void update_coefficients();
  std::vector<double> coefficients() const;
  std::vector<std::int8_t> touching() const;
  std::vector<std::int8_t> loaded() const;
  std::vector<double> still() const;
  void tell_partners();
  void set(std::span<const double> multiplier, std::span<const double> traction);
  std::vector<double> tilt() const;
  std::vector<double> at_nodes(std::span<const double> values) const;
  double largest_multiplier() const;

  MortarOptions _options;
  std::unique_ptr<MortarGeometry> _geometry;
  gap::InitialPenetration _initial;
  MortarState _state;
  ContactTotals _totals;
  CoulombFriction _coulomb;
  NodalFrames _frames;
  std::vector<std::int8_t> _usable, _redundant, _crowded;
  std::vector<double> _nodal_stiffness, _facing_stiffness; ///< of the bodies at the nodes and opposite to them [F/L]
  GapAndSlip _at;                                          ///< that the linear problem is linearised about
  GapAndSlip _linearised;                                  ///< of the present linear solution
  std::vector<double> _linear_tilt;                        ///< friction_tilt of the last constraints
  std::int64_t _last_change = -1;
  std::optional<gap::Matrix3> _next_rotation; ///< of the increment that begins next
  double _time_step = 0.0;                    ///< of the increment; zero: there is no time [T]
};
} // namespace dolfinx_impact::enforcement
